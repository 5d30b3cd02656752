"""Raw channels of record files."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from freerock.arrays import Floats
from freerock.errors import printable
from freerock.figures.style import styled
from freerock.files import atomic


class Panel(NamedTuple):
    """A channel to draw: title and label of its axis, times [s] and values, shape (n_samples,) each."""

    title: str
    ylabel: str
    time_s: Floats
    values: Floats


def draw(panels: Sequence[Panel]) -> Figure:
    """A panel per channel over time."""
    with styled(), rc_context({"text.parse_math": False}):  # a $ in a name is a $
        figure = Figure(figsize=(7.0, 0.6 + 1.3 * max(1, len(panels))), layout="constrained")
        axes = figure.subplots(max(1, len(panels)), 1, squeeze=False)[:, 0]
        for ax, panel in zip(axes, panels, strict=False):
            ax.plot(panel.time_s, panel.values, color="black", linewidth=0.7)
            ax.set_title(printable(panel.title), loc="left")
            ax.set_ylabel(printable(panel.ylabel))
        axes[-1].set_xlabel("time / s")
    return figure


def save_picture(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, the same bytes each time."""
    with atomic(path) as partial:
        FigureCanvasAgg(figure).print_png(partial, metadata={"Software": None})
