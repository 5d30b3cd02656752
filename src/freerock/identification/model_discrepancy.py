"""Evidence against a fit: halves and parts of its run that disagree, a missing damping, failures.

How far off the numbers of a law may be that does not explain its run follows from how they move over the run.
The swings of a run are cut into parts of as many. The fit of a part is one step of Gauss and Newton from that
of the whole, with its derivatives, so that nothing is simulated: release angle and instant are free in every
part and take up where the block comes from. Under the right law the parts agree to within the noise. Under
another one they differ by about as much as the whole is off: the study `kinds` shows how often the intervals
of runs that nothing explains hold the truth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.special import stdtrit

from freerock.arrays import Floats
from freerock.identification.diverging_motions import is_beyond
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.intervals import SINGULAR, Uncertainty
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.likelihood import Likelihood, Whitened
from freerock.identification.problem import Problem
from freerock.identification.search import SEARCH, is_poor
from freerock.identification.significance_levels import NORMAL_95
from freerock.identification.start import is_lively
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import extended_by, law_of

PARTS_OF_RUN = 6  # of a run, if it has as many swings; by judgement


@dataclass(frozen=True)
class Part:
    """Some swings of a run, and the numbers that fit them.

    Parameters
    ----------
    start_s, end_s : float
        Since the release [s].
    value, stderr : ndarray, shape (n_parameters,)
        Fitted to the part, and the standard error by white noise alone [SI]; stderr is NaN where the part
        does not separate the numbers, 0 where it does not depend on one.
    covariance : ndarray, shape (n_parameters, n_parameters)
        By white noise alone [SI]; NaN likewise.
    """

    start_s: float
    end_s: float
    value: Floats
    stderr: Floats
    covariance: Floats

    def following(self, value: Floats, gradient: Floats) -> "Part":
        """What the part says of numbers that depend on the fitted ones, to first order.

        Parameters
        ----------
        value : ndarray, shape (n_parameters,)
            Of the whole [SI].
        gradient : ndarray, shape (n_numbers, n_parameters)
            Derivatives of the numbers there.

        Returns
        -------
        Part
            Its value and errors are of the numbers, less what they are of the whole.
        """
        covariance = gradient @ self.covariance @ gradient.T
        stderr = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return replace(self, value=gradient @ (self.value - value), stderr=stderr, covariance=covariance)


def fitted_parts(problem: Problem, x: Floats, residual: Floats, jacobian: Floats) -> list[Part]:
    """The fits of the parts of all runs; what a single impact has of its own stays as it is.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    residual, jacobian : ndarray, shapes (n_samples,) and (n_samples, n_parameters)
        There, of all samples.
    """
    samples, gradient, value = problem.samples(), problem.gradient(x), problem.physical(x)
    low, high = np.array(problem.bounds()).T
    span = (high - low) * np.abs(np.diag(gradient))
    # a logarithm by one: a straight line leads no farther; others by their span
    farthest = np.where(problem.is_logarithm, np.abs(value), span)
    of_all = np.array([not name.startswith("r_") for name in problem.names])
    found = []
    for run, motion in zip(samples.runs, problem.motions, strict=True):
        sigma, time_s = motion.sigma_theta, samples.time_s[run]
        for part in parts_of(samples.theta[run] + residual[run], sigma):
            step, covariance = _step(residual[run][part], jacobian[run][part] * of_all)
            moved = value + np.clip(gradient @ step, -farthest, farthest)
            covariance = gradient @ covariance @ gradient.T
            stderr = sigma * np.sqrt(np.diag(covariance))
            first, last = time_s[part][[0, -1]].tolist()
            found.append(Part(first, last, moved, stderr, sigma**2 * covariance))
    return found


def model_discrepancy(value: Floats, parts: Sequence[Part]) -> Floats:
    """Standard uncertainty of the fitted numbers where the law does not explain the run [SI].

    The root of the mean square of the parts' distances from the whole, times the ratio of Student's t, of one
    degree of freedom less than there are parts, to that of the normal distribution, both of 95 %. A part
    weighs as the inverse of its standard error: alike, those that hardly know a number would lead; by the
    inverse square, the one that knows it best, which the whole fit follows.

    Parameters
    ----------
    value : ndarray, shape (n_parameters,)
        Of the whole [SI].
    parts : sequence of Part

    Returns
    -------
    ndarray, shape (n_parameters,)
        NaN of a number that less than two parts determine.
    """
    squares, weights, n = (np.zeros(len(value)) for _ in range(3))
    for part in parts:
        known = part.stderr > 0
        weight = 1 / part.stderr[known]
        squares[known] += weight * (part.value - value)[known] ** 2
        weights[known] += weight
        n[known] += 1
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(squares / weights) * stdtrit(n - 1, 0.975) / NORMAL_95)


def parts_of(theta: Floats, sigma: float) -> list[slice]:
    """Parts of a run with as many swings each, as far as the swings stand out of the noise.

    Parameters
    ----------
    theta : ndarray, shape (n_time,)
        Modelled rotation [rad].
    sigma : float
        Of the noise [rad]. What comes after the first swing below it belongs to the last part.
    """
    passes = np.flatnonzero(theta[1:] * theta[:-1] < 0) + 1
    heights = np.maximum.reduceat(np.abs(theta), passes) if len(passes) else np.empty(0)
    low = np.flatnonzero(heights < sigma)
    passes = passes[: low[0] + 1 if len(low) else len(passes)]
    at = np.unique(np.linspace(0, len(passes), PARTS_OF_RUN + 1).round().astype(int))[1:-1]
    ends = [0, *(int(passes[i - 1]) for i in at), len(theta)]
    return [slice(start, end) for start, end in pairwise(ends)]


def _step(residual: Floats, jacobian: Floats) -> tuple[Floats, Floats]:
    """Gauss and Newton's step to the best of a part, and its covariance under white noise of 1 rad."""
    n = jacobian.shape[1]
    step, covariance = np.zeros(n), np.full((n, n), np.nan)
    scale = np.sqrt(np.mean(jacobian**2, axis=0))
    seen = np.flatnonzero(scale > 0)
    scaled = jacobian[:, seen] / scale[seen]
    normal = scaled.T @ scaled
    if len(residual) > len(seen) > 0 and np.linalg.cond(normal) < SINGULAR:
        step[seen] = -np.linalg.solve(normal, scaled.T @ residual) / scale[seen]
        covariance = np.zeros((n, n))
        covariance[np.ix_(seen, seen)] = np.linalg.inv(normal) / np.outer(scale[seen], scale[seen])
    return step, covariance


def first_half(
    problem: Problem, x: Floats, m: int, jacobian: Floats | None, theta: Floats
) -> tuple[Floats, float]:
    """Fitted numbers of the first half of a run, and ε_θ of its second half under them.

    ε_θ is NaN where the first half has too few samples.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    m : int
        Samples averaged into one.
    jacobian : ndarray, shape (n_samples, n_parameters), or None
        `Problem.jacobian` there, of all samples, where it is known.
    theta : ndarray, shape (n_samples,)
        `Problem.curve` there [rad].
    """
    motion = problem.motions[0]
    half = motion.time_s[-1] / 2
    samples = problem.samples(half, m=m)
    if sum(samples.lengths) <= 2 * m * len(x):
        return x, float("nan")
    known = None if jacobian is None else jacobian[: len(samples.theta)]
    x = least_squares(problem, x, samples, jacobian=known, theta=theta[: len(samples.theta)]).x
    later = motion.time_s > half
    theta = problem.motion(x, 0, motion.time_s)
    return x, epsilon_theta(motion.time_s[later], theta[later], motion.theta[later])


def added_number(
    problem: Problem, x: Floats, exact: Floats, linear: Whitened, without: Likelihood
) -> float | None:
    """How many standard errors the number that the law lacks would be away from zero; the largest of several.

    By the ratio of likelihoods under the noise at rest, with the derivative by that number: its root, which
    is negative where a damping would have to drive the block, or a bed to soften. None where the law lacks
    none, where debonding is not implemented with it, and of a motion that multiplies errors
    (`diverging_motions`).

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    exact : ndarray, shape (n_samples,)
        The first of `Problem.exact_curve` there.
    linear : Whitened
        Residual and derivatives there, of all samples; without those by parameters held at a bound.
    without : Likelihood
        Of these.
    """
    samples, found = problem.samples(), list[float]()
    for other, model in extended_by(problem.model).items() if problem.directions is None else ():
        law = law_of(model)
        if not law.allows(problem.settings.debonding, len(law.ratios)):
            continue
        # the trough of the misfit is bent: a larger trace gives no derivative
        trace = 1e-3 * PARAMETERS[other].trace * problem.physical(x)[0]
        column = problem.curve(x, samples, problem.exact_rtol, {other: trace}) - exact
        added = linear.adding(column)
        gain = max(without.minus_two_log - added.minus_two_log, 0.0)
        found.append(float(np.copysign(np.sqrt(gain), added.step[-1])))
    return max(found, default=None)


def failure(problem: Problem, solution: Solution, known: Uncertainty, epsilon: float) -> str:
    """Why the fit is not to be used; "" when it is. A nuisance of a run held at its bound is no failure."""
    n_common = len(problem.common)
    if not solution.success:
        return f"not converged: {solution.message}"
    for name, pinned in zip(problem.common, problem.at_bound(solution.x), strict=False):
        if pinned:
            given = " of fits.parameters" if name in problem.given else ""
            return f"{name} lies at its bound{given}"
    if not np.all(np.isfinite(np.diag(known.covariance)[:n_common])):
        return "the data do not determine the parameters"
    if (
        len(problem.motions) == 1
        and is_lively(problem, solution.x)
        and is_poor(problem, solution.mean_square / SEARCH.left**2)
    ):
        return "the block has little damping and the residual exceeds the noise: possibly another minimum"
    if is_beyond(problem):
        return "the motion multiplies errors beyond precision: possibly another minimum"
    if epsilon >= 1:
        return "worse than a block at rest (ε_θ ≥ 1)"
    return ""
