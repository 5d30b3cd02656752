"""Restitution per impact, a comparison that Spanos et al. 2017 mention but do not show."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.figures.by_scene import Shown, caption_of, draw_by_scene
from freerock.figures.style import Drawing, Labels, styled
from freerock.models.block import Block


def _rigid(block: Block, highest: float) -> tuple[Floats, Floats]:
    return np.array([0.0, highest]), np.full(2, block.restitution_housner)


SHOWN = Shown("r", "restitution $r$", _rigid, "r_u", scatters=True)


@styled()
def draw(
    runs: pd.DataFrame,
    restitution: pd.DataFrame,
    epsilon: pd.DataFrame,
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels = None,
) -> Drawing:
    """r of each impact against the peak before it; arguments and numbers as of `by_scene.draw_by_scene`."""
    return draw_by_scene(SHOWN, (runs, restitution, epsilon), blocks, origin, labels)


caption = caption_of("impact")
