"""Peaks of a run as a band that the other runs of its record predict, and as measured."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from freerock.figures import style
from freerock.figures.by_scene import HEIGHT_IN, run_handles, run_looks
from freerock.figures.style import Axes, Drawing, Labels, Style, styled
from freerock.models.laws import MODEL_LABELS

TICKS = (1.0, 2.0, 3.0, 5.0)  # of a decade
BAND, MEDIAN = "95 % band, longest run", "median"
ABOUT_BAND = (
    "Band: 95 % of 200 motions. Their parameters are drawn about those of the other runs of the record, and "
    "each impact scatters by σ_r; the release is the run's own. Each run has a band; drawn is that of the "
    "longest run."
)


@styled()
def draw(predictions: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """Band of |θ_n| over n for the run with most peaks of each scene, with the peaks of all its runs.

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
            "nothing is predicted: no record has two runs with a selected law", origin
        ), predictions
    figure, panels = style.panel_per_scene(style.scenes_in(predictions), labels, HEIGHT_IN)
    looks_of_runs = run_looks(predictions)
    for (block, foundation), ax in panels.items():
        _panel(ax, style.of_scene(predictions, block, foundation), looks_of_runs)
    style.outer_labels(panels.values(), "number of impacts n", "peak |θₙ| / °")
    shown = [each for name, each in style.shown(figure).items() if name in (BAND, MEDIAN)]
    runs = run_handles(looks_of_runs, str(style.recorded(origin)["label"]))
    style.finish(figure, origin, [*shown, *runs])
    return figure, predictions


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """What the band is, of which laws, and how many peaks lie in the band of their run."""
    if data.empty:
        return "Nothing is predicted."
    laws = ", ".join(MODEL_LABELS[model] for model in data["model"].unique())
    inside = f"{data['inside'].sum()} of {len(data)} peaks lie in the band of their own run."
    return f"{ABOUT_BAND} Law: {laws}. {inside}"


def _panel(ax: Axes, own: pd.DataFrame, looks_of_runs: Mapping[tuple[str, str], Style]) -> None:
    """A scene: the band of its run with most peaks, markers of all its runs."""
    runs = {key: rows for key, rows in own.groupby(["test", "run"], sort=False)}
    longest = max(runs.values(), key=len)
    if len(longest) > 1:
        peak, low, median, high = (longest[name] for name in ("peak", "low_deg", "median_deg", "high_deg"))
        ax.fill_between(peak, low, high, color="0.85", label=BAND)
        ax.plot(peak, median, color="0.5", linewidth=0.8, label=MEDIAN)
    for (test, run), rows in runs.items():
        ax.plot(rows["peak"], rows["peak_deg"], **looks_of_runs[str(test), str(run)])
    ax.set(yscale="log", xlim=(0.5, own["peak"].max() + 0.5))
    ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    ax.yaxis.set_major_locator(LogLocator(subs=TICKS))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_locator(NullLocator())
