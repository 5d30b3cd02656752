"""Does the identification find the minimum?"""

import math
import time as clock
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.fit import fit_record, fit_run
from freerock.models.laws import PAPER_MODELS
from freerock.studies.virtual_run import Row, drawn_run, rows_of_all

RUNS = {"full": 1000, "small": 4}  # random truths of each law
EXCESS = 1.0  # of the squared residual over σ², up to which two fits are in one minimum: a standard error


def run(size: str = "full") -> pd.DataFrame:
    """Whether fits from the automatic start end in the minimum that a fit from the truth ends in.

    Returns
    -------
    pandas.DataFrame
        One row per case: the truth (SI units, sigma_deg in degrees), overturned (draws thrown away before
        it), excess (of the squared residual over that from the truth, in σ²), reached (no excess), reported
        (the program itself says that the fit failed) and fit_s, the time of the fit [s].
    """
    cases = [(model, i) for model in PAPER_MODELS for i in range(RUNS[size])]
    return pd.DataFrame(rows_of_all(_success, cases))


def _success(case: Any) -> list[Row]:
    model, i = case
    truth, motion, overturned = drawn_run(model, ("white", "coloured"), (1, PAPER_MODELS.index(model), i))
    begin = clock.perf_counter()
    fit = fit_run(model, truth.block, motion)
    elapsed = clock.perf_counter() - begin
    best = fit_record(model, truth.block, [motion], start=list(truth.parameters.values()))
    excess = (np.sum(fit.residual**2) - np.sum(best.residual**2)) / motion.sigma_theta**2
    return [
        {
            "model": model,
            "case": i,
            "noise": truth.noise,
            "height_m": truth.block.height_m,
            "sigma_deg": math.degrees(truth.sigma_theta),
            **{name: truth.parameters.get(name, math.nan) for name in ("r", "k", "c", "lambda")},
            "overturned": overturned,
            "excess": excess,
            "reached": bool(excess < EXCESS),
            "reported": not fit.success,
            "message": fit.message,
            "fit_s": elapsed,
        }
    ]
