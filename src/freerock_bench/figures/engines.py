"""Figure of a laboratory's tools: time against error down to a sensor's floor, the rest, identifications."""

import math

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from freerock.figures.style import Axes, Labels, Style, styled
from freerock.models.laws import LAWS, MODEL_LABELS
from freerock.models.published import TABLE_3

FIGURE = {
    "caption": "Time of a run over its error, and of an identification over the error that it makes, for "
    "the tools of a laboratory. Shaded: below the noise of a laser, or below one standard error. "
    "Arrows: errors below a hundredth of the noise.",
}

BELOW_FLOOR = 1e-2  # of the floor, where the first chart ends
LEAST = 1e-24  # smaller errors are drawn here
MOST_STDERRS = 3e3  # to which the third chart reaches at least
ROOM_FOR_NOTES = 4.0  # times the longest time
SIDES = {0.3: "left", 0.7: "center", math.inf: "right"}  # of a note, by how far across the panel it stands
OVER = withStroke(linewidth=1.5, foreground="white")  # of a text that crosses lines
GOOD = "#e6eff7"
LINE: Style = {"linewidth": 0.9, "markersize": 4}
STYLES: dict[str, Style] = {
    "freerock": {"color": "black", "marker": "o", "linewidth": 1.6},
    "SciPy LSODA": {"color": "#00805e", "marker": "D"},
    "ode45": {"color": "#0072b2", "marker": "^"},
    "RK4": {"color": "0.5", "marker": "x"},
    "Newmark": {"color": "#8a6d00", "marker": "+"},
    "HHT-α": {"color": "#b39500", "marker": "1"},
    "central difference": {"color": "0.7", "marker": "."},
    "Runge–Kutta without events": {"color": "0.5", "marker": "x"},
    "OpenSees, gap springs": {"color": "#d55e00", "marker": "s"},
    "MuJoCo, strips": {"color": "#9a4d83", "marker": "v"},
    "MuJoCo, box": {"color": "#9a4d83", "marker": "P"},
    "Drake, points, RK3": {"color": "#0a3d91", "marker": "p"},
    "Drake, points, discrete": {"color": "#56b4e9", "marker": "h"},
}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[list[Figure], pd.DataFrame]:
    """Three pages: errors that a sensor sees, smaller ones, identifications; a panel per law."""
    data = frame[frame["outcome"] == "completed"]
    return [_seen(data), _unseen(data), _identified(data)], data


def _panels(data: pd.DataFrame, title: str) -> tuple[Figure, list[tuple[str, Axes, pd.DataFrame]]]:
    laws = [law for law in LAWS if (data["model"] == law).any()]
    figure = Figure(figsize=(7.0, 4.3))
    axes = figure.subplots(1, len(laws), squeeze=False, sharey=True)[0]
    for ax, law in zip(axes, laws, strict=True):
        ax.set_title(MODEL_LABELS[law], loc="left")
        ax.set(xscale="log", yscale="log")
    figure.suptitle(title, x=0.01, ha="left", fontsize=9, weight="bold")
    return figure, [(law, ax, data[data["model"] == law]) for law, ax in zip(laws, axes, strict=True)]


def _seen(data: pd.DataFrame) -> Figure:
    """Time against ε_θ, down to a hundredth of the noise; what is better stands at the edge."""
    figure, panels = _panels(data, "Which tool errs less than a laser, and what it costs")
    for law, ax, rows in panels:
        floor = float(rows["floor_epsilon"].iloc[0])
        left = BELOW_FLOOR * floor
        ax.set(xlim=(left / 3, 2.0), xlabel="$ε_θ$ of the simulation")
        ax.axvspan(left / 3, floor, color=GOOD, linewidth=0)
        ax.axvline(floor, color="#00805e", linewidth=1)
        ax.axvline(TABLE_3["marble"][law], color="0.4", linewidth=1, linestyle="--")
        _said(ax, floor, "noise of a laser", "#00805e")
        _good(ax, left / 2.5, "errs less")
        _said(ax, TABLE_3["marble"][law], "table 3", "0.4")
        noted: set[str] = set()
        for method, points in rows.groupby("method", sort=False):
            style = LINE | STYLES[str(method)]
            _front(ax, points[points["epsilon"] >= left], "epsilon", "time_s", style)
            if len(better := points[points["epsilon"] < left]):
                least = float(better["time_s"].min())
                ax.plot(left, least, linestyle="", **style)
                ax.annotate(
                    "", (left / 2.6, least), (left, least), arrowprops={"arrowstyle": "->", "lw": 0.7}
                )
            _noted(ax, points, left, noted)
    panels[0][1].set_ylabel("time of a run of 3 s / s")
    panels[0][1].set_ylim(top=ROOM_FOR_NOTES * data["time_s"].max())
    _legend(figure, data)
    return figure


def _front(ax: Axes, points: pd.DataFrame, x: str, y: str, style: Style) -> None:
    """A line through the settings than which no cheaper one errs less; the others faint."""
    points = points.sort_values(y)
    best = points[x] <= points[x].cummin()
    ax.plot(points[x][best], points[y][best], linestyle="-", **style)
    ax.plot(points[x][~best], points[y][~best], linestyle="", **(style | {"alpha": 0.3}))


def _said(ax: Axes, x: float, text: str, color: str) -> None:
    ax.text(
        x,
        0.015,
        f" {text}",
        rotation=90,
        ha="right",
        va="bottom",
        fontsize=6,
        color=color,
        transform=ax.get_xaxis_transform(),
        path_effects=[OVER],
    )


def _good(ax: Axes, x: float, text: str) -> None:
    place = ax.get_xaxis_transform()
    ax.text(x, 0.98, text, fontsize=6.5, color="#00805e", va="top", transform=place)


def _noted(ax: Axes, points: pd.DataFrame, left: float, noted: set[str]) -> None:
    """What an engine can't do, or does otherwise, beside its slowest point, once."""
    engine = points["method"].iloc[0].partition(",")[0]
    if points["kind"].iloc[0] != "engine" or engine in noted:
        return
    noted.add(engine)
    slowest = points.sort_values("time_s").iloc[-1]
    note = str(slowest["note"]).partition(";")[0]
    x = max(slowest["epsilon"], left)
    low, high = np.log(ax.get_xlim())
    across = (math.log(x) - low) / (high - low)
    ax.annotate(
        f"{engine}:\n{note}",
        (x, slowest["time_s"]),
        xytext=(0, 4),
        ha=next(side for end, side in SIDES.items() if across < end),
        textcoords="offset points",
        fontsize=5.5,
        color=STYLES[slowest["method"]]["color"],
        path_effects=[OVER],
    )


def _unseen(data: pd.DataFrame) -> Figure:
    """Time against ε_θ below the first chart."""
    figure, panels = _panels(data, "Errors that no sensor sees")
    for _, ax, rows in panels:
        right = BELOW_FLOOR * float(rows["floor_epsilon"].iloc[0])
        for method, points in rows.groupby("method", sort=False):
            style = LINE | STYLES[str(method)]
            shown = points[points["epsilon"] < right]
            _front(ax, shown.assign(epsilon=shown["epsilon"].clip(lower=LEAST)), "epsilon", "time_s", style)
        ax.set(xlim=(LEAST / 5, 5 * right), xlabel="$ε_θ$ of the simulation")
        ax.set_xticks([1e-24, 1e-18, 1e-12])
    panels[0][1].set_ylabel("time of a run of 3 s / s")
    _legend(figure, data)
    return figure


def _identified(data: pd.DataFrame) -> Figure:
    """Time of a whole identification against the error of r or k that the simulation makes."""
    figure, panels = _panels(data, "What an identification costs, and how far its tool shifts it")
    worst = max(MOST_STDERRS, 2 * data["error_stderr"].max())
    for _, ax, rows in panels:
        ax.axvspan(1e-9, 1.0, color=GOOD, linewidth=0)
        ax.axvline(1.0, color="#00805e", linewidth=1)
        _said(ax, 1.0, "one standard error", "#00805e")
        _good(ax, 6e-5, "good enough")
        for method, points in rows.groupby("method", sort=False):
            style = LINE | STYLES[str(method)]
            shown = points.assign(error_stderr=points["error_stderr"].clip(lower=1e-4))
            _front(ax, shown, "error_stderr", "fit_s", style)
        ax.set(xlim=(5e-5, worst), xlabel=f"error of ${rows['parameter'].iloc[0]}$ / standard error")
        ax.set_xticks([1e-4, 1e-2, 1, 1e2])
    ax = panels[0][1]
    ax.set_ylabel("time of an identification / s")
    for seconds, text in ((60, "1 min"), (3600, "1 h")):
        if ax.get_ylim()[0] < seconds < ax.get_ylim()[1]:
            for _, each, _ in panels:
                each.axhline(seconds, color="0.8", linewidth=0.6, zorder=0)
            ax.text(6e-5, seconds * 1.08, text, fontsize=6, color="0.4")
    _legend(figure, data)
    return figure


def _legend(figure: Figure, data: pd.DataFrame) -> None:
    names = [name for name in STYLES if (data["method"] == name).any()]
    looks = {name: LINE | STYLES[name] for name in names}
    handles = [Line2D([], [], **look, label=name) for name, look in looks.items()]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(5, math.ceil(len(names) / 2)), fontsize=6.5
    )
