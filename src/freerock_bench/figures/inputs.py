"""Figure of the study of inputs: errors of means whose inputs are wrong, beside what is claimed of them."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, headed, styled
from freerock.models.laws import SYMBOLS


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Error over total uncertainty: a panel per kind of instruments and parameter."""
    figure = Figure(figsize=(7.0, 4.2))
    kinds, parameters = frame["instruments"].unique(), frame["parameter"].unique()
    axes = figure.subplots(len(kinds), len(parameters), squeeze=False, sharex=True)
    for i, kind in enumerate(kinds):
        for j, parameter in enumerate(parameters):
            ax = axes[i, j]
            rows = frame[(frame["instruments"] == kind) & (frame["parameter"] == parameter)]
            ax.hist(np.clip(rows["error"] / rows["u_total"], -5, 5), np.linspace(-5, 5, 41), color="0.6")
            inside, scatter = 100 * rows["inside"].mean(), 100 * rows["inside_scatter"].mean()
            ax.set_title(
                f"{kind}, {SYMBOLS[parameter]}: {inside:.0f} % inside\n(scatter alone {scatter:.0f} %)",
                loc="left",
            )
            if i + 1 == len(kinds):
                ax.set_xlabel("error / total uncertainty")
            if j == 0:
                ax.set_ylabel("campaigns")
    headed(figure)
    return figure, frame
