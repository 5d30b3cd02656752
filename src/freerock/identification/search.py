"""From starts to the whole run: least squares over growing horizons; the best end wins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.against_noise import least_mean_square
from freerock.identification.diverging_motions import (
    PURSUIT,
    are_one,
    multiplies_errors,
    pursue,
    resolved,
    settle,
)
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.problem import RTOL_DERIVATIVES, Problem, Samples
from freerock.identification.start import R_GRID, finer_scan, first_impact_s, is_lively, scan
from freerock.models.free_parameters import PARAMETERS, parameter_of
from freerock.models.laws import law_of
from freerock.runs.motion import Motion


@dataclass(frozen=True)
class SearchSettings:
    """How starts are followed to the whole run; by judgement.

    Parameters
    ----------
    samples : int
        Per run, before the last fit to all of them.
    ftol : float
        Relative change of the sum of squares at which a quick fit ends.
    promising : float
        Times the best mean square error, up to which starts are followed on.
    same, alike : float
        Relative difference of the first fitted number, and ratio of the mean squares, up to which two ends of
        a horizon are one.
    poor : float
        Times the noise: a start that ends above it may be in a false minimum.
    left : float
        Times the noise: a hardly damped block that leaves more may have another minimum.
    head, slowly, followed : float, float, int
        Of low dampings: share of the first horizon, growth of the horizons, ends that are kept.
    """

    samples: int = 1000
    ftol: float = 1e-3
    promising: float = 5.0
    same: float = 3e-3
    alike: float = 1.1
    poor: float = 1.1
    left: float = 2.0
    head: float = 0.4
    slowly: float = 1.4
    followed: int = 6


SEARCH = SearchSettings()


@dataclass(frozen=True)
class Resolution:
    """What the last fit of a run takes.

    Parameters
    ----------
    rtol : float
        Tolerance of the integrator.
    m : int
        Samples averaged into one.
    shift : float
        Largest shift of a parameter by the integrator's error, as a share of its standard error.
    jacobian : ndarray, shape (n_samples, n_parameters)
        Derivatives where the last fit starts, of samples that are not averaged.
    theta : ndarray, shape (n_samples,)
        `Problem.curve` there, at this tolerance [rad].
    """

    rtol: float
    m: int
    shift: float
    jacobian: Floats
    theta: Floats


def search(problem: Problem, start: Mapping[str, float] | None) -> tuple[Problem, Solution, Resolution]:
    """Best end of the starts over growing horizons, at the tolerance and sampling the noise requires.

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
        problem = resolved(replace(problem, rtol=RTOL_DERIVATIVES), x, problem.samples())
    resolution = find_resolution(problem, x)
    exact = resolution.rtol >= min(problem.rtol, problem.fine)
    problem, jacobian = replace(problem, rtol=resolution.rtol), resolution.jacobian if exact else None
    if problem.directions is None:
        samples = problem.samples(m=resolution.m)
        end = least_squares(problem, x, samples, jacobian=jacobian, theta=resolution.theta)
    else:
        problem, end = settle(problem, x)
    if near.lost and (problem.directions is not None or _is_left(problem, end)):
        end = end.losing(near.message)
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
    rigid = _is_single(problem) and "r" in problem.common
    if not rigid or problem.given or not is_poor(problem, end.mean_square):
        return None
    whole, few = replace(problem, r_low=0.0), problem.samples(most=SEARCH.samples)

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
        return best if _is_left(problem, finer) and not finer.lost else finer
    return best


def _looked_at_finely(problem: Problem, horizons: Sequence[float], best: Solution) -> Solution:
    """The best of some end and those of a finer scan of low dampings."""
    problem = replace(problem, fine=RTOL_DERIVATIVES, stride=1.0)
    ends, told = _scanned_finely(problem, horizons, best)
    ends = [as_exact(problem, end) for end in (best, *ends)]
    found = _reached_twice(problem, ends)
    if found.lost:
        found = _reached_twice(problem, [_settled(problem, end) for end in ends])
    return found.losing(told) if told and _is_left(problem, found) else found


def _reached_twice(problem: Problem, ends: Sequence[Solution]) -> Solution:
    """The best of some ends; a message where the motion multiplies errors and no other has come to it."""
    best, *others = sorted(ends, key=lambda end: end.mean_square)
    if not multiplies_errors(problem, best.x) or any(are_one(problem, best.x, end.x) for end in others):
        return best
    return best.losing("two searches end at different minima")


def as_exact(problem: Problem, end: Solution) -> Solution:
    """An end, with what the motion itself leaves there: at a looser tolerance one that multiplies errors is
    another motion, whose minimum lies elsewhere and may be the lower one."""
    residual = replace(problem, rtol=PURSUIT.finest).residual(end.x, problem.samples(most=SEARCH.samples))
    return replace(end, mean_square=float(np.mean(residual**2)))


def _settled(problem: Problem, end: Solution) -> Solution:
    """An end of at most twice the noise, taken to its minimum by shorter steps."""
    if _is_left(problem, end):
        return end
    finer = resolved(replace(problem, rtol=RTOL_DERIVATIVES), end.x, problem.samples())
    return as_exact(problem, settle(finer, end.x)[1])


def _is_single(problem: Problem) -> bool:
    """Whether it is one run under a law without cases."""
    return len(problem.motions) == 1 and not law_of(problem.model).cases


def is_poor(problem: Problem, mean_square: float) -> bool:
    """Whether the mean square [rad²] of a fit of a single run is more than its noise."""
    return mean_square > SEARCH.poor**2 * least_mean_square(problem.motions[0])


def _is_left(problem: Problem, end: Solution) -> bool:
    """Whether an end leaves more than twice the noise."""
    return is_poor(problem, end.mean_square / SEARCH.left**2)


def _scanned_finely(
    problem: Problem, horizons: Sequence[float], best: Solution
) -> tuple[list[Solution], str]:
    """Ends of a finer scan of low dampings, and why a start that followed the motion could not do so to the
    last horizon, where none could.

    That of the first start that can be pursued to the last horizon, and where it isn't the best one so far,
    of another pursuit of it that gets there; of all starts over horizons that grow more slowly, where none
    follows the motion and the best one so far is hardly damped, too.
    """
    spans, told = [SEARCH.head * horizons[0]], ""
    while spans[-1] < horizons[-1]:
        spans.append(SEARCH.slowly * spans[-1])
    ends = [
        follow(problem, problem.start(values), spans[:1]) for values in finer_scan(problem.alone(), spans[0])
    ]
    near = _followed(ends)
    for end in near:
        pursued = pursue(problem, end.x, spans[0])
        if pursued and pursued.lost:
            told = pursued.message
        elif pursued:
            reaches = () if are_one(problem, pursued.x, best.x) else PURSUIT.again
            others = (pursue(problem, end.x, spans[0], reach) for reach in reaches)
            again = next((other for other in others if other and not other.lost), None)
            return ([pursued, again] if again else [pursued]), ""
    if not is_lively(problem, best.x) or (told and _is_left(problem, best)):
        return [], told
    for span in spans[1:]:
        near = _followed([follow(problem, end.x, [span]) for end in near])
    return near, told


def _followed(ends: Sequence[Solution]) -> list[Solution]:
    """Ends of starts of a finer scan that are followed on, the best first."""
    ends = _different(sorted(ends, key=lambda end: end.mean_square))
    most = SEARCH.promising**2 * ends[0].mean_square
    return [end for end in ends if end.mean_square <= most][: SEARCH.followed]


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
        near = [end for end in ends if end.mean_square <= min(SEARCH.promising * ends[0].mean_square, beyond)]
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
            abs(end.x[0] - other.x[0]) < SEARCH.same and end.mean_square < SEARCH.alike * other.mean_square
            for other in found
        ):
            found.append(end)
    return found


def _r_first(problem: Problem, x: Floats) -> Floats:
    """A start with Housner's r found for the release as measured: from elsewhere least squares creep."""
    if "r" not in problem.common or "width" in problem.common or len(x) == 1 or not problem.varied[0]:
        return x
    alone = replace(problem, settings=replace(problem.settings, free=()))
    r = least_squares(alone, x[:1], alone.samples(most=SEARCH.samples)).x
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
        end = least_squares(problem, x, problem.samples(horizon, SEARCH.samples), ftol=SEARCH.ftol)
        x, evaluations = end.x, evaluations + end.evaluations
        if end.mean_square > beyond:
            break
    return replace(end, evaluations=evaluations)


def find_resolution(problem: Problem, x: Floats, finest: float = 1e-12, exact: float = 1e-15) -> Resolution:
    """Loosest tolerance and coarsest averaging that the standard errors allow.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers, near their best.
    finest, exact : float
        Least tolerance, and least one with which one is compared.
    """
    samples = problem.samples()
    theta = problem.curve(x, samples)
    noise = np.sqrt(np.mean((theta - samples.theta) ** 2))
    known = problem.exact_curve(x, samples)
    derivatives = problem.jacobian(x, samples, known=known)
    jacobian = derivatives / np.maximum(np.sqrt(np.mean(derivatives**2, axis=0)), 1e-300)
    inverse = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
    spread = np.sqrt(np.diag(inverse))
    m = _averaging(samples, jacobian, spread) if problem.directions is None else 1
    if not law_of(problem.model).is_foundation:
        return Resolution(problem.rtol, m, 0.0, derivatives, theta)
    rtol = problem.rtol
    while True:
        finer = max(rtol / 100, exact)
        closer = known[0] if finer == problem.exact_rtol else problem.curve(x, samples, finer)
        shifts = np.abs(inverse @ (jacobian.T @ (theta - closer)))[spread > 0] / (spread[spread > 0] * noise)
        shift = float(np.max(shifts, initial=0.0))
        if not shift > problem.settings.integrator_error or rtol <= finest:
            return Resolution(rtol, m, shift, derivatives, theta)
        rtol /= 10
        theta = problem.curve(x, samples, rtol)


def _averaging(
    samples: Samples, jacobian: Floats, spread: Floats, worth: float = 0.02, least: int = 20
) -> int:
    """How many samples may be averaged into one: a power of two.

    It may cost a share `worth` of a standard error; at `least` so many are kept per parameter.
    """
    m, pairs, means = 1, replace(samples, m=2), jacobian
    while 2 * m * least * jacobian.shape[1] < min(samples.lengths):
        means = pairs.averaged(means)
        wider = np.sqrt(np.diag(np.linalg.pinv(means.T @ means, hermitian=True)))
        if np.any(wider > (1 + worth) * spread):
            break
        m, pairs = 2 * m, replace(pairs, lengths=tuple(n // 2 for n in pairs.lengths))
    return m
