"""Figure of the methods as numerical methods: order of convergence, drift of energy, chattering near rest."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Axes, Labels, Style, styled
from freerock.models.laws import MODEL_LABELS

FIGURE = {
    "caption": "Order of convergence across impacts, energy of an undamped block, and the end of Housner's "
    "motion, for the methods compared."
}

STYLES: dict[str, Style] = {
    "freerock": {"color": "black", "marker": "o", "linewidth": 1.5},
    "RK4": {"color": "0.5", "marker": "x"},
    "Newmark": {"color": "#8a6d00", "marker": "+"},
    "HHT-α": {"color": "#d55e00", "marker": "1"},
    "central difference": {"color": "#56b4e9", "marker": "."},
    "SciPy DOP853": {"color": "#9a4d83", "marker": "s"},
    "SciPy DOP853, events": {"color": "#9a4d83"},
    "Runge–Kutta without events": {"color": "0.5"},
}
DASHES = ("-", "--", ":")  # of the settings of a method, in their order


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Error over work of two laws, energy over time, and the end of Housner's motion."""
    figure = Figure(figsize=(7.0, 6.0))
    (one, other), (below, last) = figure.subplots(2, 2)
    order = frame[frame["part"] == "order"]
    for ax, model in ((one, "winkler"), (other, "hunt_crossley")):
        _order(ax, order[order["model"] == model])
        ax.set(title=f"Order: {MODEL_LABELS[model]}", xlabel="evaluations (freerock: series) per second")
        ax.set_ylabel("relative error of $θ$")
    _curves(below, frame[frame["part"] == "energy"])
    below.set(title="Energy of an undamped block on springs", xlabel="time / s")
    below.set(ylabel="relative error of energy", ylim=(1e-21, 1e-2))  # room for the legend
    _curves(last, frame[frame["part"] == "chattering"])
    last.set(
        title="Housner's motion before its rest", xlabel="time to rest / s", ylabel="largest $|θ|$ left / rad"
    )
    last.set(xscale="log", ylim=(1e-14, 1))
    last.invert_xaxis()
    for ax in (one, other, below, last):
        ax.title.set_horizontalalignment("left")
        ax.title.set_x(0.0)
    return figure, frame


def _order(ax: Axes, rows: pd.DataFrame) -> None:
    """A curve per method; its slope stands in the legend."""
    for method, points in rows.groupby("method", sort=False):
        name = f"{method}: {points['order'].iloc[0]:.1f}"
        style = {"linewidth": 0.9, "markersize": 3.5} | STYLES[str(method)]
        ax.plot(points["x"], points["y"], **style, label=name)
    ax.set(xscale="log", yscale="log")
    ax.set_ylim(ax.get_ylim()[0] * 1e-5)  # room for the legend
    ax.legend(fontsize=6, title="order seen", title_fontsize=6)


def _curves(ax: Axes, rows: pd.DataFrame) -> None:
    for method, curves in rows.groupby("method", sort=False):
        style = {"linewidth": 0.9} | STYLES[str(method)] | {"marker": ""}
        for dash, (setting, points) in zip(DASHES, curves.groupby("setting", sort=False), strict=False):
            ax.plot(points["x"], points["y"], linestyle=dash, **style, label=f"{method}, {setting}")
    ax.set_yscale("log")
    ax.legend(fontsize=6)
