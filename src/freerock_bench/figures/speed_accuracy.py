"""Figure of speed against accuracy: what each method costs for an error."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures.style import Labels, Style, styled
from freerock.models.laws import MODEL_LABELS
from freerock.models.published import PUBLISHED_BLOCK

FIGURE = {
    "caption": "Time of a run over its error, for every method, of configuration 2 on marble: the lower and "
    "the further left the better. Shaded: errors below the noise of a laser. Other scenes: the table."
}

LAWS = ("hunt_crossley", "winkler")  # of the panels
FOUNDATION = "marble"
EPSILON_RANGE = (1e-25, 3.0)
BELOW_NOISE = "#e6eff7"
EPSILON_FLOOR = 1e-24  # smaller errors are drawn here
METHOD_STYLES: dict[str, Style] = {
    "RK45": {"color": "#0072b2", "marker": "^"},
    "DOP853": {"color": "#d55e00", "marker": "s"},
    "LSODA": {"color": "#00805e", "marker": "D"},
    "Radau": {"color": "#9a4d83", "marker": "v"},
    "RADAU": {"color": "#9a4d83", "marker": "v"},
}
KINDS: dict[str, Style] = {
    "NumPy": {"linestyle": ":", "label": "SciPy, NumPy right-hand side"},
    "numba": {"linestyle": "--", "label": "SciPy, numba right-hand side"},
    "CyRK": {"linestyle": "-", "label": "CyRK, compiled right-hand side"},
}
OWN_STYLES: dict[str, Style] = {
    "freerock": {"color": "black", "linestyle": "-", "linewidth": 1.8, "marker": "o", "markersize": 4},
    "RK4": {"color": "0.45", "linestyle": "-.", "marker": "x", "markersize": 4},
    "Newmark": {"color": "#8a6d00", "linestyle": "-.", "marker": "+", "markersize": 5},
}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Work and precision: time of a run over its error, a panel per law."""
    shown = (frame["block"] == PUBLISHED_BLOCK) & (frame["foundation"] == FOUNDATION)
    data = frame[shown & frame["model"].isin(LAWS) & (frame["outcome"] == "completed")]
    figure = Figure(figsize=(7.0, 4.4))
    axes = figure.subplots(1, len(LAWS), sharey=True)
    drawn = {}
    for ax, law in zip(axes, LAWS, strict=True):
        scene = data[data["model"] == law]
        ax.set_title(MODEL_LABELS[law], loc="left")
        noise = scene["noise_epsilon"].iloc[0]
        ax.axvspan(EPSILON_RANGE[0], noise, color=BELOW_NOISE, linewidth=0)
        ax.text(
            noise,
            0.98,
            "below the noise of a laser ",
            ha="right",
            va="top",
            fontsize=7,
            transform=ax.get_xaxis_transform(),
        )
        for method, points in scene.groupby("method", sort=False):
            points = points.sort_values("value")
            drawn[method] = _method_style(method)
            ax.plot(points["epsilon"].clip(lower=EPSILON_FLOOR), 1e3 * points["time_s"], **drawn[method])
        ax.set(xscale="log", yscale="log", xlim=EPSILON_RANGE, xlabel="error $ε$ (fraction)")
        ax.set_xticks([1e-20, 1e-15, 1e-10, 1e-5, 1])
    axes[0].set_ylabel("time of a run / ms")
    axes[0].set_ylim(top=3e3 * data["time_s"].max())
    figure.legend(handles=_method_legend(drawn), loc="outside lower center", ncols=4, fontsize=6.5)
    return figure, data


def _method_style(method: str) -> Style:
    if method in OWN_STYLES:
        return OWN_STYLES[method]
    engine, name = method.split(" ", 1)
    name, _, kind = name.partition(", ")
    style = KINDS["CyRK" if engine == "CyRK" else kind]
    return METHOD_STYLES[name] | {"linestyle": style["linestyle"]}


def _method_legend(drawn: Mapping[str, Style]) -> list[Line2D]:
    handles = [Line2D([], [], **style, label=name) for name, style in OWN_STYLES.items() if name in drawn]
    names = [name for name in METHOD_STYLES if any(f" {name}" in method for method in drawn)]
    handles += [
        Line2D([], [], linestyle="", **METHOD_STYLES[name], label=name)
        for name in names
        if name != "RADAU" or "Radau" not in names
    ]
    for key, style in KINDS.items():
        if any(key in method for method in drawn):
            handles.append(Line2D([], [], color="0.3", **style))
    return handles
