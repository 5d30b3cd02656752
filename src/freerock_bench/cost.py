"""What a law explains for its number of parameters: three blocks, each of which needs another law."""

from dataclasses import replace

import numpy as np
import pandas as pd

from freerock.identification.against_noise import least_mean_square
from freerock.identification.fit import fit_run
from freerock.models.laws import CANDIDATES
from freerock.models.published import BLOCKS
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import identify_run
from freerock_bench.harness import rows_of_all
from freerock_bench.virtual_run import SEED, Row, Truth, published_truth, virtual_motion

WORN = 0.95  # of the width, between corners that are worn
STILL_S = (1.0, 2.0)  # hold and rest


def truths() -> dict[str, Truth]:
    """A truth for each block of table 1: rigid, under a law of the paper, pivoting about worn corners."""
    first, second, third = BLOCKS
    worn = published_truth(third, "marble", "hunt_crossley")
    shape = replace(worn.block, contact_width_m=WORN * worn.block.width_m)
    return {
        first: published_truth(first, "marble", "housner"),
        second: published_truth(second, "marble", "hunt_crossley"),
        third: replace(worn, model="hunt_crossley_pivoting_width", block=shape),
    }


def run(size: str = "full") -> pd.DataFrame:
    """Discrepancy of every candidate that is tried by default, fitted to the same run.

    Returns
    -------
    pandas.DataFrame
        A row per block and candidate: block, truth, model, n_parameters (of the law, without angle and
        instant of the release), epsilon_theta, over_noise (ε_θ over that of the noise at rest), success,
        least (whether no candidate of as many parameters has a smaller ε_θ), named (by the choice).
    """
    cases = list(truths().items())
    found = pd.DataFrame(rows_of_all(_rows, cases if size == "full" else cases[:1]))
    least = found.groupby(["block", "n_parameters"])["epsilon_theta"].transform("min")
    return found.assign(least=found["epsilon_theta"] == least, named=found.pop("named"))


def _rows(case: tuple[str, Truth]) -> list[Row]:
    block, truth = case
    motion = virtual_motion(truth, np.random.default_rng(SEED), still_s=STILL_S)
    assert motion is not None  # none of them overturns
    named = identify_run(truth.nominal, motion, BY_DEFAULT).choice(BY_DEFAULT).selected
    noise = least_mean_square(motion) / float(np.mean(motion.theta**2))
    every = BY_DEFAULT.candidates
    fits = {model: fit_run(model, truth.nominal, motion, BY_DEFAULT.settings(model)) for model in every}
    return [
        {
            "block": block,
            "truth": truth.model,
            "model": model,
            "n_parameters": len(CANDIDATES[model].parameters),
            "epsilon_theta": fit.epsilon_theta,
            "over_noise": fit.epsilon_theta / noise,
            "success": fit.success,
            "named": model == named,
        }
        for model, fit in fits.items()
    ]
