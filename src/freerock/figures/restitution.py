"""Restitution per impact, a comparison that Spanos et al. 2017 mention but do not show."""

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.figures.by_block import Shown, by_block, caption_of
from freerock.models.block import Block

FIGURE = {
    "title": "Restitution of each impact",
    "caption": "Restitution r of each impact, from the peaks seen before and after it, against the peak "
    "before it over the critical angle θ_cr. Bars: total standard uncertainty. Dotted: a rigid block on a "
    "rigid base, 1 − 1.5 sin²θ_cr of a rectangle (Housner 1963).",
    "reading": "Compare the points with the dotted line, which is Housner's r of that block on a rigid "
    "base. A constant r would be a horizontal row; a slope means that r depends on amplitude. "
    "The line of the selected law should pass through its points although it was fitted to θ(t), "
    "not to r.",
    "reads": ["runs", "restitution", "epsilon", "blocks"],
}


def _rigid(block: Block, seen: pd.DataFrame) -> tuple[Floats, Floats]:
    highest = seen["amplitude"].max() if len(seen) else 1.0
    return np.array([0.0, highest]), np.full(2, block.restitution_housner)


draw = by_block(
    Shown("amplitude", "r", "amplitude |θ|/$θ_{cr}$ before the impact", "restitution $r$", _rigid, "r_u"),
    finish=lambda ax, own: ax.set(xlim=(0, None)),
)
caption = caption_of("impact")
