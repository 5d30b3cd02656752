"""Raw channels of record files."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from freerock.arrays import Floats
from freerock.errors import printable
from freerock.figures.style import WIDTH_IN, styled
from freerock.files import atomic


def draw(panels: Sequence[tuple[str, str, Floats, Floats]], path: Path) -> None:
    """Draw a panel per channel over time, as PNG, the same bytes each time.

    Parameters
    ----------
    panels : sequence of (str, str, ndarray, ndarray)
        Title and label of the axis of each, times [s] and values, shape (n_samples,) each.
    path : path
    """
    with styled(), rc_context({"text.parse_math": False}):  # a $ in a name is a $
        figure = Figure(figsize=(WIDTH_IN, 0.6 + 1.3 * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
        for ax, (title, label, time_s, values) in zip(axes, panels, strict=True):
            ax.plot(time_s, values, color="black", linewidth=0.7)
            ax.set_title(printable(title), loc="left")
            ax.set_ylabel(printable(label))
        axes[-1].set_xlabel("time / s")
    with atomic(path) as partial:
        FigureCanvasAgg(figure).print_png(partial, metadata={"Software": None})
