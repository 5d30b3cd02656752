"""Stability atlas: where each method converges, is inaccurate, unstable, too slow or refuses, and why.

Every map varies two quantities of one problem, configuration 2 on marble unless said otherwise. Work is
limited by counts of steps and evaluations, never by a clock, so that the atlas is the same on every machine.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import DEBONDING, LAWS
from freerock.virtual_lab.published import BLOCKS, PUBLISHED_BLOCK, RELEASE_ANGLES, TABLE_2
from freerock_bench.document import in_markdown
from freerock_bench.methods.by_name import METHODS, Method, freerock
from freerock_bench.methods.housner import housner_events, housner_linearised
from freerock_bench.methods.problem import Problem, Solution

SEED = 0
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
DAMPING = {model: LAWS[model].ratios[0] for model in ("winkler", "hunt_crossley")}
RATIO = {
    model: TABLE_2["marble"][model][name] / TABLE_2["marble"][model]["k"] for model, name in DAMPING.items()
}
SHARES = (0.01, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 0.9999, 1.01, 1.2)  # of θ_cr
COLUMNS = ["map", "method", "model", "debonding", "x", "x_value", "y", "y_value"]
COLUMNS += ["state", "cause", "epsilon", "evaluations"]

Row = dict[str, Any]
Methods = Mapping[str, tuple[Method, float, float]]
"""By name: the method, its tolerance or step, and its limit of steps or evaluations."""


class Cell(NamedTuple):
    """One cell of a map: the quantities varied with their values."""

    map: str
    problem: Problem
    x: tuple[str, float]
    y: tuple[str, float]


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """All maps of the atlas, one row per cell and method.

    In its small size a few cells of each map, without CyRK.

    Returns
    -------
    pandas.DataFrame
        Columns map, method, model, debonding, x and y (names of the quantities varied), x_value and
        y_value, state (one of STATES), cause, epsilon (ε_θ against the reference), evaluations (NaN if they
        are not counted).
    """
    maps = (stiffness_map, step_map, release_map)
    return pd.DataFrame([row for each in maps for row in each(size)], columns=COLUMNS)


def stiffness_map(size: str) -> Iterator[Row]:
    """Stiffness k against damping ratio, both laws, both debonding rules, all methods; 2 s of motion."""
    span = 2.0 if size == "full" else 0.5
    time = sampled(span)
    ks = np.geomspace(1e3, 1e13, 11) if size == "full" else [1e5, 1e8]
    ratios = {"winkler": np.geomspace(1e-6, 1e1, 8), "hunt_crossley": np.geomspace(1e-3, 1e5, 9)}
    if size == "small":
        ratios = {model: np.array([ratio]) for model, ratio in RATIO.items()}
    for model in ratios:
        quantity = f"{DAMPING[model]}/k [{PARAMETERS[DAMPING[model]].ratio_unit}]"
        for debonding in DEBONDING if size == "full" else [DEBONDING[model == "winkler"]]:
            for k in ks:
                for ratio in ratios[model]:
                    problem = problem_of(model, k, ratio, debonding)
                    cell = Cell("stiffness", problem, ("k [N/m²]", k), (quantity, ratio))
                    methods = adaptive(size, span) | fixed(STEP_S, span)
                    yield from rows(cell, methods, time, reference(problem, time, size))


def step_map(size: str) -> Iterator[Row]:
    """Step of the fixed-step methods against stiffness, at the damping ratio of Table 2; 1 s of motion."""
    span = 1.0 if size == "full" else 0.5
    time = sampled(span)
    steps = np.geomspace(1e-5, 1e-2, 10) if size == "full" else [1e-4, 1e-3]
    for model, ratio in RATIO.items():
        for k in np.geomspace(1e5, 1e12, 15) if size == "full" else [1e5, 1e9]:
            problem = problem_of(model, k, ratio)
            true = reference(problem, time, size)
            for step in steps:
                cell = Cell("step", problem, ("step [s]", step), ("k [N/m²]", k))
                yield from rows(cell, fixed(step, 10 * span), time, true)


def release_map(size: str) -> Iterator[Row]:
    """Release angle over the critical one against slenderness h/b; 2 s of motion.

    The block is as wide and as dense as configuration 2. Hunt-Crossley on marble, and Housner's block
    with its own restitution, exact and linearised. "θ₀ + 0.01°" is the exact motion from a release angle
    that is wrong by a laser's error.
    """
    span = 2.0 if size == "full" else 0.5
    for slenderness in [0.7, 1, 1.5, 2, 3, 4, 6, 8, 12] if size == "full" else [2]:
        height = BLOCK.width_m * slenderness
        block = Block(height, BLOCK.width_m, BLOCK.mass_kg * height / BLOCK.height_m)
        for share in SHARES if size == "full" else [0.5, 1.01]:
            yield from _released(size, span, block, share, slenderness)


def _released(size: str, span: float, block: Block, share: float, slenderness: float) -> Iterator[Row]:
    """A cell of the map of release angles, for Hunt-Crossley's law and for Housner's."""
    time, theta0 = sampled(span), share * block.theta_cr
    x, y = ("θ₀/θ_cr", share), ("h/b", slenderness)
    near = {"θ₀ + 0.01°": (from_a_wrong_angle, RTOL / 100, STEPS_PER_SECOND * span)}
    problem = Problem("hunt_crossley", block, MARBLE, theta0)
    methods = adaptive(size, span) | near
    yield from rows(Cell("release", problem, x, y), methods, time, reference(problem, time, size))
    problem = Problem("housner", block, {"r": block.restitution_housner}, theta0)
    exact = attempt(freerock, problem, time, 1e-8, math.inf)
    methods = {"freerock": (freerock, 1e-8, math.inf)}
    if isinstance(exact, FreerockError):
        yield from rows(Cell("release", problem, x, y), methods, time, None)
        return
    methods["SciPy DOP853, events"] = (housner_events, 1e-9, EVALUATIONS_PER_SECOND * span)
    if share < 1:
        methods["linearised"] = (housner_linearised, 0.0, 2e6)
    yield from rows(Cell("release", problem, x, y), methods | near, time, exact)


def problem_of(model: str, k: float, ratio: float, debonding: str = "geometric") -> Problem:
    """Configuration 2 with stiffness k [N/m²] and damping by its ratio to k [s or s/m]."""
    return Problem(model, BLOCK, {"k": k, DAMPING[model]: ratio * k}, THETA0, debonding)


def rows(cell: Cell, methods: Methods, time: Floats, true: Solution | None) -> Iterator[Row]:
    """One row per method, each judged against the true motion."""
    problem = cell.problem
    sensitive: float | None = None
    for method, (solve, setting, limit) in methods.items():
        solution = attempt(solve, problem, time, setting, limit)
        if isinstance(solution, FreerockError):
            found: tuple[object, ...] = ("refused", solution.what, math.nan, 0)
        else:
            shifted = solve is from_a_wrong_angle
            state, cause, epsilon = judge(solution, true, CONDITIONED if shifted else CONVERGED)
            if state == "inaccurate" and not shifted and problem.model != "housner":
                sensitive = sensitive or amplification(problem, time)
                if sensitive > AMPLIFIED:
                    cause = f"the motion multiplies errors by 1e{math.log10(sensitive):.0f}"
            found = (state, cause, epsilon, solution.evaluations)
        where = (cell.map, method, problem.model, problem.debonding, *cell.x, *cell.y)
        yield dict(zip(COLUMNS, (*where, *found), strict=True))


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
    tight = {"freerock": 1e-10, "SciPy DOP853, numba": 1e-9, "SciPy Radau, numba": 1e-9}
    if size == "full":  # CyRK compiles for half a minute
        tight = {"freerock": 1e-10, "CyRK DOP853": 1e-10, "CyRK RADAU": 1e-9, "CyRK LSODA": 1e-9}
    found: list[Solution] = []
    for name, rtol in tight.items():
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


def adaptive(size: str, span_s: float) -> dict[str, tuple[Method, float, float]]:
    """The adaptive methods under study."""
    steps, evaluations = STEPS_PER_SECOND * span_s, EVALUATIONS_PER_SECOND * span_s
    names, limit = [f"SciPy {name}, numba" for name in ("DOP853", "LSODA", "Radau")], evaluations
    if size == "full":
        names, limit = [f"CyRK {name}" for name in ("DOP853", "LSODA", "RADAU")], steps
    return {"freerock": (freerock, RTOL, steps)} | {name: (METHODS[name], RTOL, limit) for name in names}


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


def markdown(frame: pd.DataFrame) -> str:
    """A row per map, law and method: how many cells have each state."""
    counts = pd.crosstab([frame["map"], frame["model"], frame["method"]], frame["state"])
    shown = counts.reindex(columns=STATES, fill_value=0)
    rows = [[*key, *cells] for key, cells in zip(shown.index, shown.to_numpy().tolist(), strict=True)]
    return in_markdown(["map", "law", "method", *(state.replace("_", " ") for state in STATES)], rows)
