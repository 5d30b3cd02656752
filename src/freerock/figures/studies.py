"""Figures of the studies: speed against accuracy, cost of the models, and the stability atlas."""

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from freerock.figures.style import MODEL_STYLES, headed, label, styled
from freerock.models.laws import K_RANGE, MODEL_LABELS, RATIO_RANGE

LAWS = ["hunt_crossley", "winkler", "housner"]  # order of the panels
EPSILON_RANGE = (1e-25, 3.0)
EPSILON_FLOOR = 1e-24  # smaller errors are drawn here
METHOD_STYLES = {
    "RK45": {"color": "#0072b2", "marker": "^"},
    "DOP853": {"color": "#d55e00", "marker": "s"},
    "LSODA": {"color": "#00805e", "marker": "D"},
    "Radau": {"color": "#9a4d83", "marker": "v"},
    "RADAU": {"color": "#9a4d83", "marker": "v"},
}
KINDS = {
    "NumPy": {"linestyle": ":", "label": "SciPy, NumPy right-hand side"},
    "numba": {"linestyle": "--", "label": "SciPy, numba right-hand side"},
    "CyRK": {"linestyle": "-", "label": "CyRK, compiled right-hand side"},
}
OWN_STYLES = {
    "freerock": {"color": "black", "linestyle": "-", "linewidth": 1.8, "marker": "o", "markersize": 4},
    "RK4": {"color": "0.45", "linestyle": "-.", "marker": "x", "markersize": 4},
    "Newmark": {"color": "#8a6d00", "linestyle": "-.", "marker": "+", "markersize": 5},
    "linearised": {"color": "#0072b2", "linestyle": "", "marker": "v", "markersize": 5},
    "SciPy DOP853, events": {"color": "#d55e00", "linestyle": "--", "marker": "s"},
}
STATE_COLOURS = {
    "converged": "#7fbf8f",
    "inaccurate": "#f0d050",
    "unstable": "#b00020",
    "too_slow": "#6a6ad0",
    "refused": "white",
}
CAUSE_STYLES = {
    "the block overturns": {"marker": ".", "markersize": 1.5},
    "the motion multiplies errors": {"marker": "+", "markersize": 2.5, "markeredgewidth": 0.5},
    "denormal numbers": {"marker": "x", "markersize": 3},
}
STATE_LABELS = {"too_slow": "too slow"}
QUANTITIES = {"c/k [s]": "c/k / s", "lambda/k [s/m]": "λ/k / (s/m)", "k [N/m²]": "k / (N/m²)"}
QUANTITIES |= {
    "step [s]": "step / s",
    "record [s]": "record / s",
    "start off by a factor of": "start off by a factor of",
}
BOUNDS = {"k [N/m²]": K_RANGE, "c/k [s]": RATIO_RANGE["c"], "lambda/k [s/m]": RATIO_RANGE["lambda"]}
TICKS = 5  # of an axis at most


@styled()
def speed_accuracy(frame, labels=None):
    """Work and precision: time of a run over its error, a panel per scene.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.speed_accuracy.speed_accuracy`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn.
    """
    data = frame[frame["outcome"] == "completed"]
    rows = {}
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


def _method_style(method):
    if method in OWN_STYLES:
        return OWN_STYLES[method]
    engine, name = method.split(" ", 1)
    name, _, kind = name.partition(", ")
    style = KINDS["CyRK" if engine == "CyRK" else kind]
    return METHOD_STYLES[name] | {"linestyle": style["linestyle"]}


def _method_legend(drawn):
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


@styled()
def model_choice(frame, labels=None):
    """The three models on the same axes: ε_θ of the fitted model over the time of one run.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.speed_accuracy.model_choice`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn.
    """
    figure = Figure(figsize=(7.0, 3.4))
    ax = figure.subplots()
    ax.set(xscale="log", yscale="log")
    markers = dict(zip(frame.groupby(["block", "foundation"], sort=False).groups, "osD^v<>PX", strict=False))
    for scene, rows in frame.groupby(["block", "foundation"], sort=False):
        rows = rows.sort_values("epsilon_theta", ascending=False)
        ax.plot(1e3 * rows["time_s"], 100 * rows["epsilon_theta"], color="0.75", linewidth=0.7, zorder=1)
        for _, row in rows.iterrows():
            colour = MODEL_STYLES[row["model"]]["color"]
            style = {
                "color": colour,
                "markerfacecolor": colour if row["success"] else "white",
                "markersize": 5,
            }
            ax.plot(1e3 * row["time_s"], 100 * row["epsilon_theta"], markers[scene], **style)
    noise = 100 * frame["noise_epsilon"]
    ax.axhspan(noise.min(), noise.max(), color="0.9", linewidth=0, zorder=0)
    counts = frame.drop_duplicates("model").set_index("model")["n_parameters"]
    models = [
        Patch(
            color=MODEL_STYLES[model]["color"], label=f"{MODEL_LABELS[model]}, {n} parameter{'s' * (n > 1)}"
        )
        for model, n in counts.items()
    ]
    scenes = [
        Line2D(
            [],
            [],
            color="0.3",
            linestyle="",
            marker=marker,
            label=f"{label(labels, scene[0])}, {label(labels, scene[1])}",
        )
        for scene, marker in markers.items()
    ]
    others = [Patch(color="0.9", label="noise of the record")]
    if not frame["success"].all():
        style = {"color": "0.3", "linestyle": "", "markerfacecolor": "white", "marker": "o"}
        others.append(Line2D([], [], **style, label="fit not to be used"))
    ax.margins(x=0.05)
    ax.xaxis.set_minor_formatter("{x:g}")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("time of a run / ms")
    ax.set_ylabel("$ε_θ$ of the fitted model / %")
    figure.legend(handles=[*models, *others, *scenes], loc="outside right upper")
    headed(figure)
    return figure, frame


@styled()
def stability(frame):
    """The stability atlas: a page per pair of quantities, a panel per method; the fit's bounds framed.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.stability.stability`.

    Returns
    -------
    pages : list of matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn.
    """
    pages = [
        _atlas_page(frame, ["stiffness"], ["model", "debonding"], "Stiffness and damping", BOUNDS),
        _atlas_page(frame, ["step"], ["model"], "Fixed steps", None),
        _atlas_page(frame, ["release"], ["model"], "Angle of release and slenderness", None),
        _atlas_page(
            frame, ["springs", "tail", "housner_fit", "fit"], ["map"], "Springs, tails and fits", None
        ),
    ]
    return pages, frame


MAP_TITLES = {
    "springs": "springs for the bed",
    "tail": "length of the tail",
    "housner_fit": "fits of Housner's r",
    "fit": "fits of Hunt–Crossley's k, λ",
}


def _atlas_page(frame, maps, by, title, bounds):
    rows = list(frame[frame["map"].isin(maps)].groupby(by, sort=False))
    n_columns = max(group["method"].nunique() for _, group in rows)
    figure = Figure(figsize=(7.0, 1.55 * len(rows) + 0.75))
    axes = figure.subplots(len(rows), n_columns, squeeze=False)
    for i, (key, group) in enumerate(rows):
        methods = list(group.groupby("method", sort=False))
        for ax in axes[i, len(methods) :]:
            ax.axis("off")
        for ax, (method, cells) in zip(axes[i], methods, strict=False):
            _atlas_panel(ax, cells, bounds)
            ax.set_title(_wrapped(method), fontsize=6.5, loc="left")
            if ax is axes[i, 0]:
                ax.set_ylabel(f"{_row_title(key)}\n{QUANTITIES.get(cells['y'].iloc[0], cells['y'].iloc[0])}")
            else:
                ax.tick_params(labelleft=False)
            last = i + 1 == len(rows) or by == ["map"]
            ax.tick_params(labelbottom=last)
            if last:
                ax.set_xlabel(QUANTITIES.get(cells["x"].iloc[0], cells["x"].iloc[0]))
    cells = frame[frame["map"].isin(maps)]
    handles = [
        Patch(facecolor=colour, edgecolor="0.5", linewidth=0.5, label=STATE_LABELS.get(state, state))
        for state, colour in STATE_COLOURS.items()
        if (cells["state"] == state).any()
    ]
    for cause, style in CAUSE_STYLES.items():
        if cells["cause"].fillna("").str.startswith(cause).any():
            handles.append(Line2D([], [], color="black", linestyle="", **style, label=cause))
    if bounds:
        handles.append(Patch(fill=False, label="bounds of the fit"))
    figure.suptitle(title, x=0.01, ha="left", fontsize=9, weight="bold")
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), handlelength=1, fontsize=6.5
    )
    return figure


def _row_title(key):
    names = MODEL_LABELS | MAP_TITLES
    return ",\n".join(names.get(part, part) for part in key)


def _wrapped(method):
    return method.replace(" over ", "\nover ").replace(" on ", "\non ").replace(", ", ",\n")


def _atlas_panel(ax, cells, bounds):
    """Cells of equal size, whatever the values along the axes."""
    xs, ys = np.unique(cells["x_value"]), np.unique(cells["y_value"])
    states = list(STATE_COLOURS)
    grid = np.full((len(ys), len(xs)), np.nan)
    column, row = np.searchsorted(xs, cells["x_value"]), np.searchsorted(ys, cells["y_value"])
    grid[row, column] = [states.index(state) for state in cells["state"]]
    norm = BoundaryNorm(np.arange(len(states) + 1) - 0.5, len(states))
    ax.imshow(
        grid, cmap=ListedColormap(list(STATE_COLOURS.values())), norm=norm, origin="lower", aspect="auto"
    )
    ax.grid(False)
    for cause, style in CAUSE_STYLES.items():
        marked = cells["cause"].fillna("").str.startswith(cause).to_numpy()
        ax.plot(column[marked], row[marked], color="black", linestyle="", **style)
    for axis, values in ((ax.xaxis, xs), (ax.yaxis, ys)):
        decades = np.log10(values)
        shown = np.flatnonzero(np.abs(decades - decades.round()) < 1e-6)
        if len(shown) < 3 or len(values) <= TICKS:
            shown = np.arange(len(values))
        shown = shown[:: -(-len(shown) // TICKS)]
        axis.set_ticks(shown, [_number(values[i]) for i in shown])
    ax.tick_params(labelsize=6)
    if bounds:
        x0, x1 = (np.interp(np.log(v), np.log(xs), np.arange(len(xs))) for v in bounds[cells["x"].iloc[0]])
        y0, y1 = (np.interp(np.log(v), np.log(ys), np.arange(len(ys))) for v in bounds[cells["y"].iloc[0]])
        ax.plot(
            [x0 - 0.5, x1 + 0.5, x1 + 0.5, x0 - 0.5, x0 - 0.5],
            [y0 - 0.5, y0 - 0.5, y1 + 0.5, y1 + 0.5, y0 - 0.5],
            color="black",
            linewidth=0.8,
        )


def _number(value):
    if value == 0 or 1e-3 <= value < 1e3:
        return f"{value:.3g}"
    exponent = int(np.floor(np.log10(value) + 1e-9))
    mantissa = value / 10**exponent
    return f"$10^{{{exponent}}}$" if abs(mantissa - 1) < 0.05 else f"${mantissa:.2g}·10^{{{exponent}}}$"
