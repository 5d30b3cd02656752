"""Does the identification find the minimum?"""

import math
import time as clock
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from freerock.identification.fit import Fit, fit_record, fit_run
from freerock.models.laws import LAWS, PAPER_MODELS
from freerock_bench.virtual_run import Row, Truth, draw_truth, drawn_run, rows_of_all

FOUNDATIONS = [model for model in PAPER_MODELS if LAWS[model].is_foundation]
RUNS = {"full": 1000, "small": 4}  # random truths of each law
DEMANDING = {"full": 500, "small": 1}  # further ones of each law of a foundation
LEAST_TO_MOST = {"c": (1e-4, 2e-2), "lambda": (0.4, 50.0)}  # ratio to k of these [s, s/m]
RELEASES = (0.3, 0.95)  # of the critical angle
FINEST = 1e-14  # rtol of their truths
EXCESS = 1.0  # of the squared residual over σ², up to which two fits are in one minimum: a standard error


def run(size: str = "full") -> pd.DataFrame:
    """Whether fits from the automatic start end in the minimum.

    Returns
    -------
    pandas.DataFrame
        One row per case: the truth (SI units, sigma_deg in degrees), release (over the critical angle),
        demanding (drawn by `demanding`), overturned (draws thrown away before it), excess (of the squared
        residual over that of a fit from the truth, of a demanding case over that of the truth itself, in σ²),
        reached (no excess), reported (the program itself says that the fit failed), error_k (of k, in
        standard errors) and fit_s, the time of the fit [s].
    """
    cases = [(model, i, False) for model in PAPER_MODELS for i in range(RUNS[size])]
    cases += [(model, i, True) for model in FOUNDATIONS for i in range(DEMANDING[size])]
    return pd.DataFrame(rows_of_all(success, cases))


def demanding(model: str, noises: Sequence[str], generator: np.random.Generator) -> Truth:
    """Any block, hardly damped or not, released from any angle up to 0.95 of the critical one.

    The least λ/k damps about as much as the least c/k, at the depths of an impact. Some of these motions
    multiply errors; the truth is integrated as exactly as double precision allows.
    """
    truth = draw_truth(model, noises, generator)
    (damping,) = LAWS[model].dampings
    k, ratio = truth.parameters["k"], 10 ** generator.uniform(*np.log10(LEAST_TO_MOST[damping]))
    angle = generator.uniform(*RELEASES) * truth.block.theta_cr
    return replace(truth, parameters={"k": k, damping: k * ratio}, theta0=angle, rtol=FINEST)


def success(case: tuple[str, int, bool]) -> list[Row]:
    """The row of a case: law, number, and whether it is a demanding one."""
    model, i, demands = case
    noises, key = ("white", "coloured"), (1, PAPER_MODELS.index(model), i)
    if demands:
        truth, motion, overturned = drawn_run(model, noises, (*key, 1), demanding)
    else:
        truth, motion, overturned = drawn_run(model, noises, key)
    begin = clock.perf_counter()
    fit = fit_run(model, truth.block, motion)
    elapsed = clock.perf_counter() - begin
    if demands:
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
            "release": truth.theta0 / truth.block.theta_cr,
            "demanding": demands,
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
