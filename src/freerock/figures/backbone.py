"""Period against amplitude, recorded and of the selected law."""

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.figures.by_block import Shown, by_block, caption_of
from freerock.models.block import Block
from freerock.models.housner import housner_swings

FIGURE = {
    "title": "Period against amplitude",
    "caption": "Twice the interval between two impacts against the largest |θ| in it over the critical "
    "angle θ_cr. Dotted: a rigid block (Housner 1963), whose period does not depend on r and goes to "
    "zero with its amplitude.",
    "reading": "The dotted curve has no free parameter, so a point above it shows a base that yields. The "
    "distance grows as the amplitude falls, since the sinking corner then matters more. Points "
    "of several runs on one curve show that the period depends on the amplitude alone.",
    "reads": ["runs", "restitution", "epsilon", "blocks"],
}


def _rigid(block: Block, seen: pd.DataFrame) -> tuple[Floats, Floats]:
    highest = seen["amplitude"].max() if len(seen) else 0.0
    if not 0 < highest < 1:
        return np.empty(0), np.empty(0)
    amplitude = np.linspace(0.002, 1, 60) * highest
    swings = [housner_swings(block, 1.0, each * block.theta_cr, max_impacts=1) for each in amplitude]
    quarter = [each.impact_time[0] for each in swings]
    return amplitude, 4 * np.array(quarter)


draw = by_block(
    Shown("amplitude", "period_s", "amplitude |θ|/$θ_{cr}$", "period / s", _rigid),
    lambda swings: swings[swings["period_s"].notna()],
    lambda ax, own: ax.set(xlim=(0, None), ylim=(0, None)),
)
caption = caption_of("interval")
