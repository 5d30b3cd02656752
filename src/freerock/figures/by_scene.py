"""A panel for each block on a foundation: the impacts of its runs, and those of the three laws."""

from collections.abc import Callable, Mapping
from itertools import cycle

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from freerock.arrays import Floats
from freerock.figures import looks, style
from freerock.figures.style import Axes, Drawing, Labels, styled
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, MODEL_LABELS, PAPER_MODELS
from freerock.tables.number_text import fixed, number_of
from freerock.tables.swings import first_runs, swings

MARKERS = "os^Dv<>p*h"  # of the runs of a record
SHADES = ("0.1", "0.45", "0.65")
HEIGHT_IN = 2.0
MOST_NAMED = 4  # runs in a legend


def figure_of(
    y: str, label: str, point: str, rigid: Callable[[Block, float], tuple[Floats, Floats]]
) -> tuple[Callable[..., Drawing], Callable[..., str]]:
    """The functions `draw` and `caption` of a figure of all impacts against |θ| over the critical angle.

    Parameters
    ----------
    y : str
        Column of `freerock.tables.swings.swings`. r has bars, and the band of the selected law's σ_r.
    label, point : str
        Label of its axis, and what a marker stands for.
    rigid : callable
        Of a block and the largest amplitude, the line of a rigid block.
    """

    @styled()
    def draw(
        runs: pd.DataFrame,
        restitution: pd.DataFrame,
        epsilon: pd.DataFrame,
        blocks: Mapping[str, Block],
        origin: str,
        labels: Labels = None,
    ) -> Drawing:
        """Draw all runs, and the laws fitted to the first of each scene, of tidy tables.

        Returned are the figure and the numbers drawn, in the columns of `freerock.tables.swings.swings`.
        """
        found = swings(runs, restitution, epsilon, blocks)
        modelled = first_runs(found)
        drawn = [found[found["source"] == "experiment"], modelled[modelled["source"].isin(PAPER_MODELS)]]
        data = pd.concat(drawn, ignore_index=True)
        data = data[data[y].notna()]
        scatter = _scatter(data, epsilon) if y == "r" else data[:0]
        figure, panels = style.panel_per_scene(style.scenes_in(runs), labels, HEIGHT_IN)
        for scene, ax in panels.items():
            own = style.of_scene(data, *scene)
            _panel(ax, y, own, style.of_scene(scatter, *scene))
            if 0 < own["amplitude"].max() < 1:
                ax.plot(*rigid(blocks[scene[0]], own["amplitude"].max()), color="0.45", linestyle=":")
            ax.margins(0.04)
            ax.set_xlim(left=0)
            told = _absent(own, style.of_scene(epsilon, *scene)) + (_far_off(ax, own) if y == "r" else [])
            at, side = (0.02, "left") if y == "r" else (0.98, "right")
            ax.text(at, 0.04, "\n".join(told), ha=side, transform=ax.transAxes)
        style.outer_labels(panels.values(), "amplitude |θ|/$θ_{cr}$", label)
        style.finish(figure, origin, _handles(data, origin, bool(len(scatter))))
        return figure, data

    def caption(data: pd.DataFrame, labels: Labels = None) -> str:
        """How many points and runs are drawn."""
        seen = data[data["source"] == "experiment"]
        n = len(seen[["test", "run"]].drop_duplicates())
        return f"{number_of(len(seen), point).capitalize()} of {number_of(n, 'run')}."

    return draw, caption


def _marker(marker: str, shade: str) -> style.Style:
    return {"marker": marker, "color": shade, "linestyle": "", "markerfacecolor": "none", "markersize": 3}


def run_handles(n: int, kind: str) -> list[Line2D]:
    """The markers of the first to the n-th run of a record, of which some stand for the rest."""
    names = [f"run {i + 1}" for i in range(min(n, MOST_NAMED))]
    names[0] = f"{kind}: {names[0]}"
    looks_of = zip(cycle(MARKERS), cycle(SHADES), strict=False)
    return [Line2D([], [], label=name, **_marker(*look)) for name, look in zip(names, looks_of, strict=False)]


def _panel(ax: Axes, y: str, own: pd.DataFrame, band: pd.DataFrame) -> None:
    """A scene: markers of each run, lines of the laws, the band of scattered impacts."""
    seen = own[own["source"] == "experiment"].groupby(["test", "run"], sort=False)
    for (_, rows), marker, shade in zip(seen, cycle(MARKERS), cycle(SHADES), strict=False):
        bars = rows["r_u"] if y == "r" else None
        ax.errorbar(rows["amplitude"], rows[y], bars, elinewidth=0.6, **_marker(marker, shade))
    for law in PAPER_MODELS:
        rows = own[own["source"] == law].sort_values("amplitude")
        ax.plot(rows["amplitude"], rows[y], **looks.line_of(law))
    if len(band):
        ends = (band[y] * (1 + sign * NORMAL_95 * band["sigma_r"]) for sign in (-1, 1))
        ax.fill_between(band["amplitude"], *ends, color="0.88", zorder=0, linewidth=0)


def _handles(data: pd.DataFrame, origin: str, scatters: bool) -> list[Artist]:
    """What the markers and lines of all panels stand for."""
    seen = data[data["source"] == "experiment"].drop_duplicates(["test", "run"])
    most = int(seen.groupby("test").size().max()) if len(seen) else 1
    handles: list[Artist] = list(run_handles(most, str(style.recorded(origin)["label"])))
    known = [law for law in PAPER_MODELS if law in set(data["source"])]
    handles += [Line2D([], [], **looks.line_of(law)) for law in known]
    handles += [Line2D([], [], color="0.45", linestyle=":", label="rigid block (Housner 1963)")]
    return handles + [Patch(color="0.88", label="95 % of impacts, selected law and σ$_r$")] * scatters


def _absent(own: pd.DataFrame, epsilon: pd.DataFrame) -> list[str]:
    """Why laws that were fitted to the first run have no line."""
    first = own[own["source"] == "experiment"][["test", "run"]].astype(str).head(1)
    fits = epsilon.astype({"run": str}).merge(first)
    fits = fits[fits["model"].isin(set(PAPER_MODELS) - set(own["source"]))].drop_duplicates("model")
    why = {True: "at rest after one impact", False: "failed fit"}
    return [f"{MODEL_LABELS[row.model]}: {why[bool(row.success)]}" for row in fits.itertuples()]


def _far_off(ax: Axes, own: pd.DataFrame) -> list[str]:
    """A law whose r lies far from what was measured is told in words, and does not rule the axis."""
    seen = own[own["source"] == "experiment"]["r"]
    room = 2 * max(0.05, seen.max() - seen.min())
    told = [
        f"{MODEL_LABELS[law]}: {fixed(r.median(), 3)}"
        for law, r in own[own["source"] != "experiment"].groupby("source")["r"]
        if r.max() < seen.min() - room or r.min() > seen.max() + room
    ]
    if told:
        low, high = ax.get_ylim()
        ax.set_ylim(max(low, seen.min() - room), min(high, seen.max() + room))
    return told


def _scatter(data: pd.DataFrame, epsilon: pd.DataFrame) -> pd.DataFrame:
    """The impacts of the law selected for the first run of each scene, with its σ_r."""
    scattered = epsilon[epsilon["selected"].astype(bool) & (epsilon["sigma_r"] > 0)]
    own = scattered[["test", "run", "sigma_r"]].assign(
        source=[CANDIDATES[model].law for model in scattered["model"]]
    )
    keys = ["test", "run", "source"]
    known = own.astype({"run": str}), data.astype({"run": str})
    return known[1].merge(known[0], on=keys).sort_values("amplitude")
