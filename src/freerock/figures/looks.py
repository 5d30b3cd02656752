"""How the lines of measured runs and of models look, on paper and on the screen; drawn elsewhere.

Of a long line, the samples that show its course.
"""

from importlib.util import find_spec
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Indices
from freerock.models.laws import CANDIDATES, LAWS, MODEL_LABELS

Style = dict[str, Any]
"""Look of a line: keywords of Matplotlib."""

MEASURED: Style = {"color": "0.72", "linestyle": "-", "linewidth": 2.6, "label": "recorded"}
# Colour and line of a law, and its marker on the screen, in the order of `models.laws`; a further one takes
# the next look.
_LAW_LOOKS = (
    ("#d55e00", "-.", "diamond"),
    ("#0072b2", "--", "square"),
    ("black", "-", "triangle"),
    ("#cc79a7", (0, (5, 1, 1, 1)), "inverted_triangle"),
    ("#009e73", ":", "hex"),
    ("#56b4e9", (0, (1, 1, 4, 1)), "cross"),
    ("#8c6d1f", (0, (8, 1.5, 1.5, 1.5, 1.5, 1.5)), "star"),
)
# Dashes lie on top of the line of the law that they may coincide with; with gaps as long, both are seen.
OVERLAID: dict[str, Style] = {
    "hunt_crossley": {"linewidth": 1.0, "zorder": 2.1},
    "winkler": {"linewidth": 1.4, "zorder": 2.2, "linestyle": (0, (2.5, 2.5)), "dash_capstyle": "butt"},
    "housner": {"linewidth": 0.9, "zorder": 2.15},
}
DASHES = {"-": [], "--": [7, 3], "-.": [7, 3, 1.5, 3], ":": [1.5, 2]}  # on the screen
RIVAL = "#7a3b9a"  # colour of candidates beside the laws themselves
_BY_LAW = dict(zip(LAWS, cycle(_LAW_LOOKS), strict=False))


def _look(model: str) -> Style:
    """Colour by law, one of all rivals; of these a dash for the law, dots for what is free, and no fill."""
    candidate = CANDIDATES[model]
    color, line, _ = _BY_LAW[candidate.law]
    style: Style = {"color": color, "linestyle": line, "label": MODEL_LABELS[model]}
    if candidate.is_rival:
        moves = candidate.kinematics != LAWS[candidate.law].kinematics[0]
        dots = 1 + candidate.width + 2 * moves
        dash = 3.0 + 2.0 * list(LAWS).index(candidate.law)
        dashes = (0, (dash, 1.0, *(0.8, 1.0) * dots))
        style |= {"color": RIVAL, "linestyle": dashes, "markerfacecolor": "none"}
    return style


MODEL_STYLES: dict[str, Style] = {model: _look(model) for model in CANDIDATES}


def line_of(law: str) -> Style:
    """Look of a law of the paper beside the others."""
    return MODEL_STYLES[law] | OVERLAID.get(law, {})


def scripts_folder() -> Path:
    """BokehJS as it comes with the Python package, which need not be imported for it."""
    found = find_spec("bokeh")
    if found is None or found.origin is None:
        raise ModuleNotFoundError("No module named 'bokeh'", name="bokeh")
    return Path(found.origin).parent / "server/static/js"


def on_screen() -> dict[str, dict[str, Any]]:
    """Look of each curve on the screen, by source: that on paper."""
    recorded = _on_screen(MEASURED | {"color": "#999999"}, 3, "circle")
    laws = {
        model: _on_screen(style, 1.5, _BY_LAW[CANDIDATES[model].law][2])
        for model, style in MODEL_STYLES.items()
    }
    return {"measured": recorded, **laws}


def _on_screen(style: Style, width: float, marker: str) -> dict[str, Any]:
    line = style["linestyle"]
    dash = DASHES[line] if isinstance(line, str) else line[1]
    look = {"color": style["color"], "dash": dash, "width": width, "marker": marker}
    return look | {"label": style["label"]}


def extremes(values: ArrayLike, n_bins: int = 1000) -> Indices:
    """Lowest and highest sample of each bin, so that no spike is lost by drawing fewer samples.

    Parameters
    ----------
    values : array_like, shape (n_samples,)
        Samples; NaN where there is none.
    n_bins : int
        Bins.

    Returns
    -------
    ndarray of int
        Indices to draw, in order.
    """
    values = np.asarray(values)
    width = max(1, -(-len(values) // n_bins))
    whole = len(values) // width * width
    parts = [(0, values[:whole].reshape(-1, width)), (whole, values[whole:].reshape(1, -1))]
    kept = [np.empty(0, np.intp)]
    for start, bins in parts:
        if bins.size:
            first = start + bins.shape[1] * np.arange(len(bins))
            missing = np.isnan(bins) if values.dtype.kind == "f" else np.zeros(1, bool)
            holes = bool(missing.any())
            low = np.where(missing, np.inf, bins) if holes else bins
            high = np.where(missing, -np.inf, bins) if holes else bins
            kept += [first + low.argmin(axis=1), first + high.argmax(axis=1)]
    return np.unique(np.concatenate(kept))
