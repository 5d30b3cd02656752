"""Figure of the faults matrix: how surely each fault of a signal is named."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, styled

FIGURE = {
    "caption": "Faults matrix, on simulated records: how often each fault of a signal is named at its time, "
    "from light to heavy, and how often a clean record is left without any name.",
}

AIM = 0.99  # of the faults named
SEVERITIES = ("light", "medium", "heavy")


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """A row per fault, a column per severity: the share of records in which the fault was named."""
    drawn = frame[frame["severity"].isin(SEVERITIES)]
    names = list(drawn["fault"].unique())
    rate = drawn.pivot(index="fault", columns="severity", values="rate").loc[names, list(SEVERITIES)]
    value = drawn.pivot(index="fault", columns="severity", values="value").loc[names, list(SEVERITIES)]
    quantity = drawn.groupby("fault")["quantity"].first()
    clean = frame[frame["fault"] == "none"].iloc[0]

    figure = Figure(figsize=(5.6, 0.6 + 0.26 * len(names)), layout="constrained")
    ax = figure.subplots()
    ax.imshow(np.where(rate >= AIM, 0.0, 1.0), cmap="Oranges", vmin=0.0, vmax=2.5, aspect="auto")
    ax.grid(False)
    for row, name in enumerate(names):
        for column, severity in enumerate(SEVERITIES):
            text = f"{rate.loc[name, severity]:.1%}  ({value.loc[name, severity]:g})"
            ax.text(column, row, text, ha="center", va="center", fontsize=7)
    ax.set_xticks(range(len(SEVERITIES)), SEVERITIES)
    ax.set_yticks(
        range(len(names)), [f"{name.replace('_', ' ')}\n{quantity[name]}" for name in names], fontsize=6
    )
    ax.set_title(
        f"faults named; on {clean['records']} clean records {clean['rate']:.1%} false alarms; simulated",
        fontsize=8,
    )
    return figure, frame
