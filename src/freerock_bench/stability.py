"""Stability atlas: where each method converges, is inaccurate, unstable, too slow or refuses, and why.

Every map varies two quantities of one problem, configuration 2 on marble unless said otherwise, and says for
each cell and method what happened, by which measure, and what the analysis does there.
"""

import pandas as pd

from freerock_bench.atlas.cells import COLUMNS
from freerock_bench.atlas.fits import fit_map, housner_fit_map
from freerock_bench.atlas.integration import release_map, springs_map, step_map, stiffness_map, tail_map


def run(size: str = "full") -> pd.DataFrame:
    """All maps of the atlas, one row per cell and method.

    In its small size a few cells of each map, without CyRK.

    Returns
    -------
    pandas.DataFrame
        Columns map, method, model, debonding, x and y (names of the quantities varied), x_value and
        y_value, state (one of STATES), cause, measure and value (what the state is judged by),
        evaluations, pipeline (what the analysis does in the cell).
    """
    maps = (stiffness_map, step_map, release_map, springs_map, tail_map, housner_fit_map, fit_map)
    return pd.DataFrame([row for each in maps for row in each(size)], columns=COLUMNS)
