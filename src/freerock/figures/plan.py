"""Predicted standard errors of a campaign over its choices."""

from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures.style import Labels, Style, label, styled
from freerock.models.laws import MODEL_LABELS, SYMBOLS

BLOCK_STYLES: tuple[Style, ...] = (
    {"color": "black", "marker": "o"},
    {"color": "#0072b2", "marker": "s"},
    {"color": "#d55e00", "marker": "D"},
    {"color": "#00805e", "marker": "^"},
    {"color": "#9a4d83", "marker": "v"},
)
RATE_LINES = ("-", "--", ":", "-.")


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[list[Figure], pd.DataFrame]:
    """Relative standard errors over the release angle: a page per sensor and duration.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.identification.plan.plan`.

    Returns
    -------
    pages : list of matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn, with the standard error in per cent of the value.
    """
    frame = frame.assign(percent=(100 * frame["stderr"] / frame["value"]).replace(np.inf, np.nan))
    pages = [
        _page(frame, rows, f"Predicted with {sensor}, {duration:g} s from the release", labels)
        for (sensor, duration), rows in frame.groupby(["sensor", "duration_s"], sort=False)
    ]
    return pages, frame


def _page(frame: pd.DataFrame, rows: pd.DataFrame, title: str, labels: Labels) -> Figure:
    """Panels with the axes of the whole frame, so that pages compare."""
    blocks = dict(zip(frame["block"].unique(), cycle(BLOCK_STYLES)))
    rates = dict(zip(sorted(frame["sampling_rate_hz"].unique()), cycle(RATE_LINES)))
    foundations = frame["foundation"].unique()
    parameters = frame.groupby(["model", "parameter"], sort=False)["percent"].agg(["min", "max"])
    figure = Figure(figsize=(7.0, 0.9 + 1.5 * len(foundations)))
    axes = figure.subplots(len(foundations), len(parameters), squeeze=False, sharex=True, sharey="col")
    for column, ((model, parameter), (low, high)) in zip(axes.T, parameters.iterrows(), strict=True):
        column[0].set_title(f"{MODEL_LABELS[model]} {SYMBOLS[parameter]}", loc="left")
        column[-1].set_xlabel("release angle / °")
        if low > 0:
            column[0].set(yscale="log", ylim=(low / 1.5, high * 1.5))
        chosen = rows[(rows["model"] == model) & (rows["parameter"] == parameter)]
        for ax, foundation in zip(column, foundations, strict=True):
            one = chosen[chosen["foundation"] == foundation].sort_values("release_angle_deg")
            for (block, _, rate), curve in one.groupby(["block", "laser", "sampling_rate_hz"]):
                ax.plot(curve["release_angle_deg"], curve["percent"], linestyle=rates[rate], **blocks[block])
    for ax, foundation in zip(axes[:, 0], foundations, strict=True):
        ax.set_ylabel(f"{label(labels, foundation)}\nstandard error / %")
    axes[0, 0].set_xlim(0, 1.1 * frame["release_angle_deg"].max())
    handles = [Line2D([], [], **style, label=label(labels, name)) for name, style in blocks.items()]
    handles += [Line2D([], [], color="0.3", linestyle=s, label=f"{rate:g} Hz") for rate, s in rates.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 6))
    figure.suptitle(title, x=0.01, ha="left", fontsize=9, weight="bold")
    return figure
