"""A panel for each block on a foundation: the impacts of its runs, and those of the three laws."""

from collections.abc import Callable, Mapping
from itertools import cycle
from typing import NamedTuple

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from freerock.arrays import Floats
from freerock.figures import looks, style
from freerock.figures.style import Axes, Drawing, Labels, Style
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, PAPER_MODELS
from freerock.tables.swings import first_runs, swings

MARKERS = "os^Dv<>p*h"  # of the runs of a record
SHADES = ("0.1", "0.45", "0.65")
HEIGHT_IN = 2.0


class Shown(NamedTuple):
    """What is drawn: a column of `tables.swings` against the amplitude, its label, and a rigid block's."""

    y: str
    label: str
    rigid: Callable[[Block, float], tuple[Floats, Floats]]
    y_u: str = ""
    scatters: bool = False  # whether it has the band of the selected law's σ_r


def draw_by_scene(
    shown: Shown,
    tables: tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame],
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels,
) -> Drawing:
    """Draw all runs, and the laws fitted to the first of each scene, against |θ| over the critical angle.

    Parameters
    ----------
    shown : Shown
    tables : tuple of pandas.DataFrame
        The tidy tables runs, restitution and epsilon.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of `freerock.tables.swings.swings`.
    """
    runs, restitution, epsilon = tables
    found = swings(runs, restitution, epsilon, blocks)
    seen = found[found["source"] == "experiment"]
    modelled = first_runs(found)
    data = pd.concat([seen, modelled[modelled["source"].isin(PAPER_MODELS)]], ignore_index=True)
    data = data[data[shown.y].notna()]
    scenes = style.scenes_in(runs)
    figure, panels = style.panel_per_scene(scenes, labels, HEIGHT_IN)
    for (block, foundation), ax in panels.items():
        own = style.of_scene(data, block, foundation)
        _panel(ax, shown, own)
        if shown.scatters:
            _scatter(ax, shown, own, epsilon)
        highest = own["amplitude"].max() if len(own) else 1.0
        x, y = shown.rigid(blocks[block], highest)
        ax.plot(x, y, color="0.45", linestyle=":")
        ax.margins(0.04)
        ax.set_xlim(left=0)
    style.outer_labels(panels, "amplitude |θ|/$θ_{cr}$", shown.label)
    points: Style = {
        "marker": "o",
        "color": SHADES[0],
        "linestyle": "",
        "markerfacecolor": "none",
        "markersize": 3,
    }
    handles: list[Artist] = [Line2D([], [], label=f"runs, {style.recorded(origin)['label']}", **points)]
    handles += [
        Line2D([], [], **looks.MODEL_STYLES[law]) for law in PAPER_MODELS if law in set(data["source"])
    ]
    handles += [Line2D([], [], color="0.45", linestyle=":", label="rigid block (Housner 1963)")]
    if shown.scatters and epsilon.get("sigma_r", pd.Series(dtype=float)).gt(0).any():
        handles += [Patch(color="0.88", label="95 % of impacts, selected law and σ$_r$")]
    style.finish_with(figure, origin, handles)
    return figure, data


def _panel(ax: Axes, shown: Shown, own: pd.DataFrame) -> None:
    """A scene: signs of each run, lines of the laws."""
    seen = own[own["source"] == "experiment"]
    looks_of_runs = zip(cycle(MARKERS), cycle(SHADES))
    runs = (rows for _, rows in seen.groupby(["test", "run"], sort=False))
    for rows, (marker, shade) in zip(runs, looks_of_runs, strict=False):
        point = {"color": shade, "marker": marker, "linestyle": "", "markersize": 3, "markeredgewidth": 0.7}
        bars = rows[shown.y_u] if shown.y_u else None
        ax.errorbar(
            rows["amplitude"],
            rows[shown.y],
            bars,
            elinewidth=0.6,
            markerfacecolor="none",
            **point,
        )
    for law in PAPER_MODELS:
        rows = own[own["source"] == law].sort_values("amplitude")
        if len(rows):
            ax.plot(rows["amplitude"], rows[shown.y], **looks.MODEL_STYLES[law])


def _scatter(ax: Axes, shown: Shown, own: pd.DataFrame, epsilon: pd.DataFrame) -> None:
    """The band that holds 95 % of the impacts by the scatter σ_r of the law selected for the first run."""
    for model, sigma_r in _selected(own, epsilon):
        rows = own[own["source"] == CANDIDATES[model].law].sort_values("amplitude")
        ends = (rows[shown.y] * (1 + sign * NORMAL_95 * sigma_r) for sign in (-1, 1))
        ax.fill_between(rows["amplitude"], *ends, color="0.88", zorder=0, linewidth=0)


def _selected(own: pd.DataFrame, epsilon: pd.DataFrame) -> list[tuple[str, float]]:
    """The candidate selected for the first run of a scene, and σ_r."""
    modelled = own[own["source"] != "experiment"]
    if modelled.empty or "sigma_r" not in epsilon:
        return []
    test, run = modelled[["test", "run"]].iloc[0]
    rows = epsilon[(epsilon["test"] == test) & (epsilon["run"] == run) & epsilon["selected"].astype(bool)]
    return [(str(row["model"]), float(row["sigma_r"])) for _, row in rows.iterrows() if row["sigma_r"] > 0]


def caption_of(point: str) -> Callable[..., str]:
    """The function `caption` of such a figure, whose points are impacts or what `point` says."""

    def caption(data: pd.DataFrame, labels: Labels = None) -> str:
        """How many points and runs are drawn."""
        seen = data[data["source"] == "experiment"]
        n = len(seen[["test", "run"]].drop_duplicates())
        return f"{style.number_of(len(seen), point).capitalize()} of {style.number_of(n, 'run')}."

    return caption
