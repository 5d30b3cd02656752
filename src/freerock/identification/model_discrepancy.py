"""How far off the numbers of a law may be that does not explain its run: from how they move over the run.

The swings of a run are cut into parts of as many. The fit of a part is one step of Gauss and Newton from that
of the whole, with its derivatives, so that nothing is simulated: release angle and instant are free in every
part and take up where the block comes from. Under the right law the parts agree to within the noise. Under
another one they differ by about as much as the whole is off: measured on motions of other physics
(`studies.discrepancy`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.special import stdtrit

from freerock.arrays import Floats
from freerock.identification.estimate import NORMAL_95
from freerock.identification.problem import Problem

PARTS = 6  # of a run, if it has as many swings; set with the weights on the half "set" of that study
# By which a logarithm may move in a part: a straight line leads no farther; others by their span.
FARTHEST = 1.0
SINGULAR = 1e13  # condition of the scaled normal matrix, from which a part does not separate the parameters


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
    farthest = np.where(problem.is_logarithm, FARTHEST * np.abs(value), span)
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
    at = np.unique(np.linspace(0, len(passes), PARTS + 1).round().astype(int))[1:-1]
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
