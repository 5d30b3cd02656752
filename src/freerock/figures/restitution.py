"""Restitution per impact, a comparison that Spanos et al. 2017 mention but do not show."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.arrays import Floats
from freerock.figures.by_block import Shown, caption_of, draw_by_block
from freerock.figures.style import Labels, printed
from freerock.models.block import Block
from freerock.tables.swings import named_swings

FIGURE = {
    "title": "Restitution of each impact",
    "caption": "Restitution r of each impact, from the peaks seen before and after it, against the peak "
    "before it over the critical angle α. Bars: one standard error. Dotted: a rigid block on a rigid base, "
    "1 − 1.5 sin²α of a rectangle (Housner 1963).",
    "reading": "Compare the points with the dotted line, which is Housner's r of that block on a rigid "
    "base. A constant r would be a horizontal row; a slope means that r depends on amplitude. "
    "The line of the selected law should pass through its points although it was fitted to θ(t), "
    "not to r.",
    "reads": ["runs", "restitution", "epsilon", "blocks"],
}


@printed
def draw(
    runs: pd.DataFrame,
    restitution: pd.DataFrame,
    epsilon: pd.DataFrame,
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels = None,
) -> tuple[Figure, pd.DataFrame]:
    """Restitution of each impact against the peak before it: all runs, and the law of the first.

    Parameters
    ----------
    runs, restitution, epsilon : pandas.DataFrame
        Tidy tables; runs that failed or are excluded are left out, and models whose fit failed.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of `freerock.tables.swings.swings`.
    """
    data = named_swings(runs, restitution, epsilon, blocks)
    shown = Shown(
        "amplitude", "r", "amplitude |θ|/α before the impact", "restitution $r$", _rigid, "r_stderr"
    )
    figure = draw_by_block(shown, data, runs, blocks, origin, labels)
    for ax in figure.axes:
        ax.set_xlim(left=0)
    return figure, data


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many impacts and runs are drawn, and the law of each line."""
    return caption_of(data)


def _rigid(block: Block, seen: pd.DataFrame) -> tuple[Floats, Floats]:
    highest = seen["amplitude"].max() if len(seen) else 1.0
    return np.array([0.0, highest]), np.full(2, block.restitution_housner)
