"""Figure of the stability atlas: where each method converges and where it fails."""

import re
from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from freerock.figures.style import Axes, Drawing, Style, axis_of, styled
from freerock.models.free_parameters import PARAMETERS, SYMBOLS
from freerock.models.laws import MODEL_LABELS
from freerock.tables.number_text import with_unit

STATE_COLOURS = {
    "converged": "#b5dcc0",
    "inaccurate": "#dca828",
    "unstable": "#b00020",
    "too_slow": "#6a6ad0",
    "refused": "white",
}
CAUSE_STYLES: dict[str, Style] = {
    "the block overturns": {"marker": ".", "markersize": 1.5},
    "the motion multiplies errors": {"marker": "+", "markersize": 2.5, "markeredgewidth": 0.5},
}
STATE_LABELS = {"too_slow": "too slow"}


def ratio_axis_of(damping: str) -> str:
    """Label of an axis along which a damping over the stiffness is drawn, "λ/k / (s m⁻¹)"."""
    unit = re.sub(r"/(\w+)", r" \1-1", PARAMETERS[damping].ratio_unit)
    return with_unit(f"{SYMBOLS[damping]}/{SYMBOLS['k']}", unit)


QUANTITIES = {"k [N/m²]": axis_of("k"), "step [s]": "step / s", "θ₀/θ_cr": "θ₀ / critical angle"} | {
    f"{name}/k [{parameter.ratio_unit}]": ratio_axis_of(name)
    for name, parameter in PARAMETERS.items()
    if parameter.ratio_unit
}
Bounds = Mapping[str, tuple[float, float]]
BOUNDS: Bounds = {
    f"{name}/k [{parameter.ratio_unit}]" if parameter.ratio_unit else "k [N/m²]": parameter.bounds
    for name, parameter in PARAMETERS.items()
    if parameter.bounds and (parameter.ratio_unit or name == "k")
}
TICKS = 5  # of an axis at most


# a pair of quantities each: what makes a row, title, bounds
PAGES: dict[str, tuple[list[str], str, Bounds | None]] = {
    "stiffness": (["model", "debonding"], "Stiffness and damping", BOUNDS),
    "step": (["model"], "Fixed steps", None),
    "release": (["model"], "Angle of release and slenderness", None),
}


@styled()
def draw(frame: pd.DataFrame, page: str) -> Drawing:
    """A page of the stability atlas, of `PAGES`: a row of panels a group, each of a method."""
    by, title, bounds = PAGES[page]
    cells = frame[frame["map"] == page]
    rows = [(key, [*group.groupby("method", sort=False)]) for key, group in cells.groupby(by, sort=False)]
    n_columns = max(len(methods) for _, methods in rows)
    figure = Figure(figsize=(7.0, 1.55 * len(rows) + 0.75))
    axes = figure.subplots(len(rows), n_columns, squeeze=False)
    for i, (key, methods) in enumerate(rows):
        for ax in axes[i, len(methods) :]:
            ax.axis("off")
        for ax, (method, own) in zip(axes[i], methods, strict=False):
            _panel(ax, own, bounds)
            ax.set_title(_wrapped(method), fontsize=7, loc="left")
            ax.tick_params(labelleft=ax is axes[i, 0], labelbottom=i + 1 == len(rows))
        name = ",\n".join(MODEL_LABELS.get(part, part) for part in key)
        axes[i, 0].set_ylabel(f"{name}\n{_axis(methods[0][1]['y'])}")
    for ax, (_, own) in zip(axes[-1], rows[-1][1], strict=False):
        ax.set_xlabel(_axis(own["x"]))
    figure.suptitle(title, x=0.01, ha="left", fontsize=9, weight="bold")
    handles = _legend(cells, bounds)
    figure.legend(
        handles=handles, loc="outside lower center", ncols=min(4, len(handles)), handlelength=1, fontsize=7
    )
    return figure, cells


def _legend(cells: pd.DataFrame, bounds: Bounds | None) -> list[Artist]:
    """What occurs in some cells."""
    handles: list[Artist] = [
        Patch(facecolor=colour, edgecolor="0.5", linewidth=0.5, label=STATE_LABELS.get(state, state))
        for state, colour in STATE_COLOURS.items()
        if (cells["state"] == state).any()
    ]
    for cause, style in CAUSE_STYLES.items():
        if cells["cause"].fillna("").str.startswith(cause).any():
            handles.append(Line2D([], [], color="black", linestyle="", **style, label=cause))
    return [*handles, *([Patch(fill=False, label="bounds of the fit")] if bounds else [])]


def _axis(quantity: pd.Series) -> str:
    name = str(quantity.iloc[0])
    return QUANTITIES.get(name, name)


def _wrapped(method: str) -> str:
    return method.replace(" over ", "\nover ").replace(" on ", "\non ").replace(", ", ",\n")


def _panel(ax: Axes, cells: pd.DataFrame, bounds: Bounds | None) -> None:
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
    ax.tick_params(labelsize=7)
    if bounds:
        x0, x1 = (np.interp(np.log(v), np.log(xs), np.arange(len(xs))) for v in bounds[cells["x"].iloc[0]])
        y0, y1 = (np.interp(np.log(v), np.log(ys), np.arange(len(ys))) for v in bounds[cells["y"].iloc[0]])
        ax.add_patch(Rectangle((x0 - 0.5, y0 - 0.5), x1 - x0 + 1, y1 - y0 + 1, fill=False, linewidth=0.8))


def _number(value: float) -> str:
    if value == 0 or 1e-3 <= value < 1e3:
        return f"{value:.3g}"
    exponent = int(np.floor(np.log10(value) + 1e-9))
    mantissa = value / 10**exponent
    return f"$10^{{{exponent}}}$" if abs(mantissa - 1) < 0.05 else f"${mantissa:.2g}·10^{{{exponent}}}$"
