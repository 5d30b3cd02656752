"""Effect of the foundation: Spanos et al. 2017, figure 2 (doi:10.1016/j.proeng.2017.09.024)."""

from collections.abc import Sequence
from itertools import cycle
from math import degrees

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures import style
from freerock.figures.style import Drawing, Labels, styled
from freerock.products.contents import usable_runs
from freerock.tables.number_text import fixed, in_words

READS = {"records": ("time", "theta", "theta0", "release", "end")}
MOST_BELOW = 4  # blocks, each below the other; more stand side by side
OF_PAPER = {"6": "marble", "4": "marble", "2": "aerstop"}  # by h/b, where a block of the paper rocks longer


Release = tuple[float, xr.DataTree, int]
"""A run with its release angle [°]: its record and its number there."""


@styled()
def draw(records: Sequence[xr.DataTree], origin: str, labels: Labels = None) -> Drawing:
    """θ(t) of a usable run on each foundation, one panel per block: the runs released most alike.

    Parameters
    ----------
    records : sequence of xarray.DataTree
        Record datasets.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns block, foundation, test, run, time_s (since the release), theta_deg (positive there).
    """
    blocks = list(dict.fromkeys(tree.attrs["block"] for tree in records))
    foundations = dict.fromkeys(tree.attrs["foundation"] for tree in records)
    looks = dict(zip(foundations, cycle(style.FOUNDATION_STYLES)))
    beside = 1 if len(blocks) <= MOST_BELOW else style.fit_beside(len(blocks), style.ALONE_IN)
    rows = -(-len(blocks) // beside)
    figure = Figure(figsize=(style.WIDTH_IN, 0.6 + 1.75 * rows))
    axes = figure.subplots(rows, beside, squeeze=False).ravel()
    parts = []
    for i, (ax, block) in enumerate(zip(axes, blocks, strict=False)):
        ax.axhline(0, color="0.6", linewidth=0.5)
        chosen = _alike([_releases(tree) for tree in records if tree.attrs["block"] == block])
        for release in chosen:
            parts.append(curve := _curve(*release))
            ax.plot(curve["time_s"], curve["theta_deg"], **looks[curve["foundation"].iloc[0]])
        angles = in_words([f"{fixed(abs(alpha), 1)}°" for alpha, *_ in chosen] or ["–"])
        told = f"α = {angles}\n{in_words([f'run {number}' for *_, number in chosen])}"
        ax.text(0.99, 0.97, told, ha="right", va="top", transform=ax.transAxes)
        style.entitle(ax, i, len(blocks), style.label(labels, block), 0.9 / beside)
        ax.set_xlim(left=0)
    for ax in axes[len(blocks) :]:
        ax.set_axis_off()
    style.outer_labels(axes[: len(blocks)], "time since release / s", "θ / °")
    lines = [Line2D([], [], **look, label=style.label(labels, name)) for name, look in looks.items()]
    style.finish(figure, origin, lines)
    return figure, style.gathered(parts, ["block", "foundation", "test", "run", "time_s", "theta_deg"])


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """On which foundation the run of each block lasts longest, whether so in the paper; the runs drawn."""
    return " ".join(filter(None, [_longest(data, labels), style.drawn_runs(data)]))


def _longest(data: pd.DataFrame, labels: Labels) -> str:
    """On which foundation each block rocks longest, and whether it does so in the paper."""
    if data["foundation"].nunique() < 2:
        return "There is one foundation: none is compared." if len(data) else ""
    named, of_base, of_paper = labels or {}, dict[str, list[str]](), dict[str, list[str]]()
    for block, curves in data.astype({"block": str}).groupby("block", sort=False):
        last = curves.groupby("foundation", sort=False)["time_s"].max()
        longest = str(last.idxmax())
        name, _, slenderness = named.get(str(block), str(block)).partition(", h/b = ")
        if len(last) > 1:
            of_base.setdefault(named.get(longest, longest), []).append(name)
        if {*OF_PAPER.values()} <= {*last.index} and slenderness in OF_PAPER:
            found = "the same" if longest == OF_PAPER[slenderness] else "the reverse"
            of_paper.setdefault(found, []).append(name)
    more, n = "longer" if data["foundation"].nunique() == 2 else "longest", data["block"].nunique()
    told = [f"{_who(blocks, n)} {more} on {base}." for base, blocks in of_base.items()]
    if of_paper:
        whose = ", ".join(f"{found} of {in_words(blocks)}" for found, blocks in of_paper.items())
        told.append(f"The paper (Spanos et al. 2017, figure 2) finds {whose}.")
    return " ".join(told) or "No block rocks on two foundations: none is compared."


def _who(blocks: Sequence[str], n: int) -> str:
    """Which of n blocks rock."""
    if len(blocks) == n > 1:
        return "Every block rocks"
    return f"{in_words(blocks)} rock{'s' * (len(blocks) == 1)}"


def _releases(tree: xr.DataTree) -> list[Release]:
    return [(degrees(run["theta0"].item()), tree, number) for number, run in usable_runs(tree).items()]


def _alike(known: Sequence[Sequence[Release]]) -> Sequence[Release]:
    """A run of each record that has one: those whose release angles differ least."""
    known = [own for own in known if own]
    nearest = (
        [min(own, key=lambda each: abs(abs(each[0]) - abs(first[0]))) for own in known]
        for first in (known[0] if known else ())
    )
    return min(nearest, key=lambda chosen: float(np.ptp([abs(each[0]) for each in chosen])), default=())


def _curve(alpha_deg: float, tree: xr.DataTree, number: int) -> pd.DataFrame:
    time, run = tree.dataset["time"].values, usable_runs(tree)[number].dataset
    release, end = run["release"].item(), run["end"].item()
    during = np.flatnonzero((time >= release) & (time <= end))
    during = during[style.thin(len(during))]
    return pd.DataFrame(
        {
            **{name: tree.attrs[name] for name in ("block", "foundation", "test")},
            "run": number,
            "time_s": time[during] - release,
            "theta_deg": np.degrees(tree.dataset["theta"].values[during]) * np.sign(alpha_deg),
        }
    )
