"""Where to start: the error over a grid of the model's parameters, on the first swings."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from scipy.optimize import minimize_scalar

from freerock.arrays import Floats
from freerock.identification.problem import Problem, Samples, fitted
from freerock.identification.swings import R_GRID, first_impact_s, moving_s, rocking_for, width_range
from freerock.models.laws import MODELS, PARAMETERS, alike, law_of

SCAN_SAMPLES = 250  # per run
SWING_SAMPLES = 1000  # among which the first impact is sought
RTOL = 1e-4
STARTS = 3
LIVELY = {"c": 1.5e-3, "lambda": 6.0}  # ratio to k [s, s/m], below which motions rattle and grids are coarse
LOWEST = 20.0  # that over the lowest damping of the finer grid
FINER = (90, 8)  # of k, and of the damping
MANY_STARTS = 16
R_STEP = 7  # of the grid of r, where the width is sought beside it
WIDTH_CELL = 1e-3  # of the full width


def scan(problem: Problem, horizon_s: float) -> list[list[float]]:
    """Starts of the model's fitted numbers: lowest local minima of the error over the model's grid.

    Housner's r: the lowest minimum inside the range. At its lower end the error may fall further, as the
    block that stops early is out of step for less time. A law with cases starts from the minima of these,
    with a trace of the damping that each lacks.

    Parameters
    ----------
    problem : Problem
        Of a single run.
    horizon_s : float
        End of the samples that count, but for Housner's r [s].
    """
    law = law_of(problem.model)
    if not law.is_foundation:
        return _scan_r_and_width(problem, horizon_s) if "width" in problem.common else [[_scan_r(problem)]]
    if law.cases:
        traces = {name: fitted(name, PARAMETERS[name].trace) for name in law.dampings}
        return [
            [(traces | dict(zip(MODELS[case], found, strict=True)))[name] for name in law.parameters]
            for case in law.cases
            for found in scan(replace(problem, model=alike(problem.model, case)), horizon_s)[:2]
        ]
    samples = problem.samples(horizon_s, SCAN_SAMPLES)
    coarse = replace(problem, rtol=RTOL)
    grids = [_grid(problem, name) for name in law.parameters]
    middle = [fitted(name, grid[len(grid) // 2]) for name, grid in zip(law.parameters, grids, strict=True)]
    grids[0] = np.sort(np.append(grids[0], _first_swing_k(coarse, horizon_s, middle[1:])))
    beside = {name: each.value for name, each in problem.given.items() if each.value is not None}
    if {*law.dampings} & {*beside}:
        grids[1] = np.append(grids[1], np.nan)  # stands for the value that is given
    points = [
        [
            fitted(name, value if np.isfinite(value) else beside[name] / point[0])
            for name, value in zip(law.parameters, point, strict=True)
        ]
        for point in product(*grids)
    ]
    return _lowest(coarse, points, [len(grid) for grid in grids], samples)


def _grid(problem: Problem, name: str) -> Floats:
    """Values of a parameter to start from: of the stiffness within what is given, and its value; of a damping
    ratios to it."""
    low, high, n = PARAMETERS[name].grid
    if name != "k" or name not in problem.given:
        return np.geomspace(low, high, n)
    least, most = np.exp(problem.bounds()[0])
    low, high = (max(low, least), min(high, most)) if max(low, least) < min(high, most) else (least, most)
    value = problem.given[name].value
    return np.sort(np.append(np.geomspace(low, high, n), [] if value is None else value))


def is_lively(problem: Problem, x: Floats) -> bool:
    """Whether a fitted damping is so low that the grid of the scan may have missed the minimum."""
    law = law_of(problem.model)
    if not law.is_foundation or law.cases:
        return False
    (name,) = law.dampings
    ratio = x[1] if problem.is_ratio[1] else x[1] - x[0]
    return bool(ratio < fitted(name, LIVELY[name]))


def finer_scan(problem: Problem, horizon_s: float) -> list[list[float]]:
    """Starts of a law with one damping from a finer grid of low ones.

    A block that is hardly damped rattles, and the error has many narrow minima.

    Parameters
    ----------
    problem : Problem
        Of a single run.
    horizon_s : float
        End of the samples that count [s].
    """
    stiffness, damping = law_of(problem.model).parameters
    highest = LIVELY[damping]
    grids = (
        np.geomspace(*PARAMETERS[stiffness].grid[:2], FINER[0]),
        np.geomspace(highest / LOWEST, highest, FINER[1]),
    )
    points = [[fitted(stiffness, k), fitted(damping, ratio)] for k, ratio in product(*grids)]
    samples = problem.samples(horizon_s, SCAN_SAMPLES)
    return _lowest(replace(problem, rtol=RTOL), points, FINER, samples, MANY_STARTS)


def _lowest(
    problem: Problem,
    points: Sequence[list[float]],
    shape: Sequence[int],
    samples: Samples,
    most: int = STARTS,
) -> list[list[float]]:
    """Lowest local minima of the error on a grid of so many points each way."""
    residuals = (problem.residual(problem.start(point), samples) for point in points)
    errors = np.array([left @ left / len(left) for left in residuals])
    cells = errors.reshape(shape)
    beside = np.lib.stride_tricks.sliding_window_view(np.pad(cells, 1, mode="edge"), (3,) * cells.ndim)
    minima = np.flatnonzero(cells == beside.min(axis=tuple(range(cells.ndim, 2 * cells.ndim))))
    return [points[i] for i in sorted(minima.tolist(), key=lambda i: errors[i])[:most]]


def _scan_r_and_width(problem: Problem, horizon_s: float) -> list[list[float]]:
    """Restitution and contact width of a rigid block on the first swings: until the first impact the motion
    is that of the width alone, the swings after it give r by their height. On the whole run the error has
    false minima in both."""
    grid = R_GRID[problem.r_low <= R_GRID][::R_STEP].tolist()
    block, motion = problem.blocks[0], problem.motions[0]
    fall = problem.samples(max(first_impact_s(motion), 2 * motion.fit_start_s), SCAN_SAMPLES)

    def error(width: float) -> float:
        return float(np.mean(problem.residual(problem.start([grid[0], width]), fall) ** 2))

    width = minimize_scalar(error, bounds=width_range(block, motion), options={"xatol": WIDTH_CELL}).x
    points = [[r, float(width)] for r in grid]
    return _lowest(problem, points, [len(points)], problem.samples(horizon_s, SCAN_SAMPLES))


def _first_swing_k(problem: Problem, horizon_s: float, others: Sequence[float]) -> float:
    """Stiffness that puts the first impact where it was measured; near overturning the grid is too coarse.

    `others` are the fitted numbers of the law's further parameters.
    """
    motion = problem.motions[0]
    time_s = np.linspace(0.0, horizon_s, SWING_SAMPLES)

    def first_impact(theta: Floats) -> int:
        crossed = np.flatnonzero(theta * motion.theta0 < 0)
        return int(crossed[0]) if len(crossed) else len(theta)

    measured = first_impact(np.interp(time_s, motion.time_s, np.nan_to_num(motion.theta, nan=motion.theta0)))
    low, high, _ = PARAMETERS["k"].grid
    while high > 1.001 * low:
        k = np.sqrt(low * high)
        theta = problem.motion(problem.start([np.log(k), *others]), 0, time_s)
        if first_impact(theta) > measured:
            low = k
        else:
            high = k
    return float(high)


def _scan_r(problem: Problem) -> float:
    """Restitution of the lowest inner minimum, among those that let it rock about as long as it did."""
    motion, high = problem.motions[0], R_GRID[0]
    samples = problem.samples(np.inf, SCAN_SAMPLES)
    moving = moving_s(motion)
    if moving < 0.95 * motion.time_s[-1]:
        high = rocking_for(problem.blocks[0], motion, 4 * moving)
    if "r" in problem.given:
        low, high = problem.bounds()[0]
        value = problem.given["r"].value
        grid = np.append(np.linspace(high, low, len(R_GRID)), [] if value is None else value)
        grid = np.sort(grid)[::-1]
    else:
        grid = R_GRID[(R_GRID >= problem.r_low) & (R_GRID <= high)]  # noqa: SIM300
    residuals = (problem.residual(problem.start([r]), samples) for r in grid)
    errors = np.array([left @ left / len(left) for left in residuals])
    inside = np.flatnonzero((errors[1:-1] <= errors[:-2]) & (errors[1:-1] <= errors[2:])) + 1
    return float(grid[inside[np.argmin(errors[inside])] if len(inside) else np.argmin(errors)])
