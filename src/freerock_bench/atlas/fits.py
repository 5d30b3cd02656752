"""Maps of the stability atlas in which a motion with noise is fitted."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from freerock.arrays import Floats
from freerock.identification.fit import fit_run
from freerock.identification.settings import FitSettings
from freerock.models.simulate import Solver, simulate_theta
from freerock.runs.motion import Motion
from freerock_bench.atlas.cells import (
    BLOCK,
    MARBLE,
    RATIO,
    SAMPLING_HZ,
    THETA0,
    Cell,
    Judgement,
    Row,
    problem_of,
    row,
    sampled,
)
from freerock_bench.methods.by_name import freerock
from freerock_bench.methods.problem import Problem

SIGMA_RAD = math.radians(0.01)  # noise of the motions
RESTITUTION_ERROR = 1e-3  # largest error of a fitted r
FLOOR = 1.5  # a fit has reached the noise if its residual is within this factor of it
REACHED = 0.95  # share of trials that makes a fit converged
HORIZONS_S = (0.4, 0.8, 1.6, 3.2, math.inf)  # of the fit that grows


def housner_fit_map(size: str) -> list[Row]:
    """True restitution against length of record: which minimum of ε(r) is found?

    The record is Housner's own motion with the noise of a laser, cut where the motion is lost in it, as
    runs are; the baseline is a bounded minimisation over 0.05 <= r <= 1 without a scan.
    """
    made = []
    for r in [0.75, 0.8, 0.85, 0.895, 0.93, 0.958, 0.97, 0.98, 0.99] if size == "full" else [0.958]:
        problem = Problem("housner", BLOCK, {"r": r}, THETA0)
        for span in [0.5, 1.0, 2.0, 4.0, 8.0] if size == "full" else [2.0]:
            pipeline = "run cut at rest; r scanned, then fitted from the lowest point"
            cell = Cell("housner_fit", problem, ("true r", r), ("record [s]", span), pipeline)
            for method, (value, evaluations, refusal) in _restitution(problem, sampled(span)).items():
                error = abs(value - r)
                state, cause = "refused", refusal
                if not refusal and error > RESTITUTION_ERROR:
                    state, cause = "inaccurate", f"false minimum at r = {value:.3f}"
                elif not refusal:
                    state, cause = "converged", ""
                made.append(row(cell, method, Judgement(state, cause, error, evaluations, "error of r")))
    return made


def _restitution(problem: Problem, time: Floats) -> dict[str, tuple[float, float, str]]:
    """Restitution of a motion with noise by two methods, with evaluations and the reason of a failure."""
    clean = freerock(problem, time, 1e-8).theta
    length = np.flatnonzero(np.abs(clean) > SIGMA_RAD)[-1] + 1
    time = time[:length]
    theta = clean[:length] + np.random.default_rng(1).normal(0, SIGMA_RAD, length)

    def mean_square(trial: float) -> float:
        modelled, _ = simulate_theta("housner", BLOCK, {"r": trial}, time, theta0=THETA0)
        return float(np.mean((modelled - theta) ** 2))

    plain = minimize_scalar(mean_square, bounds=(0.05, 1.0), method="bounded")
    fit = fit_run(
        "housner",
        BLOCK,
        Motion(time, theta, SIGMA_RAD, THETA0, theta0_stderr=SIGMA_RAD),
        FitSettings(free=()),
    )
    return {
        "bounded minimisation": (plain.x, plain.nfev, ""),
        "freerock": (fit.value[0], fit.diagnostics["evaluations"], "" if fit.success else fit.message),
    }


def fit_map(size: str) -> list[Row]:
    """Distance of the start from the truth against length of record: does a fit reach the noise?

    Hunt-Crossley, k, λ and θ0 free; several trials per cell with k and λ off by the stated factor, up or
    down. The baseline is Levenberg and Marquardt's method on the whole record at once, with the
    integrator's noise in its difference quotients (rtol 1e-4, default steps) and without, and over
    horizons that grow.
    """
    trials = 6 if size == "full" else 1
    made = []
    for span in [0.4, 0.8, 1.6, 3.2, 8.0] if size == "full" else [0.8]:
        time = np.arange(0.0, span, 2 / SAMPLING_HZ)
        problem = problem_of("hunt_crossley", MARBLE["k"], RATIO["hunt_crossley"])
        clean = freerock(problem, time, 1e-10).theta
        thetas = [
            clean + np.random.default_rng(trial).normal(0, SIGMA_RAD, time.size) for trial in range(trials)
        ]
        scanned = sum(_scanned(time, theta) for theta in thetas)
        for factor in [1.1, 1.5, 2.0, 3.0, 5.0, 10.0] if size == "full" else [1.1]:
            pipeline = "scans for its start, then grows the horizon"
            x, y = ("start off by a factor of", factor), ("record [s]", span)
            cell = Cell("fit", problem, x, y, pipeline)
            for method, count in (_local(time, thetas, factor) | {"freerock": scanned}).items():
                share = count / trials
                good = share >= REACHED
                state, cause = ("converged", "") if good else ("inaccurate", "local minimum")
                found = Judgement(state, cause, share, measure="share of trials at the noise")
                made.append(row(cell, method, found))
    return made


def _scanned(time: Floats, theta: Floats) -> bool:
    """Whether the identification reaches the noise."""
    motion = Motion(time, theta, SIGMA_RAD, THETA0, theta0_stderr=SIGMA_RAD)
    fit = fit_run("hunt_crossley", BLOCK, motion, FitSettings(free=("theta0",)))
    return bool(np.std(fit.residual) < FLOOR * SIGMA_RAD)


def _local(time: Floats, thetas: list[Floats], factor: float) -> dict[str, int]:
    """How often each local fit reaches the noise from a start that is off by a factor."""
    methods: dict[str, Callable[..., Any]] = {
        "least squares, rtol 1e-4": partial(_fitted, rtol=1e-4, diff_step=None),
        "least squares": _fitted,
        "least squares over growing horizons": _grown,
    }
    reached = dict.fromkeys(methods, 0)
    for trial, theta in enumerate(thetas):
        up_or_down = np.random.default_rng(trial).choice([-1.0, 1.0], 2)
        k, lam = np.array([MARBLE["k"], MARBLE["lambda"]]) * factor**up_or_down
        for method, solve in methods.items():
            result = solve([math.log(k), math.log(lam), THETA0], time, theta)
            reached[method] += int(np.std(result.fun) < FLOOR * SIGMA_RAD)
    return reached


def _fitted(
    start: list[float], time: Floats, theta: Floats, rtol: float = 1e-7, diff_step: float | None = 1e-6
) -> Any:
    """Levenberg-Marquardt fit of ln k, ln λ and θ0."""

    def residual(x: Floats) -> Floats:
        k, lam = np.exp(np.clip(x[:2], 0, 60))
        parameters, solver = {"k": k, "lambda": lam}, Solver(rtol, max_steps=100_000)
        modelled, _ = simulate_theta("hunt_crossley", BLOCK, parameters, time, theta0=x[2], solver=solver)
        return np.nan_to_num(modelled, nan=math.pi / 2) - theta

    return least_squares(residual, start, method="lm", diff_step=diff_step, max_nfev=200)


def _grown(start: list[float], time: Floats, theta: Floats) -> Any:
    for until in HORIZONS_S:
        if until < time[-1] or until == math.inf:
            start = (result := _fitted(start, time[time <= until], theta[time <= until])).x
    return result
