"""Stability atlas: where each method converges, is inaccurate, unstable, too slow or refuses, and why.

Every map varies two quantities of one scene, configuration 2 on marble unless said otherwise, and says for
each cell and method what happened, by which measure, and what the analysis does there. Work is limited by
counts of steps and evaluations, never by a clock, so that the atlas is the same on every machine.
"""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from scipy.optimize import least_squares, minimize_scalar

from freerock.errors import FreerockError
from freerock.identification.fit import fit_run
from freerock.models.block import Block
from freerock.models.laws import LAWS, PARAMETERS
from freerock.models.simulate import DEBONDING, simulate_theta
from freerock.runs.motion import Motion
from freerock.studies.methods import HOUSNER_METHODS, METHODS, Scene, Solution, freerock
from freerock.studies.speed_accuracy import WINKLER, cyrk_installed
from freerock.virtual_lab.record import CONFIGURATIONS, FOUNDATIONS

STATES = ("converged", "inaccurate", "unstable", "too_slow", "refused")
CONVERGED = 1e-6  # largest ε_θ against the reference
AGREED = 1e-8  # largest ε_θ between two methods that make a reference
CONDITIONED = 1e-2  # the same for the exact motion from an angle of release known to a laser's error
AMPLIFIED = 1e3  # turns a relative error of RTOL into one whose square is CONVERGED
STEPS_PER_SECOND = 50_000  # of motion; beyond it a method is too slow: a fit makes hundreds of runs
EVALUATIONS_PER_SECOND = 20_000  # the same for methods called from Python
RTOL = 1e-6  # of the adaptive methods under study
STEP_S = 1e-4  # of the fixed-step methods, where the map does not vary it
SAMPLING_HZ = 1000.0
RESTITUTION_ERROR = 1e-3  # largest error of a fitted r
FLOOR = 1.5  # a fit has reached the noise if its residual is within this factor of it
REACHED = 0.95  # share of trials that makes a fit converged
ALPHA_ERROR_DEG = 0.01  # of a measured angle of release
BLOCK, THETA0, _ = CONFIGURATIONS["config2"]
MARBLE = FOUNDATIONS["marble"]
RATIO = {
    "winkler": WINKLER["marble"]["c"] / WINKLER["marble"]["k"],
    "hunt_crossley": MARBLE["lambda"] / MARBLE["k"],
}
DAMPING = {model: LAWS[model].dampings[0] for model in RATIO}
COLUMNS = ["map", "method", "model", "debonding", "x", "x_value", "y", "y_value"]
COLUMNS += ["state", "cause", "measure", "value", "evaluations", "pipeline"]


def stability(size: str = "full") -> pd.DataFrame:
    """All maps of the atlas, one row per cell and method.

    Parameters
    ----------
    size : str
        "full", or "small": a few cells of each map, without CyRK.

    Returns
    -------
    pandas.DataFrame
        Columns map, method, model, debonding, x and y (names of the quantities varied), x_value and
        y_value, state (one of STATES), cause, measure and value (what the state is judged by),
        evaluations, pipeline (what the analysis does in the cell).
    """
    maps = (stiffness_map, step_map, release_map, springs_map, tail_map, housner_fit_map, fit_map)
    return pd.DataFrame([row for each in maps for row in each(size)], columns=COLUMNS)


# Judging a cell


def scene_of(
    model: str, k: float, ratio: float, debonding: str = "geometric", theta0: float = THETA0
) -> Scene:
    """Configuration 2 with stiffness k [N/m²] and damping by its ratio to k [s or s/m]."""
    return Scene(model, BLOCK, {"k": k, DAMPING[model]: ratio * k}, theta0, debonding)


def discrepancy(a: Solution, b: Solution) -> float:
    """ε of a against b over the samples before either overturns; inf where only one of them does."""
    if a.outcome != b.outcome or a.outcome not in ("completed", "overturned"):
        return math.inf
    both = np.isfinite(a.theta) & np.isfinite(b.theta)
    a, b = a.theta[both], b.theta[both]
    return float((a - b) @ (a - b) / (b @ b)) if a.size else 0.0


def reference(scene: Scene, time, size: str) -> Solution | None:
    """Motion on which two independent methods agree within AGREED; None where there are none.

    freerock, an explicit 8(5,3) pair and implicit methods, each at a tight tolerance.
    """
    limit = 20 * STEPS_PER_SECOND * time[-1]
    if _compiled_solvers(size):
        tight = {"CyRK DOP853": 1e-10, "CyRK RADAU": 1e-9, "CyRK LSODA": 1e-9}
    else:
        tight = {"SciPy DOP853, numba": 1e-9, "SciPy Radau, numba": 1e-9}
    found = []
    for name, rtol in ({"freerock": 1e-10} | tight).items():
        new = _attempt(METHODS[name], scene, time, rtol, limit)
        if any(discrepancy(new, old) < AGREED for old in found):
            return new
        found.append(new)
    return None


def amplification(scene: Scene, time) -> float:
    """Relative change of θ(t), root mean square, over a relative change of the angle of release."""
    small, limit = 1e-8, STEPS_PER_SECOND * time[-1]
    shifted = replace(scene, theta0=scene.theta0 * (1 + small))
    moved, still = (_attempt(freerock, each, time, 1e-11, limit) for each in (shifted, scene))
    return math.sqrt(discrepancy(moved, still)) / small


def _compiled_solvers(size: str) -> bool:
    """Whether CyRK is to be used: it compiles for half a minute."""
    return size == "full" and cyrk_installed()


def judge(solution: Solution, true: Solution | None, threshold: float = CONVERGED) -> tuple:
    """State, cause and ε_θ of a solution against the reference."""
    if solution.outcome == "step_limit":
        return "too_slow", "more steps than allowed", math.nan
    if solution.outcome in ("non_finite", "not_converged"):
        causes = {"non_finite": "state not finite", "not_converged": "Newton's iteration does not converge"}
        return "unstable", causes[solution.outcome], math.nan
    if true is None:
        return "inaccurate", "no two methods agree", math.nan
    epsilon = discrepancy(solution, true)
    if epsilon == math.inf:
        return "unstable", f"{solution.outcome}, where the true motion is {true.outcome}", epsilon
    if epsilon > threshold:
        return "inaccurate", "error above the threshold", epsilon
    return "converged", "the block overturns" if true.outcome == "overturned" else "", epsilon


def _attempt(method, scene, time, setting, limit) -> Solution | FreerockError:
    try:
        return method(scene, time, setting, limit)
    except FreerockError as error:
        return error
    except ArithmeticError:
        return Solution(np.full(time.size, math.nan), math.nan, "non_finite")


def _row(name, method, scene, x, y, state, cause, measure, value, evaluations=math.nan, pipeline=""):
    return [
        name,
        method,
        scene.model,
        scene.debonding,
        *x,
        *y,
        state,
        cause,
        measure,
        value,
        evaluations,
        pipeline,
    ]


def _rows(name, methods, scene, time, x, y, pipeline, true):
    """One row per method; `methods` maps names to (method, setting, limit)."""
    rows, sensitive = [], None
    for method, (solve, setting, limit) in methods.items():
        solution = _attempt(solve, scene, time, setting, limit)
        if isinstance(solution, FreerockError):
            state, cause, epsilon, evaluations = "refused", solution.what, math.nan, 0
        else:
            threshold = CONDITIONED if solve is _from_a_wrong_angle else CONVERGED
            (state, cause, epsilon), evaluations = judge(solution, true, threshold), solution.evaluations
            if state == "inaccurate" and solve is not _from_a_wrong_angle and scene.model != "housner":
                sensitive = sensitive or amplification(scene, time)
                if sensitive > AMPLIFIED:
                    cause = f"the motion multiplies errors by 1e{math.log10(sensitive):.0f}"
        rows.append(_row(name, method, scene, x, y, state, cause, "epsilon", epsilon, evaluations, pipeline))
    return rows


def pipeline_of(scene: Scene, time) -> str:
    """What a fit does with the parameters of a scene."""
    k, damping = scene.parameters["k"], scene.parameters[DAMPING[scene.model]]
    (softest, stiffest), (low, high) = PARAMETERS["k"].bounds, PARAMETERS[DAMPING[scene.model]].bounds
    if not (softest <= k <= stiffest and low <= damping / k <= high):
        return "outside the bounds of the fit: never reached"
    _, outcome = simulate_theta(
        scene.model, scene.block, scene.parameters, time, theta0=scene.theta0, debonding=scene.debonding
    )
    if outcome == "overturned":
        return "inside the bounds: the fit takes the block to lie at ±90°"
    return (
        "inside the bounds: fitted"
        if outcome in ("completed", "at_rest")
        else f"inside the bounds: {outcome}"
    )


def _adaptive(size: str, span_s: float) -> dict:
    steps, evaluations = STEPS_PER_SECOND * span_s, EVALUATIONS_PER_SECOND * span_s
    methods = {"freerock": (freerock, RTOL, steps)}
    if _compiled_solvers(size):
        for name in ("DOP853", "LSODA", "RADAU"):
            methods[f"CyRK {name}"] = (METHODS[f"CyRK {name}"], RTOL, steps)
    else:
        for name in ("DOP853", "LSODA", "Radau"):
            methods[f"SciPy {name}, numba"] = (METHODS[f"SciPy {name}, numba"], RTOL, evaluations)
    return methods


def _fixed(step: float, span_s: float) -> dict:
    return {name: (METHODS[name], step, STEPS_PER_SECOND * span_s) for name in ("RK4", "Newmark")}


def _sampled(span_s: float) -> np.ndarray:
    return np.arange(0.0, span_s, 1 / SAMPLING_HZ)


# Maps


def stiffness_map(size: str) -> list:
    """Stiffness k against damping ratio, both laws, both debonding rules, all methods; 2 s of motion."""
    span = 2.0 if size == "full" else 0.5
    time = _sampled(span)
    ks = np.geomspace(1e3, 1e13, 21) if size == "full" else [1e5, 1e8]
    ratios = {"winkler": np.geomspace(1e-6, 1e1, 8), "hunt_crossley": np.geomspace(1e-3, 1e5, 9)}
    if size == "small":
        ratios = {model: [ratio] for model, ratio in RATIO.items()}
    rows = []
    for model in ratios:
        for debonding in DEBONDING if size == "full" else [DEBONDING[model == "winkler"]]:
            for k in ks:
                for ratio in ratios[model]:
                    scene = scene_of(model, k, ratio, debonding)
                    rows += _rows(
                        "stiffness",
                        _adaptive(size, span) | _fixed(STEP_S, span),
                        scene,
                        time,
                        ("k [N/m²]", k),
                        (f"{DAMPING[model]}/k [{PARAMETERS[DAMPING[model]].ratio_unit}]", ratio),
                        pipeline_of(scene, time),
                        reference(scene, time, size),
                    )
    return rows


def step_map(size: str) -> list:
    """Step of the fixed-step methods against stiffness, at the damping ratio of Table 2; 1 s of motion."""
    span = 1.0 if size == "full" else 0.5
    time = _sampled(span)
    steps = np.geomspace(1e-5, 1e-2, 10) if size == "full" else [1e-4, 1e-3]
    rows = []
    for model, ratio in RATIO.items():
        for k in np.geomspace(1e5, 1e12, 15) if size == "full" else [1e5, 1e9]:
            scene = scene_of(model, k, ratio)
            true = reference(scene, time, size)
            for step in steps:
                methods = {
                    name: (solve, step, limit * 10) for name, (solve, _, limit) in _fixed(step, span).items()
                }
                x, y = ("step [s]", step), ("k [N/m²]", k)
                rows += _rows("step", methods, scene, time, x, y, "not used: steps adapt", true)
    return rows


def release_map(size: str) -> list:
    """Angle of release over the critical one against slenderness h/b; 2 s of motion.

    The block is as wide and as dense as configuration 2. Hunt-Crossley on marble, and Housner's block
    with its own restitution, exact and linearised. "α + 0.01°" is the exact motion from an angle of
    release that is wrong by a laser's error.
    """
    span = 2.0 if size == "full" else 0.5
    time = _sampled(span)
    shares = [0.01, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 0.9999, 1.01, 1.2]
    rows = []
    for slenderness in [0.7, 1, 1.5, 2, 3, 4, 6, 8, 12] if size == "full" else [2]:
        height = BLOCK.width_m * slenderness
        block = Block(height, BLOCK.width_m, BLOCK.mass_kg * height / BLOCK.height_m)
        for share in shares if size == "full" else [0.5, 1.01]:
            theta0 = share * block.theta_cr
            x, y = ("α/θ_cr", share), ("h/b", slenderness)
            pipeline = (
                "refused: held beyond θ_cr" if share > 1 else "fitted, θ₀ within 6 of its standard errors"
            )
            scene = Scene("hunt_crossley", block, MARBLE, theta0)
            near = {"α + 0.01°": (_from_a_wrong_angle, RTOL / 100, STEPS_PER_SECOND * span)}
            rows += _rows(
                "release",
                _adaptive(size, span) | near,
                scene,
                time,
                x,
                y,
                pipeline,
                reference(scene, time, size),
            )
            scene = Scene("housner", block, {"r": block.restitution_housner}, theta0)
            exact = _attempt(freerock, scene, time, 1e-8, math.inf)
            methods = {"freerock": (freerock, 1e-8, math.inf)}
            if not isinstance(exact, FreerockError):
                methods["SciPy DOP853, events"] = (
                    HOUSNER_METHODS["SciPy DOP853, events"],
                    1e-9,
                    20_000 * span,
                )
                if share < 1:
                    methods["linearised"] = (HOUSNER_METHODS["linearised"], 0.0, 2e6)
                methods |= near
            rows += _rows("release", methods, scene, time, x, y, pipeline, exact)
    return rows


def _from_a_wrong_angle(scene, time, rtol, limit):
    return freerock(replace(scene, theta0=scene.theta0 + math.radians(ALPHA_ERROR_DEG)), time, rtol, limit)


def springs_map(size: str) -> list:
    """Number of springs that stand for the foundation against its stiffness; 2 s of motion."""
    span = 2.0 if size == "full" else 0.5
    time = _sampled(span)
    rows = []
    for k in [1e6, 3e6, MARBLE["k"], 3e7, 1e8, 1e9] if size == "full" else [MARBLE["k"]]:
        scene = scene_of("hunt_crossley", k, RATIO["hunt_crossley"])
        true = reference(scene, time, size)
        for n in [2, 5, 10, 20, 50, 100, 200, 500] if size == "full" else [10, 100]:
            methods = {"springs, RK4": (METHODS["RK4"], 2e-5, STEPS_PER_SECOND * span)}
            x, y = ("springs", n), ("k [N/m²]", k)
            pipeline = "not used: the contact is integrated exactly"
            rows += _rows("springs", methods, replace(scene, springs=n), time, x, y, pipeline, true)
    return rows


def tail_map(size: str) -> list:
    """Length of the record against damping: does a dead motion end, and in denormal numbers?

    Winkler, released at 1°. The measure counts the samples of θ that are denormal.
    """
    rows = []
    for factor in [1.0, 10.0, 100.0] if size == "full" else [10.0]:
        scene = scene_of("winkler", WINKLER["marble"]["k"], factor * RATIO["winkler"], theta0=math.radians(1))
        for span in [3.0, 10.0, 30.0, 100.0, 300.0] if size == "full" else [3.0]:
            time = np.arange(0.0, span, 1 / SAMPLING_HZ)
            methods = {
                "freerock": (freerock, RTOL, STEPS_PER_SECOND * span),
                "RK4": (METHODS["RK4"], STEP_S, STEPS_PER_SECOND * span),
            }
            true = reference(scene, _sampled(3.0), size)
            for method, (solve, setting, limit) in methods.items():
                solution = solve(scene, time, setting, limit)
                head = replace(solution, theta=solution.theta[: len(_sampled(3.0))])
                state, cause, _ = judge(head, true)
                small = np.abs(solution.theta)
                denormal = int(np.sum((small > 0) & (small < np.finfo(float).tiny)))
                rows.append(
                    _row(
                        "tail",
                        method,
                        scene,
                        ("record [s]", span),
                        ("c/k [s]", factor * RATIO["winkler"]),
                        state,
                        cause or ("denormal numbers" if denormal else ""),
                        "denormal samples",
                        denormal,
                        solution.evaluations,
                        "stops at rest: θ = 0 from there on",
                    )
                )
    return rows


def housner_fit_map(size: str) -> list:
    """True restitution against length of record: which minimum of ε(r) is found?

    The record is Housner's own motion with the noise of a laser, cut where the motion is lost in it, as
    runs are; the baseline is a bounded minimisation over 0.05 <= r <= 1 without a scan.
    """
    sigma = math.radians(0.01)
    rows = []
    for r in [0.75, 0.8, 0.85, 0.895, 0.93, 0.958, 0.97, 0.98, 0.99] if size == "full" else [0.958]:
        scene = Scene("housner", BLOCK, {"r": r}, THETA0)
        for span in [0.5, 1.0, 2.0, 4.0, 8.0] if size == "full" else [2.0]:
            time = _sampled(span)
            clean = freerock(scene, time, 1e-8).theta
            length = np.flatnonzero(np.abs(clean) > sigma)[-1] + 1
            time = time[:length]
            theta = clean[:length] + np.random.default_rng(1).normal(0, sigma, length)

            def mean_square(trial, scene=scene, time=time, theta=theta):
                modelled, _ = simulate_theta("housner", BLOCK, {"r": trial}, time, theta0=THETA0)
                return np.mean((modelled - theta) ** 2)

            plain = minimize_scalar(mean_square, bounds=(0.05, 1.0), method="bounded")
            motion = Motion(time, theta, sigma, THETA0, theta0_stderr=sigma)
            fit = fit_run("housner", BLOCK, motion, free=())
            found = {
                "bounded minimisation": (plain.x, plain.nfev, ""),
                "freerock": (
                    fit.value[0],
                    fit.diagnostics["evaluations"],
                    "" if fit.success else fit.message,
                ),
            }
            for method, (value, evaluations, refusal) in found.items():
                error = abs(value - r)
                state, cause = "refused", refusal
                if not refusal and error > RESTITUTION_ERROR:
                    state, cause = "inaccurate", f"false minimum at r = {value:.3f}"
                elif not refusal:
                    state, cause = "converged", ""
                x, y, measure = ("true r", r), ("record [s]", span), "error of r"
                pipeline = "run cut at rest; r scanned, then fitted from the lowest point"
                rows.append(
                    _row(
                        "housner_fit",
                        method,
                        scene,
                        x,
                        y,
                        state,
                        cause,
                        measure,
                        error,
                        evaluations,
                        pipeline,
                    )
                )
    return rows


def fit_map(size: str) -> list:
    """Distance of the start from the truth against length of record: does a fit reach the noise?

    Hunt-Crossley, k, λ and θ0 free; several trials per cell with k and λ off by the stated factor, up or
    down. The baseline is Levenberg and Marquardt's method on the whole record at once, with the
    integrator's noise in its difference quotients (rtol 1e-4, default steps) and without, and over
    horizons that grow.
    """
    sigma = math.radians(0.01)
    trials = 6 if size == "full" else 1
    methods = {
        "least squares, rtol 1e-4": partial(_fitted, rtol=1e-4, diff_step=None),
        "least squares": _fitted,
        "least squares over growing horizons": _grown,
    }
    rows = []
    for span in [0.4, 0.8, 1.6, 3.2, 8.0] if size == "full" else [0.8]:
        time = np.arange(0.0, span, 2 / SAMPLING_HZ)
        scene = scene_of("hunt_crossley", MARBLE["k"], RATIO["hunt_crossley"])
        clean = freerock(scene, time, 1e-10).theta
        thetas = [clean + np.random.default_rng(trial).normal(0, sigma, time.size) for trial in range(trials)]
        scanned = 0
        for theta in thetas:
            motion = Motion(time, theta, sigma, THETA0, theta0_stderr=sigma)
            fit = fit_run("hunt_crossley", BLOCK, motion, free=("theta0",))
            scanned += np.std(fit.residual) < FLOOR * sigma
        for factor in [1.1, 1.5, 2.0, 3.0, 5.0, 10.0] if size == "full" else [1.1]:
            reached = dict.fromkeys(methods, 0)
            for trial, theta in enumerate(thetas):
                up_or_down = np.random.default_rng(trial).choice([-1.0, 1.0], 2)
                k, lam = np.array([MARBLE["k"], MARBLE["lambda"]]) * factor**up_or_down
                for method, solve in methods.items():
                    result = solve([math.log(k), math.log(lam), THETA0], time, theta)
                    reached[method] += np.std(result.fun) < FLOOR * sigma
            for method, count in (reached | {"freerock": scanned}).items():
                share = count / trials
                good = share >= REACHED
                state, cause = ("converged", "") if good else ("inaccurate", "local minimum")
                x, y = ("start off by a factor of", factor), ("record [s]", span)
                measure, pipeline = (
                    "share of trials at the noise",
                    "scans for its start, then grows the horizon",
                )
                rows.append(_row("fit", method, scene, x, y, state, cause, measure, share, pipeline=pipeline))
    return rows


def _fitted(start, time, theta, rtol=1e-7, diff_step=1e-6):
    """Levenberg-Marquardt fit of ln k, ln λ and θ0."""

    def residual(x):
        k, lam = np.exp(np.clip(x[:2], 0, 60))
        modelled, _ = simulate_theta(
            "hunt_crossley", BLOCK, {"k": k, "lambda": lam}, time, theta0=x[2], rtol=rtol, max_steps=100_000
        )
        return np.nan_to_num(modelled, nan=math.pi / 2) - theta

    return least_squares(residual, start, method="lm", diff_step=diff_step, max_nfev=200)


def _grown(start, time, theta):
    for until in (0.4, 0.8, 1.6, 3.2, math.inf):
        if until < time[-1] or until == math.inf:
            start = (result := _fitted(start, time[time <= until], theta[time <= until])).x
    return result
