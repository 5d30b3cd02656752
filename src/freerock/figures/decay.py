"""Decay of the amplitude from swing to swing."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.arrays import Floats
from freerock.figures import style
from freerock.figures.by_block import Shown, caption_of, draw_by_block
from freerock.figures.style import Labels, printed
from freerock.models.block import Block
from freerock.tables.swings import named_swings

FIGURE = {
    "title": "Decay of the amplitude",
    "caption": "Largest |θ| of each swing over the critical angle α, on a logarithmic scale, against the "
    "number n of the swing; n = 0 is the release. Dotted: a rigid block from the largest release, "
    "whose energy each impact multiplies by r² with Housner's r.",
    "reading": "A straight line means that each impact takes the same share of the amplitude. The steeper "
    "of two foundations takes more energy at each impact. A record below the dotted line loses "
    "more than Housner's rigid block, one above it loses less.",
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
    """|θ_n|/α against n of all runs, and of the law selected for the first run of each scene.

    Parameters
    ----------
    runs, restitution, epsilon : pandas.DataFrame
        Tidy tables.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of `freerock.tables.swings.swings`, and swing.
    """
    data = named_swings(runs, restitution, epsilon, blocks)
    data = data.assign(swing=data["impact"].astype(float) - 1)
    shown = Shown("swing", "amplitude", "number n of the swing", "amplitude $|θ_n|/α$", _rigid)
    figure = draw_by_block(shown, data, runs, blocks, origin, labels)
    for ax, (_, own) in zip(figure.axes, data.groupby("block", sort=False), strict=False):
        ax.set(yscale="log", ylim=(0.7 * own["amplitude"].min(), 1.0))
        style.whole_decades(ax.yaxis)
    return figure, data


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many impacts and runs are drawn, and the law of each line."""
    return caption_of(data)


def _rigid(block: Block, seen: pd.DataFrame) -> tuple[Floats, Floats]:
    """A rigid block's amplitudes: cos(α - |θ_n|) - cos α, its energy, times r² from one to the next."""
    if seen.empty or not seen["amplitude"].max() < 1:
        return np.empty(0), np.empty(0)
    swing = np.arange(seen["swing"].max() + 1)
    critical = block.theta_cr
    released = np.cos(critical * (1 - seen["amplitude"].max())) - np.cos(critical)
    energy = released * block.restitution_housner ** (2 * swing)
    return swing, 1 - np.arccos(energy + np.cos(critical)) / critical
