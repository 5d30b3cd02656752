"""Period against amplitude, recorded and of the three laws."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.figures.by_scene import Shown, caption_of, draw_by_scene
from freerock.figures.style import Drawing, Labels, styled
from freerock.models.block import Block
from freerock.models.housner import housner_swings


def _rigid(block: Block, highest: float) -> tuple[Floats, Floats]:
    if not 0 < highest < 1:
        return np.empty(0), np.empty(0)
    amplitude = np.linspace(0.002, 1, 60) * highest
    swings = [housner_swings(block, 1.0, each * block.theta_cr, max_impacts=1) for each in amplitude]
    return amplitude, 4 * np.array([each.impact_time[0] for each in swings])


SHOWN = Shown("period_s", "period / s", _rigid)


@styled()
def draw(
    runs: pd.DataFrame,
    restitution: pd.DataFrame,
    epsilon: pd.DataFrame,
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels = None,
) -> Drawing:
    """Period against amplitude; arguments and numbers as of `by_scene.draw_by_scene`."""
    return draw_by_scene(SHOWN, (runs, restitution, epsilon), blocks, origin, labels)


caption = caption_of("interval")
