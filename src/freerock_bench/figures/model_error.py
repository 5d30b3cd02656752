"""Figure of the study of the model's error: blocks that are not quite what the law says."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures.style import Labels, headed, styled
from freerock.models.laws import SYMBOLS

IMPERFECTIONS = {
    "none": "none",
    "centre": "centre of mass\n0.3 mm off",
    "uneven": "uneven\nbase",
    "amplitude": "damping grows\nwith amplitude",
}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """How wide the intervals become, and how far parameters lie off, under a law that is not the truth."""
    figure = Figure(figsize=(7.0, 3.1))
    left, right = figure.subplots(1, 2)
    kinds = list(frame["imperfection"].unique())
    for j, parameter in enumerate(frame["parameter"].unique()):
        rows = frame[frame["parameter"] == parameter]
        x = np.array([kinds.index(kind) for kind in rows["imperfection"]]) + (j - 0.5) * 0.3
        x = x + np.linspace(-0.1, 0.1, len(rows))
        for detected in (False, True):
            style = {
                "color": ("black", "#d55e00")[j],
                "marker": "os"[j],
                "linestyle": "",
                "markersize": 3.5,
                "markerfacecolor": None if detected else "white",
            }
            chosen = (rows["detected"] == detected).values
            left.plot(x[chosen], rows["widened"][chosen], **style)
            right.plot(x[chosen], rows["error"].abs()[chosen], **style)
    left.set(yscale="log", ylabel="standard error / Cramér–Rao bound")
    right.set(yscale="log", ylabel="|error| / standard error")
    right.axhline(1.96, color="0.5", linewidth=0.8, linestyle=":")
    for ax in (left, right):
        ax.set_xticks(range(len(kinds)), [IMPERFECTIONS[kind] for kind in kinds])
        ax.set_xlim(-0.5, len(kinds) - 0.5)
    handles = [
        Line2D([], [], color=colour, marker=marker, linestyle="", label=SYMBOLS[parameter])
        for parameter, colour, marker in zip(
            frame["parameter"].unique(), ("black", "#d55e00"), "os", strict=False
        )
    ]
    handles.append(
        Line2D(
            [],
            [],
            color="0.3",
            marker="o",
            linestyle="",
            markerfacecolor="white",
            label="residual passes as noise",
        )
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    headed(figure)
    return figure, frame
