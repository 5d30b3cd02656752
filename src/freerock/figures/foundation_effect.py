"""Effect of the foundation: Spanos et al. 2017, figure 2 (doi:10.1016/j.proeng.2017.09.024)."""

from collections.abc import Sequence
from itertools import cycle

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures import style
from freerock.figures.style import Drawing, Labels, styled
from freerock.products.groups import usable_runs

MOST_BELOW = 4  # blocks, each below the other; more stand side by side


@styled()
def draw(records: Sequence[xr.DataTree], origin: str, labels: Labels = None) -> Drawing:
    """θ(t) of the first usable run on each foundation, one panel per block.

    Parameters
    ----------
    records : sequence of xarray.DataTree
        Record datasets.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns block, foundation, test, run, time_s (since the release), theta_deg.
    """
    blocks = list(dict.fromkeys(tree.attrs["block"] for tree in records))
    foundations = dict.fromkeys(tree.attrs["foundation"] for tree in records)
    looks = dict(zip(foundations, cycle(style.FOUNDATION_STYLES)))
    curves: dict[tuple[str, str], pd.DataFrame] = {}
    for tree in records:
        for number, run in list(usable_runs(tree).items())[:1]:
            scene = (tree.attrs["block"], tree.attrs["foundation"])
            curves.setdefault(scene, _curve(tree, number, run))

    beside = 1 if len(blocks) <= MOST_BELOW else style.fit_beside(len(blocks), style.ALONE_IN)
    rows = -(-len(blocks) // beside)
    figure = Figure(figsize=(style.WIDTH_IN, 0.6 + 1.75 * rows))
    axes = figure.subplots(rows, beside, squeeze=False).ravel()
    for i, (ax, block) in enumerate(zip(axes, blocks, strict=False)):
        ax.axhline(0, color="0.6", linewidth=0.5)
        for foundation, look in looks.items():
            if (block, foundation) in curves:
                curve = curves[block, foundation]
                ax.plot(curve["time_s"], curve["theta_deg"], **look)
        style.entitle(ax, i, len(blocks), style.label(labels, block), 0.9 / beside)
        ax.set_xlim(left=0)
    for ax in axes[len(blocks) :]:
        ax.set_axis_off()
    style.outer_labels(dict(enumerate(axes[: len(blocks)])), "time since release / s", "θ / °")
    lines = [Line2D([], [], **look, label=style.label(labels, name)) for name, look in looks.items()]
    style.finish(figure, origin, lines)
    columns = ["block", "foundation", "test", "run", "time_s", "theta_deg"]
    return figure, style.gathered(curves.values(), columns)


caption = style.drawn_runs


def _curve(tree: xr.DataTree, number: int, run: xr.DataTree) -> pd.DataFrame:
    time = tree.dataset["time"].values
    release, end = run.dataset["release"].item(), run.dataset["end"].item()
    during = np.flatnonzero((time >= release) & (time <= end))
    during = during[style.thin(len(during))]
    return pd.DataFrame(
        {
            **{name: tree.attrs[name] for name in ("block", "foundation", "test")},
            "run": number,
            "time_s": time[during] - release,
            "theta_deg": np.degrees(tree.dataset["theta"].values[during]),
        }
    )
