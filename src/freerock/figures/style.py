"""What all figures share: the style sheet, line styles, thinning, the footer, and writing to files."""

import functools
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imsave

from freerock.datasets import atomic
from freerock.tables import MODEL_LABELS, write_csv

styled = functools.partial(matplotlib.rc_context, fname=Path(__file__).with_name("freerock.mplstyle"))
"""Context manager and decorator that draws in the style sheet, whatever the user's own settings are."""

# Foundations in order of appearance; the first two as in Spanos et al. 2017, figure 2.
FOUNDATION_STYLES = (
    {"color": "black", "linestyle": "-"},
    {"color": "#0a5bd3", "linestyle": "--"},
    {"color": "#b34700", "linestyle": "-."},
    {"color": "#00805e", "linestyle": ":"},
    {"color": "#9a4d83", "linestyle": (0, (7, 1.5, 1, 1.5, 1, 1.5))},
)
MEASURED = {"color": "0.72", "linestyle": "-", "linewidth": 2.6, "label": "measured"}
MODEL_STYLES = {
    "housner": {"color": "#d55e00", "linestyle": "-.", "label": MODEL_LABELS["housner"]},
    "winkler": {"color": "#0072b2", "linestyle": "--", "label": MODEL_LABELS["winkler"]},
    "hunt_crossley": {"color": "black", "linestyle": "-", "label": MODEL_LABELS["hunt_crossley"]},
    "general": {"color": "#7a3e9d", "linestyle": (0, (5, 1, 1, 1)), "label": MODEL_LABELS["general"]},
}
FOOTER = "simulated record – not the laboratory's data"


def label(labels, name):
    """Printed name of a block or foundation; the name itself where none is given."""
    return (labels or {}).get(name) or name


def thin(n_samples, n_drawn=1000):
    """Every so many samples, the last included, so that about `n_drawn` remain.

    Parameters
    ----------
    n_samples : int
        Samples there are.
    n_drawn : int
        Samples to keep.

    Returns
    -------
    ndarray of int
        Indices to draw.
    """
    kept = np.arange(0, n_samples, max(1, round(n_samples / n_drawn)))
    return np.union1d(kept, n_samples - 1) if n_samples else kept


def extremes(values, n_bins=1000):
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
    values = np.asarray(values, dtype=float)
    edges = np.linspace(0, len(values), min(n_bins, len(values)) + 1).astype(int)[:-1]
    bins = np.split(np.arange(len(values)), edges[1:])
    low, high = np.where(np.isnan(values), np.inf, values), np.where(np.isnan(values), -np.inf, values)
    return np.unique([i for b in bins if len(b) for i in (b[low[b].argmin()], b[high[b].argmax()])])


def gathered(parts, columns):
    """Frames one below the other; an empty one with the columns where there is none."""
    parts = list(parts)
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=columns)


def legend_above(ax, handles=None):
    """Legend in one row above the panel's right corner, clear of the curves."""
    handles = handles or ax.get_legend_handles_labels()[0]
    ax.legend(
        handles=handles, ncols=len(handles), loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0.2
    )


def footer(figure, origin):
    """Say at the foot of the figure that its record is simulated, if it is."""
    if origin == "simulated":
        figure.text(0.99, 0.005, FOOTER, ha="right", va="bottom", fontsize=6.5, color="0.35")
        if engine := figure.get_layout_engine():
            engine.set(rect=(0, 0.16 / figure.get_figheight(), 1, 1 - 0.16 / figure.get_figheight()))


def headed(figure):
    """Say at the head of a figure, above a legend at its foot, that its records are simulated."""
    figure.suptitle(FOOTER.capitalize(), x=0.01, ha="left", fontsize=6.5, color="0.35")


@styled()
def save(figures, data, stem, origin=None):
    """Write a figure as `<stem>.pdf` and `<stem>.png`, and its numbers as `<stem>.csv`.

    Parameters
    ----------
    figures : Figure or sequence of Figure
        Several figures become the pages of the PDF and are stacked in the PNG.
    data : pandas.DataFrame
        The numbers drawn.
    stem : path-like
        Path without suffix.
    origin : str, optional
        "simulated" or "measured": written beside the numbers.
    """
    pages = [figures] if isinstance(figures, Figure) else list(figures)
    images = []
    for page in pages:
        canvas = FigureCanvasAgg(page)
        canvas.draw()
        images.append(np.array(canvas.buffer_rgba())[..., :3])
        page.set_layout_engine("none")  # the layout found for the PNG serves the PDF too
    with atomic(f"{stem}.png") as part:
        imsave(part, np.vstack(images), format="png", metadata={"Software": None})
    with atomic(f"{stem}.pdf") as part, PdfPages(part, metadata={"CreationDate": None}) as pdf:
        for page in pages:
            FigureCanvasPdf(page).print_pdf(pdf)
    write_csv(data if origin is None else data.assign(origin=origin), f"{stem}.csv")
