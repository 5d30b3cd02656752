"""Decay of the amplitude from swing to swing."""

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.figures import style
from freerock.figures.by_block import Shown, by_block, caption_of
from freerock.figures.style import Axes
from freerock.models.block import Block

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


def _rigid(block: Block, seen: pd.DataFrame) -> tuple[Floats, Floats]:
    """A rigid block's amplitudes: cos(α - |θ_n|) - cos α, its energy, times r² from one to the next."""
    if seen.empty or not seen["amplitude"].max() < 1:
        return np.empty(0), np.empty(0)
    swing = np.arange(seen["swing"].max() + 1)
    critical = block.theta_cr
    released = np.cos(critical * (1 - seen["amplitude"].max())) - np.cos(critical)
    energy = released * block.restitution_housner ** (2 * swing)
    return swing, 1 - np.arccos(energy + np.cos(critical)) / critical


def _logarithmic(ax: Axes, own: pd.DataFrame) -> None:
    if len(own):
        ax.set(yscale="log", ylim=(0.7 * own["amplitude"].min(), 1.0))
        style.whole_decades(ax.yaxis)


draw = by_block(
    Shown("swing", "amplitude", "number n of the swing", "amplitude $|θ_n|/α$", _rigid),
    lambda swings: swings.assign(swing=swings["impact"].astype(float) - 1),
    _logarithmic,
)
caption = caption_of("impact")
