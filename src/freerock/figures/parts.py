"""Parameters of each part of a run: whether a law holds throughout the run."""

import pandas as pd

from freerock.figures import looks, style
from freerock.figures.style import Axes, Drawing, Labels, printed
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.free_parameters import SYMBOLS
from freerock.tables.candidates import RUN_AND_MODEL, of_selected

FIGURE = {
    "title": "Parameters against the fitted part of a run",
    "caption": "The parameters of the law that the choice names, fitted to each sixth of the swings of a "
    "run, over those of the whole run; release angle and instant are free in each part. "
    "Horizontal bars: the part; vertical bars: 95 % under white noise. A law that holds for the "
    "whole run stays at zero.",
    "reads": ["parts", "parameters", "choice"],
}


@printed
def draw(
    parts: pd.DataFrame, parameters: pd.DataFrame, choice: pd.DataFrame, origin: str, labels: Labels = None
) -> Drawing:
    """Parameters of the selected law from each part of a run, over those of the whole run.

    Parameters
    ----------
    parts, parameters, choice : pandas.DataFrame
        Tidy tables. Of each run the fit that the choice names; parts that do not determine a number are left
        out.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of the table parts, and whole (the parameter from the whole run), change_percent and
        change_stderr_percent (of the part over the whole).
    """
    data = of_selected(parts, choice)
    whole = parameters.astype({"run": str}).rename(columns={"value": "whole"})
    data = data.merge(whole[[*RUN_AND_MODEL, "parameter", "whole"]], on=[*RUN_AND_MODEL, "parameter"])
    data = data[data["stderr"] > 0]
    data["change_percent"] = 100 * (data["value"] / data["whole"] - 1)
    data["change_stderr_percent"] = 100 * data["stderr"] / data["whole"]
    if data.empty:
        return style.nothing_drawn("no run has a fit that may be used", origin), data
    figure, panels = style.panel_per_scene(style.scenes_in(data), labels, 2.0)
    for (block, foundation), ax in panels.items():
        _panel(ax, style.of_scene(data, block, foundation))
    style.outer_labels(panels, "time since release / s", "part over whole / %")
    style.finish(figure, origin)
    return figure, data


caption = style.runs_counted


def _panel(ax: Axes, scene: pd.DataFrame) -> None:
    ax.axhline(0, color="0.3", linestyle=":")
    for parameter, look in looks.PARAMETER_STYLES.items():
        own = scene[scene["parameter"] == parameter]
        if own.empty:
            continue
        half = (own["end_s"] - own["start_s"]) / 2
        bars = {"xerr": half, "yerr": NORMAL_95 * own["change_stderr_percent"], "linestyle": ""}
        sizes = {"markersize": style.scaled(3.5), "elinewidth": style.scaled(0.8)}
        at = own["start_s"] + half
        ax.errorbar(at, own["change_percent"], **bars, **sizes, label=SYMBOLS[parameter], **look)
    ax.margins(x=0.02)
