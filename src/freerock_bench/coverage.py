"""Are the intervals of the identification honest under every noise of a sensor?

python -m freerock_bench.coverage results/studies/coverage.csv full
"""

import sys
from typing import Any

import numpy as np

from freerock.identification.fit import fit_run
from freerock.models.laws import PAPER_MODELS
from freerock.planning.cramer_rao import standard_errors
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.harness import NUMBERS, Study, rows_of_fit
from freerock_bench.virtual_run import CORRELATED_S, SEED, STEP_SIGMAS, Row, published_truth, virtual_motion

RUNS = {"full": 200, "small": 3}  # of each noise, scene and law
EVERYWHERE = ("white", "mains and drift")
OF_SENSORS = (*CORRELATED_S, "white and slow", "mains", *STEP_SIGMAS)  # on two blocks, a foundation in turn
BLOCKS = ("config2", "config3")
STILL_S = (1.0, 3.0)  # shortest and longest hold, and rest


def cases(size: str) -> list[Any]:
    """Block, foundation, law, noise and number of each run; each has a hold and a rest."""
    everywhere, of_sensors = (EVERYWHERE, OF_SENSORS) if size == "full" else (("white",), ("white and slow",))
    return [
        (block, foundation, model, noise, i)
        for model in PAPER_MODELS
        for block in CONFIGURATIONS
        for place, foundation in enumerate(FOUNDATIONS)
        for i in range(RUNS[size])
        for noise in (*everywhere, *(of_sensors if block in BLOCKS and i % len(FOUNDATIONS) == place else ()))
    ]


def rows_of(case: Any) -> list[Row]:
    """Rows of one run, with the Cramér-Rao bound of white noise beside each number."""
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
    since_release = motion.time_s - motion.time_s[0]
    bound = standard_errors(
        model, truth.block, truth.parameters, since_release, truth.theta0, truth.sigma_theta
    )
    own = {"block": block, "foundation": foundation, "model": model, "run": i}
    return [
        row | own | {"bound": bound[row["parameter"]]}
        for row in rows_of_fit(f"{model}, {noise}", fit, dict(truth.parameters))
    ]


STUDY = Study(cases, rows_of, [*NUMBERS, "block", "foundation", "model", "run", "bound"])
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
