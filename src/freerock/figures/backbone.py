"""Period against amplitude, recorded and of the three laws."""

import numpy as np

from freerock.arrays import Floats
from freerock.figures import by_scene
from freerock.models.block import Block
from freerock.models.housner import housner_swings


def _rigid(block: Block, highest: float) -> tuple[Floats, Floats]:
    amplitude = np.linspace(0.002, 1, 60) * highest
    swings = [housner_swings(block, 1.0, each * block.theta_cr, max_impacts=1) for each in amplitude]
    return amplitude, 4 * np.array([each.impact_time[0] for each in swings])


draw, caption = by_scene.figure_of("period_s", "period / s", "interval", _rigid)
