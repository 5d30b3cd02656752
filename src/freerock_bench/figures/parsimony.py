"""Figure of parsimony: how well a candidate predicts a run left out, against the numbers it has free."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures import looks, style
from freerock.figures.style import Drawing, Style, styled
from freerock.models.laws import CANDIDATES, MODELS
from freerock_bench.campaigns import HELD_OUT

RING: Style = {"markersize": 7, "markerfacecolor": "none", "color": "0.3"}
MARKERS = dict(zip(("housner", "winkler", "hunt_crossley", "general"), "os^D", strict=True))


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """Median error of the peaks of runs left out, a line per record, a panel per case; the selected ringed.

    Parameters
    ----------
    frame : pandas.DataFrame
        A row per case and number, as `freerock_bench.scatter.run` gives them.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        The points that are drawn; numbers says how many are free in the law.
    """
    of_candidates = frame[frame["parameter"] == HELD_OUT].groupby(["case", "test", "note"], sort=False)
    data = (100 * of_candidates["value"].median()).reset_index()
    data["numbers"] = [len(MODELS[model]) + CANDIDATES[model].width for model in data["note"]]
    data["law"] = [CANDIDATES[model].law for model in data["note"]]
    selected = data.merge(frame[frame["parameter"] == "true law first"][["test", "note"]].drop_duplicates())
    figure = Figure(figsize=(style.WIDTH_IN, 2.8))
    panels = figure.subplots(1, data["case"].nunique(), sharex=True, sharey=True, squeeze=False)[0]
    for (case, own), ax in zip(data.groupby("case", sort=False), panels, strict=True):
        best = own.groupby(["numbers", "test"])["value"].min().unstack()
        ax.plot(best.index, best, color="0.75", linewidth=0.6)
        for law, rows in own.groupby("law", sort=False):
            look = {key: looks.MODEL_STYLES[law][key] for key in ("color", "label")}
            ax.plot("numbers", "value", MARKERS[law], data=rows, **look)
        ax.plot("numbers", "value", "o", data=selected[selected["case"] == case], label="selected", **RING)
        ax.set(
            yscale="log",
            xticks=data["numbers"].unique(),
            title=str(case).replace("σ_r", "$σ_r$"),
            xmargin=0.15,
        )
    style.outer_labels(panels, "numbers free in the law", "error of held-out peaks / %")
    style.finish(figure, "")
    return figure, data
