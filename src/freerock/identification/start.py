"""Start of a fit: estimates from the measured motion, and a scan over a grid on the first swings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.optimize import minimize_scalar

from freerock.arrays import Floats, Mask
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.problem import Problem, Samples, fitted
from freerock.identification.settings import freed
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS
from freerock.models.housner import housner_swings
from freerock.models.laws import MODELS, alike, law_of
from freerock.runs.beginning import TOP_STDERR, TOP_STDERR_S, Top, find_tops
from freerock.runs.motion import Motion


@dataclass(frozen=True)
class StartSettings:
    """Grids from which fits start, and what is read from the swings; by judgement.

    Parameters
    ----------
    samples : int
        Per run, of the error over a grid.
    of_swing : int
        Among which the first impact is sought.
    rtol : float
        Of the integrator.
    finer : (int, int)
        Values of k, and of the damping, of the finer grid of low dampings.
    lowest : float
        Highest over lowest damping of that grid.
    of_finer : int
        Starts that it gives.
    every_r : int
        Every how manieth r is tried where the width is sought beside it.
    width_cell : float
        Exactness of that width, as a share of the full one.
    stands : float
        Times the width at which the block overturns: the least width.
    least_peak : float
        Of the release angle: in the noise of lower swings any law hides.
    clear : float
        Standard deviations of the noise, likewise.
    heights : tuple of int
        From how many heights a curve of the first, second, third degree leaves one to tell a tilt. The
        degrees rise as do those of the restitutions (`runs.uneven_restitution`). Of 71 bases off level the
        fits that start from this tilt all found it within 0.002 degrees.
    """

    samples: int = 250
    of_swing: int = 1000
    rtol: float = 1e-4
    finer: tuple[int, int] = (90, 8)
    lowest: float = 20.0
    of_finer: int = 16
    every_r: int = 7
    width_cell: float = 1e-3
    stands: float = 1.002
    least_peak: float = 0.1
    clear: float = 50.0
    heights: tuple[int, ...] = (4, 6, 9)


START = StartSettings()
R_GRID = 1 - np.geomspace(*PARAMETERS["r"].grid)


def posed(model: str, blocks: Sequence[Block], motions: Sequence[Motion], settings: FitSettings) -> Problem:
    """The problem of fitting a model to runs.

    Raises
    ------
    FreerockError
        A run has no more valid samples than there are parameters.
    """
    free = freed(model, settings.free)
    settings = replace(settings, free=free)
    problem = Problem(
        model,
        tuple(blocks),
        tuple(motions),
        settings,
        r_low=_least_r(blocks[0], motions[0], "width" in settings.free) if "r" in MODELS[model] else 0.0,
    )
    if "tilt" in settings.free:
        low, high = PARAMETERS["tilt"].bounds
        tilt = tilt_of_swings(blocks[0], motions[0])
        problem = replace(problem, tilt=float(np.clip(tilt, 0.9 * low, 0.9 * high)))
    if min(problem.samples().lengths, default=0) <= len(problem.names):
        what = "fewer valid samples than parameters"
        raise FreerockError("fit", what, "exclude the run or widen it by an override")
    return problem


def _least_r(block: Block, motion: Motion, any_width: bool) -> float:
    """Least r with which the rigid block, or the narrowest that stands, rocks for half the measured time."""
    if any_width:
        block = replace(block, contact_width_m=block.width_m * width_range(block, motion)[0])
    return rocking_for(block, motion, moving_s(motion) / 2)


def scan(problem: Problem, horizon_s: float) -> list[list[float]]:
    """Starts of the model's fitted numbers: lowest local minima of the error over the model's grid.

    Housner's r: the lowest minimum inside the range. At its lower end the error may fall further, as the
    block that stops early is out of step for less time. A law with cases starts from the minima of these,
    with a trace of the number that each lacks.

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
        traces = {name: fitted(name, PARAMETERS[name].trace) for name in law.parameters[1:]}
        return [
            [(traces | dict(zip(MODELS[case], found, strict=True)))[name] for name in law.parameters]
            for case in law.cases
            for found in scan(replace(problem, model=alike(problem.model, case)), horizon_s)[:2]
        ]
    samples = problem.samples(horizon_s, START.samples)
    coarse = replace(problem, rtol=START.rtol)
    grids = [_grid(problem, name) for name in law.parameters]
    middle = [fitted(name, grid[len(grid) // 2]) for name, grid in zip(law.parameters, grids, strict=True)]
    grids[0] = np.sort(np.append(grids[0], _first_swing_k(coarse, horizon_s, middle[1:])))
    beside = {name: each.value for name, each in problem.given.items() if each.value is not None}
    if {*law.ratios} & {*beside}:
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
    (name,) = law.ratios
    i = law.parameters.index(name)
    ratio = x[i] if problem.is_ratio[i] else x[i] - x[0]
    return bool(ratio < fitted(name, PARAMETERS[name].lively))


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
    law = law_of(problem.model)
    (damping,), (stiffness, *_) = law.ratios, law.parameters
    highest = PARAMETERS[damping].lively
    grids = (
        np.geomspace(*PARAMETERS[stiffness].grid[:2], START.finer[0]),
        np.geomspace(highest / START.lowest, highest, START.finer[1]),
    )
    middle = {name: _grid(problem, name)[PARAMETERS[name].grid[2] // 2] for name in law.parameters}
    points = [
        [fitted(name, (middle | {stiffness: k, damping: ratio})[name]) for name in law.parameters]
        for k, ratio in product(*grids)
    ]
    samples = problem.samples(horizon_s, START.samples)
    return _lowest(replace(problem, rtol=START.rtol), points, START.finer, samples, START.of_finer)


def _lowest(
    problem: Problem,
    points: Sequence[list[float]],
    shape: Sequence[int],
    samples: Samples,
    most: int = 3,
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
    grid = R_GRID[problem.r_low <= R_GRID][:: START.every_r].tolist()
    block, motion = problem.blocks[0], problem.motions[0]
    fall = problem.samples(max(first_impact_s(motion), 2 * motion.fit_start_s), START.samples)

    def error(width: float) -> float:
        return float(np.mean(problem.residual(problem.start([grid[0], width]), fall) ** 2))

    width = minimize_scalar(error, bounds=width_range(block, motion), options={"xatol": START.width_cell}).x
    points = [[r, float(width)] for r in grid]
    return _lowest(problem, points, [len(points)], problem.samples(horizon_s, START.samples))


def _first_swing_k(problem: Problem, horizon_s: float, others: Sequence[float]) -> float:
    """Stiffness that puts the first impact where it was measured; near overturning the grid is too coarse.

    `others` are the fitted numbers of the law's further parameters.
    """
    motion = problem.motions[0]
    time_s = np.linspace(0.0, horizon_s, START.of_swing)

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
    samples = problem.samples(np.inf, START.samples)
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


def width_range(block: Block, motion: Motion) -> tuple[float, float]:
    """Least and largest contact width to start from, as shares of the full one; under less it overturns."""
    low, high, _ = PARAMETERS["width"].grid
    stands = block.height_m / block.width_m * np.tan(abs(motion.theta0))
    return max(low, START.stands * float(stands)), high


def rocking_for(block: Block, motion: Motion, time_s: float) -> float:
    """Least r of the grid with which the rigid block rocks for longer than a time."""
    few, many = 0, len(R_GRID) - 1  # the grid falls, and with it the time to rest
    while few < many:
        middle = (few + many + 1) // 2
        if housner_swings(block, R_GRID[middle], motion.theta0, until=time_s).rest_time > time_s:
            few = middle
        else:
            many = middle - 1
    return float(R_GRID[few])


def first_impact_s(motion: Motion) -> float:
    """First change of sign of θ [s]; an eighth of the run where there is none."""
    counts = np.isfinite(motion.theta)
    theta, time_s = motion.theta[counts], motion.time_s[counts]
    crossings = time_s[1:][np.signbit(theta[1:]) != np.signbit(theta[:-1])]
    return float(crossings[0] if len(crossings) else time_s[-1] / 8)


def moving_s(motion: Motion) -> float:
    """Last instant at which the block moves [s]; 0 where it never does."""
    moves = _moves(motion)
    return float(motion.time_s[moves][-1]) if moves.any() else 0.0


def _moves(motion: Motion) -> Mask:
    """Which samples stand out of the noise, and of the ringing of a base in full contact."""
    return np.asarray(np.abs(motion.theta) > max(10 * motion.sigma_theta, 1e-3 * abs(motion.theta0)))


def tops_of(motion: Motion) -> list[Top]:
    """The tops of the swings after the first, as long as they are high."""
    lowest = max(START.least_peak * abs(motion.theta0), START.clear * motion.sigma_theta)
    return find_tops(motion.time_s, motion.theta, motion.sigma_theta, lowest)


def from_top(motion: Motion, top: Top) -> Motion:
    """The rest of a run from a peak on."""
    later = motion.time_s >= top.time_s
    return replace(
        motion,
        time_s=motion.time_s[later] - top.time_s,
        theta=motion.theta[later],
        theta0=top.height,
        theta0_stderr=TOP_STDERR * abs(top.height),
        t0_stderr=TOP_STDERR_S,
        fit_start_s=0.0,
    )


def tilt_of_swings(block: Block, motion: Motion) -> float:
    """Tilt of the base to the right [rad], as the heights of the swings have it; 0 where they are too few.

    The energy of a rigid block at a top is m g (y - τ x), with y its rise and x its way to the right, both of
    the centre of mass turning about a corner. It falls evenly from swing to swing: its logarithm is a
    polynomial in the number of the swing, beside which τ x/y alternates.
    """
    heights = np.array([motion.theta0, *(top.height for top in tops_of(motion))])
    degree = sum(n <= heights.size for n in START.heights)
    rise = block.b * np.sin(np.abs(heights)) - 2 * block.h * np.sin(heights / 2) ** 2
    if not degree or rise.min() <= 0:
        return 0.0
    way = block.h * np.sin(heights) + 2 * block.b * np.sign(heights) * np.sin(heights / 2) ** 2
    number = np.arange(heights.size) - (heights.size - 1) / 2
    design = np.column_stack([way / rise, np.vander(number, degree + 1)])
    return float(np.linalg.lstsq(design, np.log(rise), rcond=None)[0][0])
