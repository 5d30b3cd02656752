"""Maps of the stability atlas in which a motion is integrated.

Every map varies two quantities of one problem, configuration 2 on marble unless said otherwise.
"""

import math
from dataclasses import replace

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.laws import DEBONDING, PARAMETERS, Rules
from freerock.models.simulate import simulate_theta
from freerock_bench.atlas.cells import (
    BLOCK,
    DAMPING,
    MARBLE,
    RATIO,
    RTOL,
    SAMPLING_HZ,
    STEP_S,
    STEPS_PER_SECOND,
    WINKLER_MARBLE,
    Cell,
    Judgement,
    Methods,
    Row,
    adaptive,
    attempt,
    fixed,
    from_a_wrong_angle,
    judge,
    problem_of,
    reference,
    row,
    rows,
    sampled,
)
from freerock_bench.methods.by_name import HOUSNER_METHODS, METHODS, freerock
from freerock_bench.methods.problem import Problem


def pipeline_of(problem: Problem, time: Floats) -> str:
    """What a fit does with the parameters of a problem."""
    k, damping = problem.parameters["k"], problem.parameters[DAMPING[problem.model]]
    of_stiffness, of_damping = PARAMETERS["k"].bounds, PARAMETERS[DAMPING[problem.model]].bounds
    assert of_stiffness and of_damping  # the rows of a foundation have bounds
    (softest, stiffest), (low, high) = of_stiffness, of_damping
    if not (softest <= k <= stiffest and low <= damping / k <= high):
        return "outside the bounds of the fit: never reached"
    block, theta0, rules = problem.block, problem.theta0, Rules(problem.debonding)
    _, outcome = simulate_theta(problem.model, block, problem.parameters, time, theta0=theta0, rules=rules)
    if outcome == "overturned":
        return "inside the bounds: the fit takes the block to lie at ±90°"
    return (
        "inside the bounds: fitted"
        if outcome in ("completed", "at_rest")
        else f"inside the bounds: {outcome}"
    )


def stiffness_map(size: str) -> list[Row]:
    """Stiffness k against damping ratio, both laws, both debonding rules, all methods; 2 s of motion."""
    span = 2.0 if size == "full" else 0.5
    time = sampled(span)
    ks = np.geomspace(1e3, 1e13, 21) if size == "full" else [1e5, 1e8]
    ratios = {"winkler": np.geomspace(1e-6, 1e1, 8), "hunt_crossley": np.geomspace(1e-3, 1e5, 9)}
    if size == "small":
        ratios = {model: np.array([ratio]) for model, ratio in RATIO.items()}
    made = []
    for model in ratios:
        quantity = f"{DAMPING[model]}/k [{PARAMETERS[DAMPING[model]].ratio_unit}]"
        for debonding in DEBONDING if size == "full" else [DEBONDING[model == "winkler"]]:
            for k in ks:
                for ratio in ratios[model]:
                    problem = problem_of(model, k, ratio, debonding)
                    pipeline = pipeline_of(problem, time)
                    cell = Cell("stiffness", problem, ("k [N/m²]", k), (quantity, ratio), pipeline)
                    methods = adaptive(size, span) | fixed(STEP_S, span)
                    made += rows(cell, methods, time, reference(problem, time, size))
    return made


def step_map(size: str) -> list[Row]:
    """Step of the fixed-step methods against stiffness, at the damping ratio of Table 2; 1 s of motion."""
    span = 1.0 if size == "full" else 0.5
    time = sampled(span)
    steps = np.geomspace(1e-5, 1e-2, 10) if size == "full" else [1e-4, 1e-3]
    made = []
    for model, ratio in RATIO.items():
        for k in np.geomspace(1e5, 1e12, 15) if size == "full" else [1e5, 1e9]:
            problem = problem_of(model, k, ratio)
            true = reference(problem, time, size)
            for step in steps:
                methods = {
                    name: (solve, step, limit * 10) for name, (solve, _, limit) in fixed(step, span).items()
                }
                pipeline = "not used: steps adapt"
                cell = Cell("step", problem, ("step [s]", step), ("k [N/m²]", k), pipeline)
                made += rows(cell, methods, time, true)
    return made


def release_map(size: str) -> list[Row]:
    """Release angle over the critical one against slenderness h/b; 2 s of motion.

    The block is as wide and as dense as configuration 2. Hunt-Crossley on marble, and Housner's block
    with its own restitution, exact and linearised. "θ₀ + 0.01°" is the exact motion from a release angle
    that is wrong by a laser's error.
    """
    span = 2.0 if size == "full" else 0.5
    shares = [0.01, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 0.9999, 1.01, 1.2]
    made = []
    for slenderness in [0.7, 1, 1.5, 2, 3, 4, 6, 8, 12] if size == "full" else [2]:
        height = BLOCK.width_m * slenderness
        block = Block(height, BLOCK.width_m, BLOCK.mass_kg * height / BLOCK.height_m)
        for share in shares if size == "full" else [0.5, 1.01]:
            made += _released(size, span, block, share, slenderness)
    return made


def _released(size: str, span: float, block: Block, share: float, slenderness: float) -> list[Row]:
    """A cell of the map of release angles, for Hunt-Crossley's law and for Housner's."""
    time, theta0 = sampled(span), share * block.theta_cr
    x, y = ("θ₀/θ_cr", share), ("h/b", slenderness)
    pipeline = "refused: held beyond θ_cr" if share > 1 else "fitted, θ₀ within 6 of its standard errors"
    near: Methods = {"θ₀ + 0.01°": (from_a_wrong_angle, RTOL / 100, STEPS_PER_SECOND * span)}
    problem = Problem("hunt_crossley", block, MARBLE, theta0)
    methods = adaptive(size, span) | dict(near)
    made = rows(Cell("release", problem, x, y, pipeline), methods, time, reference(problem, time, size))
    problem = Problem("housner", block, {"r": block.restitution_housner}, theta0)
    exact = attempt(freerock, problem, time, 1e-8, math.inf)
    methods = {"freerock": (freerock, 1e-8, math.inf)}
    if isinstance(exact, FreerockError):
        return made + rows(Cell("release", problem, x, y, pipeline), methods, time, None)
    events = "SciPy DOP853, events"
    methods[events] = (HOUSNER_METHODS[events], 1e-9, 20_000 * span)
    if share < 1:
        methods["linearised"] = (HOUSNER_METHODS["linearised"], 0.0, 2e6)
    return made + rows(Cell("release", problem, x, y, pipeline), methods | dict(near), time, exact)
