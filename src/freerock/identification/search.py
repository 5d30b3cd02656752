"""From starts to the whole run: least squares over growing horizons; the best end wins."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.noise import least_mean_square
from freerock.identification.problem import FINE, Problem, Samples
from freerock.identification.pursuit import (
    AGAIN,
    BEYOND,
    CREEP,
    FINEST,
    are_one,
    multiplies_errors,
    pursue,
    resolved,
    settle,
)
from freerock.identification.resolution import Resolution, find_resolution
from freerock.identification.scan import finer_scan, is_lively, scan
from freerock.identification.swings import R_GRID, first_impact_s
from freerock.models.laws import PARAMETERS, law_of, parameter_of
from freerock.runs.motion import Motion

GROWTH_SAMPLES = 1000  # per run, before the last fit to all of them
PROMISING = 5.0  # starts whose mean square error is within this factor of the best one are followed on
SAME = 3e-3  # of the first fitted number, in which two ends of a horizon are one
ALIKE = 1.1  # times the mean square, likewise
POOR = 1.1  # times the noise: a start that ends above it may be in a false minimum
LEFT = 1 / 4.0  # of the mean square: of twice the noise a hardly damped block may have another minimum
APART = "two searches end apart"
TOLD = (APART, BEYOND, CREEP)
HEAD, SLOWLY, FOLLOWED = 0.4, 1.4, 6  # of low dampings: share of the first horizon, growth, ends kept


def search(problem: Problem, start: Mapping[str, float] | None) -> tuple[Problem, Solution, Resolution]:
    """Best end of the starts over growing horizons, at the tolerance and sampling the noise asks for.

    Parameters
    ----------
    problem : Problem
    start : mapping of str to float, or None
        The model's parameters to start from, and what is known of the rest [SI]. None scans for them on the
        first run; so does a single run where the end of that start is poor.

    Returns
    -------
    Problem
        With the tolerance of the integrator that was found.
    Solution
    Resolution
    """
    near = approach(problem, start)
    x = near.x
    if _is_single(problem) and is_lively(problem, x) and not _is_left(problem, near):
        problem = resolved(replace(problem, rtol=FINE), x, problem.samples())
    resolution = find_resolution(problem, x)
    exact = resolution.rtol >= min(problem.rtol, problem.fine)
    problem, jacobian = replace(problem, rtol=resolution.rtol), resolution.jacobian if exact else None
    if problem.directions is None:
        samples = problem.samples(m=resolution.m)
        end = least_squares(problem, x, samples, jacobian=jacobian, theta=resolution.theta)
    else:
        problem, end = settle(problem, x)
    if near.message in TOLD and (problem.directions is not None or _is_left(problem, end)):
        end = replace(end, success=False, message=near.message)
    return problem, end, resolution


def stopped(problem: Problem, end: Solution) -> tuple[Problem, Solution] | None:
    """The minimum of the objective over all r, where that is of a rigid block that stops rocking too soon.

    A search keeps r where the block rocks for at least half the measured time: it then keeps the phase. Where
    more than noise is left there, a block that stops early may be less out of step.

    Returns
    -------
    (Problem, Solution) or None
        None of a foundation's law, of several runs, where r is given, and where the end that keeps the phase
        is the nearest.
    """
    rigid = _is_single(problem) and not law_of(problem.model).is_foundation
    if not rigid or problem.given or problem.n_impacts > 1 or not is_poor(problem, end.mean_square):
        return None
    whole, few = replace(problem, r_low=0.0), problem.samples(most=GROWTH_SAMPLES)

    def left(x: Floats, samples: Samples) -> float:
        return float(np.sum(whole.residual(x, samples) ** 2))

    starts = [np.append(r, end.x[1:]) for r in [0.0, *R_GRID[problem.r_low > R_GRID]]]
    every = problem.samples()
    with np.errstate(divide="ignore", invalid="ignore"):  # at r = 0 nothing depends on r
        found = least_squares(whole, min(starts, key=lambda x: left(x, few)), every)
    nearest = found.x if found.x[0] > R_GRID[-1] else np.append(0.0, found.x[1:])  # below: no bounce to see
    if nearest[0] >= problem.r_low or left(nearest, every) >= left(end.x, every):
        return None
    return whole, replace(found, x=nearest, success=False)


def approach(problem: Problem, start: Mapping[str, float] | None = None, beyond: float = np.inf) -> Solution:
    """The best from the samples that growing horizons take.

    A law that holds others follows from the best of these; 40 of 40 random truths of it were found so, also
    where the others left thousands of times the noise.

    Parameters
    ----------
    problem : Problem
    start : mapping of str to float, or None
        As in `search`.
    beyond : float
        Mean square residual [rad²] above which a horizon is not grown: no more is left at its end than a
        longer one would leave.
    """
    problem, horizons = problem.rough(), growing_horizons(problem.motions[0])
    ends, begun = list[Solution](), list[Solution]()
    if start is not None:
        ends = [follow(problem, _r_first(problem, problem.start_at(start)), horizons[-2:], beyond)]
    in_full = _is_single(problem) and np.isinf(beyond)
    if not ends or (in_full and is_poor(problem, ends[0].mean_square)):
        begun, followed = _scanned(problem, horizons, beyond)
        ends += followed
    best = min(ends, key=lambda end: end.mean_square)
    if not in_full:
        return best
    if is_lively(problem, best.x):
        if is_poor(problem, best.mean_square) or multiplies_errors(problem, best.x):
            return _looked_at_finely(problem, horizons, best)
    elif begun and is_lively(problem, begun[0].x) and _is_left(problem, best):
        finer = _looked_at_finely(problem, horizons, best)
        return best if _is_left(problem, finer) and finer.message not in TOLD else finer
    return best


def _looked_at_finely(problem: Problem, horizons: Sequence[float], best: Solution) -> Solution:
    """The best of some end and those of a finer scan of low dampings."""
    problem = replace(problem, fine=FINE, stride=1.0)
    ends, told = _scanned_finely(problem, horizons, best)
    ends = [as_exact(problem, end) for end in (best, *ends)]
    found = _reached_twice(problem, ends)
    if found.message == APART:
        found = _reached_twice(problem, [_settled(problem, end) for end in ends])
    return replace(found, success=False, message=told) if told and _is_left(problem, found) else found


def _reached_twice(problem: Problem, ends: Sequence[Solution]) -> Solution:
    """The best of some ends; it says so where the motion multiplies errors and no other has come to it."""
    best, *others = sorted(ends, key=lambda end: end.mean_square)
    if not multiplies_errors(problem, best.x) or any(are_one(problem, best.x, end.x) for end in others):
        return best
    return replace(best, success=False, message=APART)


def as_exact(problem: Problem, end: Solution) -> Solution:
    """An end, with what the motion itself leaves there: at a looser tolerance one that multiplies errors is
    another motion, whose minimum lies elsewhere and may be the lower one."""
    residual = replace(problem, rtol=FINEST).residual(end.x, problem.samples(most=GROWTH_SAMPLES))
    return replace(end, mean_square=float(np.mean(residual**2)))


def _settled(problem: Problem, end: Solution) -> Solution:
    """An end of at most twice the noise, taken to its minimum by shorter steps."""
    if _is_left(problem, end):
        return end
    finer = resolved(replace(problem, rtol=FINE), end.x, problem.samples())
    return as_exact(problem, settle(finer, end.x)[1])


def _is_single(problem: Problem) -> bool:
    """Whether it is one run under a law without cases."""
    return len(problem.motions) == 1 and not law_of(problem.model).cases


def is_poor(problem: Problem, mean_square: float) -> bool:
    """Whether the mean square [rad²] of a fit of a single run is more than its noise."""
    return mean_square > POOR**2 * least_mean_square(problem.motions[0])


def _is_left(problem: Problem, end: Solution) -> bool:
    """Whether an end leaves more than twice the noise."""
    return is_poor(problem, LEFT * end.mean_square)


def _scanned_finely(
    problem: Problem, horizons: Sequence[float], best: Solution
) -> tuple[list[Solution], str]:
    """Ends of a finer scan of low dampings, and why a start that followed the motion could not do so to the
    last horizon, where none could.

    That of the first start that can be pursued to the last horizon, and where it isn't the best one so far,
    of another pursuit of it that gets there; of all starts over horizons that grow more slowly, where none
    follows the motion and the best one so far is hardly damped, too.
    """
    spans, told = [HEAD * horizons[0]], ""
    while spans[-1] < horizons[-1]:
        spans.append(SLOWLY * spans[-1])
    ends = [
        follow(problem, problem.start(values), spans[:1]) for values in finer_scan(problem.alone(), spans[0])
    ]
    near = _followed(ends)
    for end in near:
        pursued = pursue(problem, end.x, spans[0])
        if pursued and pursued.message in TOLD:
            told = pursued.message
        elif pursued:
            reaches = () if are_one(problem, pursued.x, best.x) else AGAIN
            others = (pursue(problem, end.x, spans[0], reach) for reach in reaches)
            again = next((other for other in others if other and other.message not in TOLD), None)
            return ([pursued, again] if again else [pursued]), ""
    if not is_lively(problem, best.x) or (told and _is_left(problem, best)):
        return [], told
    for span in spans[1:]:
        near = _followed([follow(problem, end.x, [span]) for end in near])
    return near, told


def _followed(ends: Sequence[Solution]) -> list[Solution]:
    """Ends of starts of a finer scan that are followed on, the best first."""
    ends = _different(sorted(ends, key=lambda end: end.mean_square))
    return [end for end in ends if end.mean_square <= PROMISING**2 * ends[0].mean_square][:FOLLOWED]


def _scanned(
    problem: Problem, horizons: Sequence[float], beyond: float
) -> tuple[list[Solution], list[Solution]]:
    """Ends of the scan's starts on the first horizon, the best first, and of those that promise something,
    each followed on as long as it does so."""
    starts = scan(problem.alone(), horizons[0])
    if not law_of(problem.model).is_foundation and "width" not in problem.common:
        horizons = horizons[-1:]  # already scanned on the whole run
    ends = [follow(problem, _r_first(problem, problem.start(values)), horizons[:1]) for values in starts]
    begun = ends = sorted(ends, key=lambda end: end.mean_square)
    for horizon in horizons[1:]:
        ends = _different(sorted(ends, key=lambda end: end.mean_square))
        near = [end for end in ends if end.mean_square <= min(PROMISING * ends[0].mean_square, beyond)]
        if not near:
            break
        ends = [follow(problem, end.x, [horizon], beyond) for end in near]
    return begun, ends


def _different(ends: Sequence[Solution]) -> list[Solution]:
    """Ends, the best first, without those that have come to the same minimum as an earlier one.

    The first number, k or r, tells minima apart; others may be hardly determined as yet.
    """
    found: list[Solution] = []
    for end in ends:
        if not any(
            abs(end.x[0] - other.x[0]) < SAME and end.mean_square < ALIKE * other.mean_square
            for other in found
        ):
            found.append(end)
    return found


def _r_first(problem: Problem, x: Floats) -> Floats:
    """A start with Housner's r found for the release as measured: from elsewhere least squares creep."""
    if (
        law_of(problem.model).is_foundation
        or "width" in problem.common
        or len(x) == 1
        or not problem.varied[0]
    ):
        return x
    alone = replace(problem, settings=replace(problem.settings, free=()), n_impacts=0)
    r = least_squares(alone, x[:1], alone.samples(most=GROWTH_SAMPLES)).x
    return np.where([parameter_of(name) is PARAMETERS["r"] for name in problem.names], r, x)


def growing_horizons(motion: Motion) -> list[float]:
    """Growing spans [s]: the first two swings, then doubled up to the whole run."""
    first, last = first_impact_s(motion), motion.time_s[np.isfinite(motion.theta)][-1]
    spans = [max(3.0 * first, motion.fit_start_s + first)]
    while spans[-1] < last:
        spans.append(2 * spans[-1])
    return spans


def follow(problem: Problem, x: Floats, horizons: Sequence[float], beyond: float = np.inf) -> Solution:
    """Where least squares over each horizon in turn end, at some samples of each; see `approach`."""
    evaluations = 0
    for horizon in horizons:
        end = least_squares(problem, x, problem.samples(horizon, GROWTH_SAMPLES), ftol=1e-3)
        x, evaluations = end.x, evaluations + end.evaluations
        if end.mean_square > beyond:
            break
    return replace(end, evaluations=evaluations)
