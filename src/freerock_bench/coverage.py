"""Are the intervals of the identification honest, and do parameters scatter as little as they can?"""

from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.fit import fit_run
from freerock.models.laws import MODELS, PAPER_MODELS
from freerock.planning.cramer_rao import standard_errors
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.virtual_run import (
    CORRELATED_S,
    SEED,
    STEP_SIGMAS,
    Row,
    published_truth,
    rows_of_all,
    virtual_motion,
)

RUNS = {"full": 200, "small": 3}  # of each noise, scene and law
EVERYWHERE = ("white", "mains and drift")
OF_SENSORS = (*CORRELATED_S, "white and slow", "mains", *STEP_SIGMAS)  # on two blocks, a foundation in turn
BLOCKS = ("config2", "config3")
STILL_S = (1.0, 3.0)  # shortest and longest hold, and rest


def run(size: str = "full") -> pd.DataFrame:
    """Scatter of identified parameters against the Cramér-Rao bound, and whether intervals hold the truth.

    Each run has a hold and a rest, which show the noise of the sensor.

    Returns
    -------
    pandas.DataFrame
        One row per run and parameter, SI units: block, foundation, model, noise, run, parameter, truth,
        value, stderr, ci95_low, ci95_high and bound, the Cramér-Rao bound of white noise; NaN where the fit
        failed.
    """
    noises = (EVERYWHERE, OF_SENSORS) if size == "full" else (("white",), ("white and slow",))
    cases = [
        (block, foundation, model, noise, i)
        for model in PAPER_MODELS
        for block in CONFIGURATIONS
        for place, foundation in enumerate(FOUNDATIONS)
        for i in range(RUNS[size])
        for noise in (*noises[0], *(noises[1] if block in BLOCKS and i % len(FOUNDATIONS) == place else ()))
    ]
    return pd.DataFrame(rows_of_all(_coverage, cases))


def _coverage(case: Any) -> list[Row]:
    block, foundation, model, noise, i = case
    truth = published_truth(block, foundation, model, noise)
    key = (
        2,
        list(CONFIGURATIONS).index(block),
        list(FOUNDATIONS).index(foundation),
        PAPER_MODELS.index(model),
        i,
    )
    generator = np.random.default_rng([SEED, *key, (*EVERYWHERE, *OF_SENSORS).index(noise)])
    motion = virtual_motion(truth, generator, still_s=tuple(generator.uniform(*STILL_S, 2)))
    if motion is None:
        return []
    fit = fit_run(model, truth.block, motion)
    bound = standard_errors(
        model,
        truth.block,
        truth.parameters,
        motion.time_s - motion.time_s[0],
        truth.theta0,
        truth.sigma_theta,
    )
    return [
        {
            "block": block,
            "foundation": foundation,
            "model": model,
            "noise": noise,
            "run": i,
            "parameter": name,
            "truth": truth.parameters[name],
            "value": fit.value[j],
            "stderr": fit.stderr[j],
            "ci95_low": fit.ci95_low[j],
            "ci95_high": fit.ci95_high[j],
            "bound": bound[name],
        }
        for j, name in enumerate(MODELS[model])
    ]
