"""Figure of parsimony: what a candidate explains against the numbers it has free; the selected one ringed."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures import looks, style
from freerock.figures.style import Drawing, styled
from freerock.models.laws import CANDIDATES, PAPER_MODELS

APART = 0.05  # of the laws, along the axis of whole numbers


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """−2 ln of the evidence of each fitted candidate over the selected one's, a line per record.

    Parameters
    ----------
    frame : pandas.DataFrame
        Tidy table choice of one or several campaigns.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        The rows of the table that are drawn.
    """
    data = frame[frame["minus_two_log"].notna()].drop_duplicates(["campaign", "test", "model"])
    figure = Figure(figsize=style.size(3.2))
    ax = figure.subplots()
    for _, own in data.groupby(["campaign", "test"]):
        best = own.groupby("n_parameters")["minus_two_log"].min()
        ax.plot(best.index, best, color="0.75", linewidth=0.6)
    for i, law in enumerate(PAPER_MODELS):
        own = data[[CANDIDATES[model].law == law for model in data["model"]]]
        look = looks.MODEL_STYLES[law] | {"linestyle": "", "marker": "os^"[i], "markersize": 4}
        ax.plot(own["n_parameters"] + APART * (i - 1), own["minus_two_log"], **look)
    chosen = data[data["status"] == "selected"]
    ring: style.Style = {
        "marker": "o",
        "markersize": 14,
        "markerfacecolor": "none",
        "color": "black",
        "linestyle": "",
    }
    ax.plot(chosen["n_parameters"], chosen["minus_two_log"], label="selected", **ring)
    ax.set_yscale("symlog", linthresh=10)
    ax.set_xticks(sorted(data["n_parameters"].unique()))
    ax.set(xlabel="numbers free in the law", ylabel="−2 ln evidence, over the selected")
    ax.margins(0.1)
    style.finish(figure, "")
    return figure, data
