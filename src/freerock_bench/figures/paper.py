"""Figure of the study of the published tables (doi:10.1016/j.proeng.2017.09.024)."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures.style import FOUNDATION_STYLES, Axes, Drawing, note_simulated, styled
from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS

FIGURE = {
    "caption": "The published models of tables 2 and 3 set against one another; all motions are simulated."
}

BLOCK_MARKERS = "osD^v"


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """Re-identified over published parameters, and the distances of the published models in their bounds."""
    figure = Figure(figsize=(7.0, 3.2))
    left, right = figure.subplots(1, 2)
    colours = {
        name: style["color"]
        for name, style in zip(frame["foundation"].unique(), FOUNDATION_STYLES, strict=False)
    }
    markers = dict(zip(frame["block"].unique(), BLOCK_MARKERS, strict=False))
    left.set_title("(a) Table 2, identified on Hunt–Crossley motion", loc="left")
    right.set_title("(b) Table 3: distances and their bounds", loc="left")
    _ratios(left, frame[(frame["table"] == 2) & frame["published"].notna()], colours, markers)
    _distances(right, frame[frame["table"] == 3], colours)
    handles = [Line2D([], [], color=c, linewidth=3, label=name) for name, c in colours.items()]
    handles += [
        Line2D([], [], color="0.3", linestyle="", marker=marker, label=name)
        for name, marker in markers.items()
    ]
    if (frame["message"].dropna() != "converged").any():
        handles.append(
            Line2D(
                [], [], color="0.3", marker="o", linestyle="", markerfacecolor="white", label="not to be used"
            )
        )
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    note_simulated(figure)
    return figure, frame


def _ratios(ax: Axes, rows: pd.DataFrame, colours: Mapping[str, str], markers: Mapping[str, str]) -> None:
    """A line of points per parameter: the longest span as a marker, the others within the bar."""
    quantities = list(rows.groupby(["model", "quantity"], sort=False).groups)
    offsets = np.linspace(-0.3, 0.3, len(colours) * len(markers))
    scenes = [(foundation, block) for foundation in colours for block in markers]
    for (foundation, block), offset in zip(scenes, offsets, strict=True):
        scene = rows[(rows["foundation"] == foundation) & (rows["block"] == block)]
        for i, (model, quantity) in enumerate(quantities):
            spans = scene[(scene["model"] == model) & (scene["quantity"] == quantity)]
            ratio = (spans["value"] / spans["published"]).to_numpy()
            usable = spans["message"].iloc[-1].startswith("converged")
            style = {"color": colours[foundation], "marker": markers[block], "markersize": 4}
            ax.plot([ratio.min(), ratio.max()], [i + offset] * 2, color=style["color"], linewidth=0.8)
            ax.plot(ratio[-1], i + offset, **style, markerfacecolor=style["color"] if usable else "white")
    names = [f"{MODEL_LABELS[model]} {SYMBOLS[quantity]}" for model, quantity in quantities]
    ax.set(yticks=range(len(names)), yticklabels=names, xscale="log", ylim=(len(names) - 0.5, -0.5))
    ticks = [tick for tick in (0.5, 0.7, 1, 1.4, 2) if ax.get_xlim()[0] <= tick <= ax.get_xlim()[1]]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()
    ax.margins(x=0.05)
    ax.axvline(1, color="0.6", linewidth=0.8)
    ax.set_xlabel("re-identified over published value (table 2)")


def _distances(ax: Axes, rows: pd.DataFrame, colours: Mapping[str, str]) -> None:
    """A bar per pair of models from bound to bound, with the distance over each span in it."""
    pairs = list(rows.groupby(["model", "against"], sort=False).groups)
    for (foundation, colour), offset in zip(
        colours.items(), np.linspace(-0.15, 0.15, len(colours)), strict=True
    ):
        for i, (model, against) in enumerate(pairs):
            pair = rows[
                (rows["foundation"] == foundation) & (rows["model"] == model) & (rows["against"] == against)
            ]
            bounds = 100 * pair[["low", "high"]].iloc[0]
            ax.plot(bounds, [i + offset] * 2, color=colour, linewidth=6, alpha=0.25, solid_capstyle="butt")
            ax.plot(100 * pair["value"], [i + offset] * len(pair), "|", color=colour, markersize=7)
            last = pair.iloc[-1]
            ax.annotate(
                f"{last['final_time_s']:g} s",
                (100 * last["value"], i + offset),
                (0, 5 if offset < 0 else -5),
                textcoords="offset points",
                ha="center",
                va="bottom" if offset < 0 else "top",
                fontsize=6,
                color=colour,
            )
    names = [f"{MODEL_LABELS[one]} –\n{MODEL_LABELS[other]}" for one, other in pairs]
    ax.set(yticks=range(len(names)), yticklabels=names, xscale="log", ylim=(len(names) - 0.5, -0.5))
    ax.xaxis.set_major_formatter("{x:g}")
    ax.margins(x=0.05)
    ax.set_xlabel("$ε$ between two published models / %")
