"""Figure of the study of discrepancy: how often the truth lies inside, by kind of motion."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, headed, styled
from freerock.models.laws import SYMBOLS

BEFORE, AFTER = ("inside_stderr", "standard error"), ("inside", "with the discrepancy of the law")


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Coverage of nominal 95 % intervals: a panel per parameter, a row per kind of motion."""
    known = frame.dropna(subset=["error_percent"])
    parameters = list(known["parameter"].unique())
    kinds = list(known["kind"].unique())
    rows = known.groupby(["kind", "half", "parameter"], sort=False, as_index=False).agg(
        n=("inside", "size"),
        inside_stderr=("inside_stderr", lambda column: 100 * column.astype(float).mean()),
        inside=("inside", lambda column: 100 * column.astype(float).mean()),
    )
    figure = Figure(figsize=(7.0, 1.2 + 0.24 * len(kinds)))
    axes = figure.subplots(1, len(parameters), squeeze=False, sharey=True)[0]
    for ax, parameter in zip(axes, parameters, strict=True):
        own = rows[rows["parameter"] == parameter]
        at = np.array([kinds.index(kind) for kind in own["kind"]])
        for (column, name), marker, face in ((BEFORE, "o", "white"), (AFTER, "o", "black")):
            ax.plot(
                own[column], at, marker, color="black", markerfacecolor=face, linestyle="none", label=name
            )
        ax.axvline(95, color="0.6", linewidth=0.8, linestyle=":")
        ax.set_title(SYMBOLS[parameter], loc="left")
        ax.set(xlim=(-4, 104), xlabel="inside / %")
    axes[0].set_yticks(range(len(kinds)), kinds)
    axes[0].set_ylim(len(kinds) - 0.5, -0.5)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    headed(figure)
    return figure, rows
