"""A cell of the stability atlas: what happened to a method, by which measure, what the analysis does there.

Work is limited by counts of steps and evaluations, never by a clock, so that the atlas is the same on every
machine.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.laws import LAWS
from freerock.models.published import BLOCKS, PUBLISHED_BLOCK, RELEASE_ANGLES, TABLE_2
from freerock_bench.methods.by_name import METHODS, Method, freerock
from freerock_bench.methods.foundation import cyrk_installed
from freerock_bench.methods.problem import Problem, Solution

STATES = ("converged", "inaccurate", "unstable", "too_slow", "refused")
CONVERGED = 1e-6  # largest ε_θ against the reference
AGREED = 1e-8  # largest ε_θ between two methods that make a reference
CONDITIONED = 1e-2  # the same for the exact motion from a release angle known to a laser's error
AMPLIFIED = 1e3  # turns a relative error of RTOL into one whose square is CONVERGED
STEPS_PER_SECOND = 50_000  # of motion; beyond it a method is too slow: a fit makes hundreds of runs
EVALUATIONS_PER_SECOND = 20_000  # the same for methods called from Python
RTOL = 1e-6  # of the adaptive methods under study
STEP_S = 1e-4  # of the fixed-step methods, where the map does not vary it
SAMPLING_HZ = 1000.0
RELEASE_ERROR_DEG = 0.01  # of a measured release angle
BLOCK, THETA0 = BLOCKS[PUBLISHED_BLOCK], RELEASE_ANGLES[PUBLISHED_BLOCK]
MARBLE = TABLE_2["marble"]["hunt_crossley"]
WINKLER_MARBLE = TABLE_2["marble"]["winkler"]
RATIO = {
    "winkler": WINKLER_MARBLE["c"] / WINKLER_MARBLE["k"],
    "hunt_crossley": MARBLE["lambda"] / MARBLE["k"],
}
DAMPING = {model: LAWS[model].ratios[0] for model in RATIO}
COLUMNS = ["map", "method", "model", "debonding", "x", "x_value", "y", "y_value"]
COLUMNS += ["state", "cause", "measure", "value", "evaluations", "pipeline"]

Row = dict[str, Any]
Methods = Mapping[str, tuple[Method, float, float]]
"""By name: the method, its tolerance or step, and its limit of steps or evaluations."""


@dataclass(frozen=True)
class Cell:
    """One cell of a map: the quantities varied with their values, and what the analysis does there."""

    map: str
    problem: Problem
    x: tuple[str, float]
    y: tuple[str, float]
    pipeline: str


@dataclass(frozen=True)
class Judgement:
    """What happened to a method: one of STATES, why, and the value of the measure that it is judged by.

    Evaluations are those of the right-hand side, NaN where they are not counted.
    """

    state: str
    cause: str
    value: float
    evaluations: float = math.nan
    measure: str = "epsilon"


def problem_of(
    model: str, k: float, ratio: float, debonding: str = "geometric", theta0: float = THETA0
) -> Problem:
    """Configuration 2 with stiffness k [N/m²] and damping by its ratio to k [s or s/m]."""
    return Problem(model, BLOCK, {"k": k, DAMPING[model]: ratio * k}, theta0, debonding)


def discrepancy(a: Solution, b: Solution) -> float:
    """ε of a against b over the samples before either overturns; inf where only one of them does."""
    if a.outcome != b.outcome or a.outcome not in ("completed", "overturned"):
        return math.inf
    both = np.isfinite(a.theta) & np.isfinite(b.theta)
    one, other = a.theta[both], b.theta[both]
    apart = one - other
    return float(apart @ apart / (other @ other)) if one.size else 0.0


def reference(problem: Problem, time: Floats, size: str) -> Solution | None:
    """Motion on which two independent methods agree within AGREED; None where there are none.

    freerock, an explicit 8(5,3) pair and implicit methods, each at a tight tolerance.
    """
    limit = 20 * STEPS_PER_SECOND * time[-1]
    if _compiled_solvers(size):
        tight = {"CyRK DOP853": 1e-10, "CyRK RADAU": 1e-9, "CyRK LSODA": 1e-9}
    else:
        tight = {"SciPy DOP853, numba": 1e-9, "SciPy Radau, numba": 1e-9}
    found: list[Solution] = []
    for name, rtol in ({"freerock": 1e-10} | tight).items():
        new = attempt(METHODS[name], problem, time, rtol, limit)
        if isinstance(new, FreerockError):
            continue
        if any(discrepancy(new, old) < AGREED for old in found):
            return new
        found.append(new)
    return None


def amplification(problem: Problem, time: Floats) -> float:
    """Relative change of θ(t), root mean square, over a relative change of the release angle."""
    small, limit = 1e-8, STEPS_PER_SECOND * time[-1]
    shifted = replace(problem, theta0=problem.theta0 * (1 + small))
    found = [attempt(freerock, each, time, 1e-11, limit) for each in (shifted, problem)]
    moved, still = (each for each in found if isinstance(each, Solution))
    return math.sqrt(discrepancy(moved, still)) / small


def _compiled_solvers(size: str) -> bool:
    """Whether CyRK is to be used: it compiles for half a minute."""
    return size == "full" and cyrk_installed()


def judge(solution: Solution, true: Solution | None, threshold: float = CONVERGED) -> tuple[str, str, float]:
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


def attempt(
    method: Method, problem: Problem, time: Floats, setting: float, limit: float
) -> Solution | FreerockError:
    """What a method makes of a problem, or how it refuses it."""
    try:
        return method(problem, time, setting, limit)
    except FreerockError as error:
        return error
    except ArithmeticError:
        return Solution(np.full(time.size, math.nan), math.nan, "non_finite")


def row(cell: Cell, method: str, found: Judgement) -> Row:
    """A row of the atlas, columns `COLUMNS`."""
    values = (
        *(cell.map, method, cell.problem.model, cell.problem.debonding, *cell.x, *cell.y),
        *(found.state, found.cause, found.measure, found.value, found.evaluations, cell.pipeline),
    )
    return dict(zip(COLUMNS, values, strict=True))


def rows(cell: Cell, methods: Methods, time: Floats, true: Solution | None) -> list[Row]:
    """One row per method, each judged against the true motion."""
    problem = cell.problem
    sensitive: float | None = None
    made = []
    for method, (solve, setting, limit) in methods.items():
        solution = attempt(solve, problem, time, setting, limit)
        if isinstance(solution, FreerockError):
            made.append(row(cell, method, Judgement("refused", solution.what, math.nan, 0)))
            continue
        shifted = solve is from_a_wrong_angle
        state, cause, epsilon = judge(solution, true, CONDITIONED if shifted else CONVERGED)
        if state == "inaccurate" and not shifted and problem.model != "housner":
            sensitive = sensitive or amplification(problem, time)
            if sensitive > AMPLIFIED:
                cause = f"the motion multiplies errors by 1e{math.log10(sensitive):.0f}"
        made.append(row(cell, method, Judgement(state, cause, epsilon, solution.evaluations)))
    return made


def adaptive(size: str, span_s: float) -> dict[str, tuple[Method, float, float]]:
    """The adaptive methods under study."""
    steps, evaluations = STEPS_PER_SECOND * span_s, EVALUATIONS_PER_SECOND * span_s
    methods = {"freerock": (freerock, RTOL, steps)}
    if _compiled_solvers(size):
        for name in ("DOP853", "LSODA", "RADAU"):
            methods[f"CyRK {name}"] = (METHODS[f"CyRK {name}"], RTOL, steps)
    else:
        for name in ("DOP853", "LSODA", "Radau"):
            methods[f"SciPy {name}, numba"] = (METHODS[f"SciPy {name}, numba"], RTOL, evaluations)
    return methods


def fixed(step: float, span_s: float) -> dict[str, tuple[Method, float, float]]:
    """The fixed-step methods under study."""
    return {name: (METHODS[name], step, STEPS_PER_SECOND * span_s) for name in ("RK4", "Newmark")}


def sampled(span_s: float) -> Floats:
    """Instants of a motion [s]."""
    return np.arange(0.0, span_s, 1 / SAMPLING_HZ)


def from_a_wrong_angle(problem: Problem, time: Floats, rtol: float, limit: float) -> Solution:
    """The exact motion from a release angle that is off by a laser's error."""
    theta0 = problem.theta0 + math.radians(RELEASE_ERROR_DEG)
    return freerock(replace(problem, theta0=theta0), time, rtol, limit)
