"""Restitution per impact, a comparison that Spanos et al. 2017 mention but do not show."""

import numpy as np

from freerock.arrays import Floats
from freerock.figures import by_scene
from freerock.models.block import Block


def _rigid(block: Block, highest: float) -> tuple[Floats, Floats]:
    return np.array([0.0, highest]), np.full(2, block.restitution_housner)


draw, caption = by_scene.figure_of("r", "restitution $r$", "impact", _rigid)
