"""Runs that differ by more than their noise: do the intervals of their mean and of the next run hold?"""

import math

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.identification.fit import fit_run
from freerock.populations.random_effects import population
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.virtual_run import SEED, Row, Truth, rows_of_all, virtual_motion

MODEL, PARAMETERS = "hunt_crossley", ("k", "lambda")
RECORDS = {"full": 200, "small": 2}  # of each case
N_RUNS = (3, 10)
SPREADS = (0.0, 0.03)  # of ln k and ln λ between runs
SIGMA = math.radians(0.01)
STILL_S = (2.0, 2.0)


def run(size: str = "full") -> pd.DataFrame:
    """Records whose runs have k and λ of their own, each run fitted by itself, and one run more.

    Parameters
    ----------
    size : str
        "full", or "small" for seconds.

    Returns
    -------
    pandas.DataFrame
        A row per record and parameter, all of the logarithm of the parameter: n_runs, spread, block,
        foundation, parameter, error (of the mean of the runs), error_of_truths (of the mean of the runs' own
        truths), stderr, inside (the 95 % interval of the mean holds that of the population), next_inside (the
        interval of the next run holds the fit of one run more), tau, tau_inside, p (that noise alone scatters
        the runs as much).
    """
    cases = [(n, spread, i) for i in range(RECORDS[size]) for spread in SPREADS for n in N_RUNS]
    return pd.DataFrame(rows_of_all(record, cases))


def record(case: tuple[int, float, int]) -> list[Row]:
    """Rows of one record."""
    n_runs, spread, number = case
    generator = np.random.default_rng([SEED, 5, n_runs, SPREADS.index(spread), number])
    block = list(CONFIGURATIONS)[number % len(CONFIGURATIONS)]
    foundation = list(FOUNDATIONS)[number // len(CONFIGURATIONS) % len(FOUNDATIONS)]
    centre = np.log([FOUNDATIONS[foundation][name] for name in PARAMETERS])
    truths, values, errors = (np.empty((n_runs + 1, len(PARAMETERS))) for _ in range(3))
    for i in range(n_runs + 1):
        truths[i] = centre + spread * generator.standard_normal(len(PARAMETERS))
        values[i], errors[i] = _fitted(block, truths[i], generator)
    found = [population(values[:-1, j], errors[:-1, j]) for j in range(len(PARAMETERS))]
    return [
        {
            "n_runs": n_runs,
            "spread": spread,
            "block": block,
            "foundation": foundation,
            "parameter": name,
            "error": each.mean - centre[j],
            "error_of_truths": truths[:-1, j].mean() - centre[j],
            "stderr": each.stderr,
            "inside": each.low <= centre[j] <= each.high,
            "next_inside": each.next_low <= values[-1, j] <= each.next_high,
            "tau": each.tau,
            "tau_inside": each.tau_low <= spread <= each.tau_high,
            "p": each.p,
        }
        for j, (name, each) in enumerate(zip(PARAMETERS, found, strict=True))
    ]


def _fitted(name: str, truth: Floats, generator: np.random.Generator) -> tuple[Floats, Floats]:
    """Logarithms of the parameters of a run, and their standard errors."""
    block, theta0, _ = CONFIGURATIONS[name]
    values = dict(zip(PARAMETERS, np.exp(truth).tolist(), strict=True))
    motion = virtual_motion(Truth(MODEL, block, values, theta0, SIGMA), generator, still_s=STILL_S)
    if motion is None:
        raise ValueError(f"{name} overturns")  # no truth of this study is that soft
    fit = fit_run(MODEL, block, motion)
    n = len(PARAMETERS)
    return np.log(fit.value[:n]), fit.stderr[:n] / fit.value[:n]
