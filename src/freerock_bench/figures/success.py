"""Figure of the study of success: does a fit end in the global minimum?"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from freerock.figures.style import Labels, Style, axis_of, headed, panel_per_model, ratio_axis_of, styled
from freerock.models.laws import LAWS, MODEL_LABELS

OUTCOMES: dict[str, Style] = {  # of a fit: how it is drawn
    "global minimum": {"color": "0.6", "marker": ".", "markersize": 2},
    "reported as failed": {"color": "#0072b2", "marker": "s", "markersize": 5},
    "missed": {"color": "#d55e00", "marker": "X", "markersize": 7},
}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Random truths and whether the fit from the automatic start ended in the global minimum."""
    figure = Figure(figsize=(7.0, 2.9))
    for ax, model, rows in panel_per_model(figure, frame):
        outcome = np.select(
            [rows["reported"], ~rows["reached"]], ["reported as failed", "missed"], "global minimum"
        )
        if not LAWS[model].is_foundation:
            x, y = 1 - rows["r"], rows["sigma_deg"]
            ax.set(xlabel="1 − r", ylabel="noise $σ_θ$ / °")
        else:
            damping = LAWS[model].dampings[0]
            x, y = rows["k"], rows[damping] / rows["k"]
            ax.set(xlabel=axis_of("k"), ylabel=ratio_axis_of(damping))
        for name, style in OUTCOMES.items():
            ax.plot(x[outcome == name], y[outcome == name], linestyle="", **style)
        missed = int(np.sum(outcome == "missed"))
        ax.set(xscale="log", yscale="log")
        ax.margins(0.05)
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_minor_formatter(NullFormatter())
        ax.set_title(f"{MODEL_LABELS[model]}\n{missed} of {len(rows)} missed", loc="left")
    handles = [Line2D([], [], linestyle="", label=name, **style) for name, style in OUTCOMES.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    headed(figure)
    return figure, frame
