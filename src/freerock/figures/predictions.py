"""Peaks of a run as a band that the other runs of its record foretell, and as measured."""

import pandas as pd
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from freerock.figures import style
from freerock.figures.by_scene import HEIGHT_IN, MARKERS, SHADES, run_handles
from freerock.figures.style import Axes, Drawing, Labels, styled
from freerock.models.laws import MODEL_LABELS

TICKS = (1.0, 2.0, 3.0, 5.0)  # of a decade


@styled()
def draw(predictions: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """Band of |θ_n| over n for the first run of each scene, with the peaks of all its runs.

    Parameters
    ----------
    predictions : pandas.DataFrame
        Tidy table.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        The table.
    """
    if predictions.empty:
        return style.nothing_drawn(
            "nothing is foretold: no record has two runs with a selected law", origin
        ), predictions
    figure, panels = style.panel_per_scene(style.scenes_in(predictions), labels, HEIGHT_IN)
    for (block, foundation), ax in panels.items():
        _panel(ax, style.of_scene(predictions, block, foundation))
    style.outer_labels(panels.values(), "number of impacts n", "peak |θₙ| / °")
    most = int(predictions.groupby("test")["run"].nunique().max())
    shown = panels[next(iter(panels))].get_legend_handles_labels()[0]
    style.finish(figure, origin, [*shown, *run_handles(most, str(style.recorded(origin)["label"]))])
    return figure, predictions


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many peaks lie in the band, and of which laws it is."""
    if data.empty:
        return ""
    laws = ", ".join(MODEL_LABELS[model] for model in data["model"].unique())
    return f"Law: {laws}. {data['inside'].sum()} of {len(data)} peaks lie in the band of their own run."


def _panel(ax: Axes, own: pd.DataFrame) -> None:
    """A scene: the band of its first run, markers of all its runs."""
    runs = list(own.groupby(["test", "run"], sort=False))
    _, first = runs[0]
    ax.fill_between(
        first["peak"], first["low_deg"], first["high_deg"], color="0.85", label="95 % band, first run"
    )
    ax.plot(first["peak"], first["median_deg"], color="0.5", linewidth=0.8, label="median")
    for i, (_, rows) in enumerate(runs):
        look = {"marker": MARKERS[i % len(MARKERS)], "color": SHADES[i % len(SHADES)]}
        ax.plot(rows["peak"], rows["peak_deg"], linestyle="", markerfacecolor="none", **look)
    ax.set(yscale="log", xlim=(0.5, own["peak"].max() + 0.5))
    ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    ax.yaxis.set_major_locator(LogLocator(subs=TICKS))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_locator(NullLocator())
