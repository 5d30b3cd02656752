"""Does the identification find the minimum?"""

import math
import time as clock
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from freerock.identification.fit import Fit, fit_record, fit_run
from freerock.models.laws import PAPER_MODELS
from freerock.studies.virtual_run import Row, Truth, draw_truth, drawn_run, rows_of_all
from freerock.virtual_lab.palermo import CONFIGURATIONS

RUNS = {"full": 1000, "small": 4}  # random truths of each law
HARDLY_DAMPED = {"full": 120, "small": 1}  # further ones of Winkler's
LEAST_DAMPED_S = (1e-4, 1e-3)  # c/k of these
RELEASES = (0.3, 0.95)  # of the critical angle
FINEST = 1e-14  # rtol of their truths
EXCESS = 1.0  # of the squared residual over σ², up to which two fits are in one minimum: a standard error


def run(size: str = "full") -> pd.DataFrame:
    """Whether fits from the automatic start end in the minimum that a fit from the truth ends in.

    Returns
    -------
    pandas.DataFrame
        One row per case: the truth (SI units, sigma_deg in degrees), hardly_damped (of `hardly_damped`),
        overturned (draws thrown away before it), excess (of the squared residual over that from the truth,
        of hardly damped blocks over that of the truth, in σ²), reached (no excess), reported (the program
        itself says that the fit failed), error_k (of k, in standard errors) and fit_s, the time of the fit
        [s].
    """
    cases = [(model, i, False) for model in PAPER_MODELS for i in range(RUNS[size])]
    cases += [("winkler", i, True) for i in range(HARDLY_DAMPED[size])]
    return pd.DataFrame(rows_of_all(success, cases))


def hardly_damped(model: str, noises: Sequence[str], generator: np.random.Generator) -> Truth:
    """A squat block that rattles: c/k from 1e-4 s, releases up to 0.95 of the critical angle.

    Its motion multiplies errors; the truth is integrated as exactly as double precision allows.
    """
    truth = draw_truth(model, noises, generator)
    block, _, _ = CONFIGURATIONS["config3"]
    k, share = truth.parameters["k"], 10 ** generator.uniform(*np.log10(LEAST_DAMPED_S))
    angle = generator.uniform(*RELEASES) * math.atan(block.b / block.h)
    return replace(truth, block=block, parameters={"k": k, "c": k * share}, theta0=angle, rtol=FINEST)


def success(case: tuple[str, int, bool]) -> list[Row]:
    """The row of a case: law, number, and whether it is hardly damped."""
    model, i, low = case
    noises, key = ("white", "coloured"), (1, PAPER_MODELS.index(model), i)
    if low:
        truth, motion, overturned = drawn_run(model, noises, (*key, 1), hardly_damped)
    else:
        truth, motion, overturned = drawn_run(model, noises, key)
    begin = clock.perf_counter()
    fit = fit_run(model, truth.block, motion)
    elapsed = clock.perf_counter() - begin
    if low:
        best = truth.motion(motion.time_s - motion.time_s[0])[0] - motion.theta
    else:
        best = fit_record(model, truth.block, [motion], start=list(truth.parameters.values())).residual
    excess = (np.sum(fit.residual**2) - np.sum(best**2)) / motion.sigma_theta**2
    return [
        {
            "model": model,
            "case": i,
            "noise": truth.noise,
            "height_m": truth.block.height_m,
            "sigma_deg": math.degrees(truth.sigma_theta),
            **{name: truth.parameters.get(name, math.nan) for name in ("r", "k", "c", "lambda")},
            "hardly_damped": low,
            "overturned": overturned,
            "excess": excess,
            "reached": bool(excess < EXCESS),
            "reported": not fit.success,
            "message": fit.message,
            "error_k": _error_k(fit, truth),
            "fit_s": elapsed,
        }
    ]


def _error_k(fit: Fit, truth: Truth) -> float:
    """Of k, in standard errors."""
    if "k" not in fit.parameters:
        return math.nan
    i = fit.parameters.index("k")
    return float((fit.value[i] - truth.parameters["k"]) / fit.stderr[i])
