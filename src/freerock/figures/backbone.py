"""Period against amplitude, recorded and of the selected law."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.arrays import Floats
from freerock.figures.by_block import Shown, caption_of, draw_by_block
from freerock.figures.style import Labels, printed
from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.tables.swings import named_swings

FIGURE = {
    "title": "Period against amplitude",
    "caption": "Twice the time between two impacts against the largest |θ| between them over the critical "
    "angle α. Dotted: a rigid block (Housner 1963), whose period does not depend on r and goes to "
    "zero with its amplitude.",
    "reading": "The dotted curve has no free parameter, so a point above it shows a base that yields. The "
    "distance grows as the amplitude falls, since the sinking corner then matters more. Points "
    "of several runs on one curve show that the period depends on the amplitude alone.",
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
    """Twice the time between impacts against the peak between them: all runs, and the law of the first.

    Parameters
    ----------
    runs, restitution, epsilon : pandas.DataFrame
        Tidy tables.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of `freerock.tables.swings.swings`, rows with a period.
    """
    data = named_swings(runs, restitution, epsilon, blocks)
    data = data[data["period_s"].notna()]
    shown = Shown("amplitude", "period_s", "amplitude |θ|/α", "period / s", _rigid)
    figure = draw_by_block(shown, data, runs, blocks, origin, labels)
    for ax in figure.axes:
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
    return figure, data


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many impacts and runs are drawn, and the law of each line."""
    return caption_of(data)


def _rigid(block: Block, seen: pd.DataFrame) -> tuple[Floats, Floats]:
    highest = seen["amplitude"].max() if len(seen) else 0.0
    if not 0 < highest < 1:
        return np.empty(0), np.empty(0)
    amplitude = np.linspace(0.002, 1, 60) * highest
    quarter = [
        housner_swings(block, 1.0, each * block.theta_cr, max_impacts=1).impact_time[0] for each in amplitude
    ]
    return amplitude, 4 * np.array(quarter)
