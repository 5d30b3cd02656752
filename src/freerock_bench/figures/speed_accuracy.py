"""Figure of speed against accuracy: what each method costs for an error."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures.style import Labels, Style, label, styled
from freerock.models.laws import MODEL_LABELS

FIGURE = {
    "caption": "Time of a run over its error, for every method and scene: the lower and the further left "
    "the better. Grey: below the disagreement of two independent references.",
}

LAWS = ["hunt_crossley", "winkler", "housner"]  # order of the panels
EPSILON_RANGE = (1e-25, 3.0)
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
    "linearised": {"color": "#0072b2", "linestyle": "", "marker": "v", "markersize": 5},
    "SciPy DOP853, events": {"color": "#d55e00", "linestyle": "--", "marker": "s"},
}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Work and precision: time of a run over its error, a panel per scene."""
    data = frame[frame["outcome"] == "completed"]
    rows: dict[tuple[str, str], list[tuple[str, str, str]]] = {}
    scenes = dict(list(data.groupby(["model", "foundation", "block"], sort=False)))
    for key in sorted(scenes, key=lambda key: LAWS.index(key[0])):
        model, foundation, block = key
        # a row per law; the six scenes of Hunt-Crossley take two
        rows.setdefault((model, foundation if model == "hunt_crossley" else ""), []).append(key)
    figure = Figure(figsize=(7.0, 2.1 * len(rows) + 0.2))
    axes = figure.subplots(len(rows), 3, squeeze=False)
    drawn = {}
    for row, keys in zip(axes, rows.values(), strict=True):
        for ax in row[1 : len(keys)]:
            ax.sharey(row[0])
            ax.tick_params(labelleft=False)
        for ax, (model, foundation, block) in zip(row, keys, strict=False):
            scene = scenes[model, foundation, block]
            names = MODEL_LABELS[model], label(labels, block), label(labels, foundation)
            ax.set_title(", ".join(names), loc="left")
            ax.axvspan(EPSILON_RANGE[0], scene["reference_epsilon"].iloc[0], color="0.93", linewidth=0)
            for method, points in scene.groupby("method", sort=False):
                points = points.sort_values("value")
                drawn[method] = _method_style(method)
                epsilon = points["epsilon"].clip(lower=EPSILON_FLOOR)
                ax.plot(epsilon, 1e3 * points["time_s"], **drawn[method])
            ax.set(xscale="log", yscale="log", xlim=EPSILON_RANGE)
            ax.set_xticks([1e-20, 1e-15, 1e-10, 1e-5, 1])
        row[0].set_ylabel("time of a run / ms")
        for ax in row[len(keys) :]:
            ax.axis("off")
    for ax in axes[-1]:
        ax.set_xlabel("error $ε$ (fraction)")
    empty = next(ax for ax in axes.ravel() if not ax.axison)
    empty.legend(handles=_method_legend(drawn), loc="upper left", bbox_to_anchor=(0, 1.12), fontsize=6)
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
