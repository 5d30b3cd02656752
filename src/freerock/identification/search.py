"""From starts to the whole run: least squares over growing horizons; the best end wins."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.problem import Problem
from freerock.identification.resolution import Resolution, find_resolution
from freerock.identification.scan import scan
from freerock.models.laws import law_of
from freerock.runs.motion import Motion

GROWTH_SAMPLES = 1000  # per run, before the last fit to all of them
PROMISING = 5.0  # candidates whose mean square error is within this factor of the best one are followed on


def search(problem: Problem, start: Sequence[float] | None) -> tuple[Problem, Solution, Resolution]:
    """Best end of the candidates over growing horizons, at the tolerance and sampling the noise asks for.

    Parameters
    ----------
    problem : Problem
    start : sequence of float or None
        The model's parameters to start from [SI]; None scans for them on the first run.

    Returns
    -------
    Problem
        With the tolerance of the integrator that was found.
    Solution
    Resolution
    """
    horizons = growing_horizons(problem.motions[0])
    if start is None:
        starts = scan(problem.alone(), horizons[0])
    else:
        starts, horizons = [problem.fitted(start)], horizons[-2:]
    if not law_of(problem.model).is_foundation:
        horizons = horizons[-1:]  # already scanned on the whole run
    tracks = [_follow(problem, problem.start(values), horizons[:1]) for values in starts]
    promising = PROMISING * min(error for error, _ in tracks)
    tracks = [_follow(problem, x, horizons[1:], error) for error, x in tracks if error <= promising]
    x = min(tracks, key=lambda track: track[0])[1]
    resolution = find_resolution(problem, x)
    problem = replace(problem, rtol=resolution.rtol)
    return problem, least_squares(problem, x, problem.samples(m=resolution.m)), resolution


def growing_horizons(motion: Motion) -> list[float]:
    """Growing spans [s]: the first two swings, then doubled up to the whole run."""
    counts = np.isfinite(motion.theta)
    theta, time_s = motion.theta[counts], motion.time_s[counts]
    crossings = time_s[1:][np.signbit(theta[1:]) != np.signbit(theta[:-1])]
    first = crossings[0] if len(crossings) else time_s[-1] / 8
    spans = [max(3.0 * first, motion.fit_start_s + first)]
    while spans[-1] < time_s[-1]:
        spans.append(2 * spans[-1])
    return spans


def _follow(
    problem: Problem, x: Floats, horizons: Sequence[float], error: float = np.inf
) -> tuple[float, Floats]:
    """Mean square error [rad²] and fitted numbers after least squares over each horizon in turn."""
    for horizon in horizons:
        solution = least_squares(problem, x, problem.samples(horizon, GROWTH_SAMPLES), ftol=1e-3)
        x, error = solution.x, solution.mean_square
    return error, x
