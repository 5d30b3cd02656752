"""Figure of speed against accuracy: time against error, down to the noise of a sensor."""

import math

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from freerock.figures.style import Axes, Drawing, Style, styled
from freerock.models.laws import LAWS, MODEL_LABELS
from freerock.virtual_lab.published import TABLE_3

BELOW_FLOOR = 1e-2  # of the floor, where the first chart ends
ROOM = 4.0  # times the longest time, for words
OVER = withStroke(linewidth=1.5, foreground="white")  # of a text that crosses lines
GOOD = "#e6eff7"
PALE: Style = {"alpha": 0.3, "linestyle": ""}
LINE: Style = {"linewidth": 0.9, "markersize": 4}
STYLES: dict[str, Style] = {
    "freerock": {"color": "black", "marker": "o", "linewidth": 1.6},
    "SciPy LSODA": {"color": "#00805e", "marker": "D"},
    "SciPy DOP853, compiled": {"color": "#00805e", "marker": "s", "linewidth": 0.6},
    "CyRK DOP853": {"color": "#d55e00", "marker": "*"},
    "CyRK RK45": {"color": "#0072b2", "marker": "*"},
    "CyRK RK45, law in Python": {"color": "#0072b2", "marker": "1"},
    "RK4": {"color": "0.5", "marker": "x"},
    "Newmark": {"color": "#8a6d00", "marker": "+"},
    "Runge–Kutta without events": {"color": "0.5", "marker": "x"},
    "OpenSees, gap springs": {"color": "#d55e00", "marker": "s"},
    "MuJoCo, strips": {"color": "#9a4d83", "marker": "v"},
    "MuJoCo, box": {"color": "#9a4d83", "marker": "P"},
    "Drake, points, RK3": {"color": "#0a3d91", "marker": "p"},
    "Drake, points, discrete": {"color": "#56b4e9", "marker": "h"},
}


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """Time against ε_θ, down to a hundredth of the noise; what is better stands at the edge."""
    data = frame[frame["outcome"] == "completed"]
    laws = [law for law in LAWS if (data["model"] == law).any()]
    figure = Figure(figsize=(7.0, 4.3))
    axes = figure.subplots(1, len(laws), squeeze=False, sharey=True)[0]
    for ax, law in zip(axes, laws, strict=True):
        ax.set_title(MODEL_LABELS[law], loc="left")
        ax.set(xscale="log", yscale="log")
        _panel(ax, law, data[data["model"] == law])
    axes[0].set_ylabel("time of a run of 3 s / s")
    axes[0].set_ylim(top=ROOM * data["time_s"].max())
    _legend(figure, data)
    return figure, data


def _panel(ax: Axes, law: str, rows: pd.DataFrame) -> None:
    floor = float(rows["floor_epsilon"].iloc[0])
    left = BELOW_FLOOR * floor
    ax.set(xlim=(left / 3, 2.0), xlabel="$ε_θ$ of the simulation")
    ax.axvspan(left / 3, floor, color=GOOD, linewidth=0)
    ax.axvline(floor, color="#00805e", linewidth=1)
    ax.axvline(TABLE_3["marble"][law], color="0.4", linewidth=1, linestyle="--")
    said: Style = {"fontsize": 6, "va": "top", "transform": ax.get_xaxis_transform(), "path_effects": [OVER]}
    ax.text(left / 2.5, 0.985, "below the\nnoise of\na laser", color="#00805e", **said)
    ax.text(TABLE_3["marble"][law], 0.985, "table 3 ", color="0.4", rotation=90, ha="right", **said)
    for method, points in rows.groupby("method", sort=False):
        style = LINE | STYLES[str(method)]
        _front(ax, points[points["epsilon"] >= left], style)
        if len(better := points[points["epsilon"] < left]):
            least = float(better["time_s"].min())
            ax.plot(left, least, linestyle="", **style)
            ax.annotate("", (left / 2.6, least), (left, least), arrowprops={"arrowstyle": "->", "lw": 0.7})


def _front(ax: Axes, points: pd.DataFrame, style: Style) -> None:
    """A line through the settings than which no cheaper one errs less; the others faint."""
    points = points.sort_values("time_s")
    best = points["epsilon"] <= points["epsilon"].cummin()
    for rows, look in ((points[best], {"linestyle": "-"}), (points[~best], PALE)):
        ax.plot(rows["epsilon"], rows["time_s"], **(style | look))


def _legend(figure: Figure, data: pd.DataFrame) -> None:
    names = [name for name in STYLES if (data["method"] == name).any()]
    looks = {name: LINE | STYLES[name] for name in names}
    handles = [Line2D([], [], **look, label=name) for name, look in looks.items()]
    pale: Style = {"color": "0.2", "marker": "o"} | PALE
    handles.append(Line2D([], [], **pale, label="pale: a cheaper setting errs less"))
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(4, math.ceil(len(handles) / 2)), fontsize=6.5
    )
