"""Figure of parsimony: what a candidate explains against the numbers it has free; the selected one ringed."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures import looks, style
from freerock.figures.style import Drawing, styled
from freerock.models.laws import CANDIDATES, MODELS, PAPER_MODELS
from freerock_bench.campaigns import EVIDENCE

APART = 0.05  # of the laws, along the axis of whole numbers


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """−2 ln of the evidence of each fitted candidate over the selected one's, a line per record.

    Parameters
    ----------
    frame : pandas.DataFrame
        A row per case and number, as `freerock_bench.campaigns.graded` gives them.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        The rows that are drawn; numbers says how many are free in the law.
    """
    data = frame[frame["parameter"] == EVIDENCE]
    data = data.assign(numbers=[len(MODELS[model]) + CANDIDATES[model].width for model in data["note"]])
    figure = Figure(figsize=(style.WIDTH_IN, 3.2))
    ax = figure.subplots()
    for _, own in data.groupby("test"):
        best = own.groupby("numbers")["value"].min()
        ax.plot(best.index, best, color="0.75", linewidth=0.6)
    for i, law in enumerate(PAPER_MODELS):
        own = data[[CANDIDATES[model].law == law for model in data["note"]]]
        look = looks.MODEL_STYLES[law] | {"linestyle": "", "marker": "os^"[i], "markersize": 4}
        ax.plot(own["numbers"] + APART * (i - 1), own["value"], **look)
    chosen = data[data["inside"].astype(bool)]
    ring: style.Style = {"marker": "o", "markersize": 14, "markerfacecolor": "none", "color": "black"}
    ax.plot(chosen["numbers"], chosen["value"], label="selected", linestyle="", **ring)
    ax.set_yscale("symlog", linthresh=10)
    ax.set_xticks(sorted(data["numbers"].unique()))
    ax.set(xlabel="numbers free in the law", ylabel="−2 ln evidence, over the selected")
    ax.margins(0.1)
    style.finish(figure, "")
    return figure, data
