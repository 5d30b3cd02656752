"""Period against amplitude, recorded and of the three laws."""

import numpy as np

from freerock.arrays import Floats
from freerock.figures import by_scene
from freerock.models.block import Block
from freerock.tables.swings import rigid_period_s


def _rigid(block: Block, highest: float) -> tuple[Floats, Floats]:
    amplitude = np.linspace(0.002, 1, 60) * highest
    return amplitude, rigid_period_s(block, amplitude)


draw, caption = by_scene.figure_of("period_s", "period / s", "interval", _rigid)
