"""Fit of a motion that multiplies errors: horizons, steps and tolerances as fine as it requires.

Motions of a block with little damping diverge exponentially from their neighbours. Each horizon ends where
the remaining uncertainty of the parameters would move the curve by `reach` times the noise, so the next fit
starts near its minimum.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.against_noise import least_mean_square
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.problem import RTOL_DERIVATIVES, STRIDE, Problem, Samples
from freerock.identification.start import is_lively
from freerock.models.free_parameters import parameter_of


@dataclass(frozen=True)
class PursuitSettings:
    """Steps, horizons and ends of a pursuit; by judgement, shown on the demanding truths of `success`.

    Parameters
    ----------
    moved : float
        Times the noise: how far a step of a difference quotient moves the curve.
    within : float
        Factor of it that suffices.
    rounds : int
        Of finding these steps: too long a step moves the curve by less than its derivative says.
    finest : float
        rtol: a motion that requires less has minima beside minima.
    near : float
        Standard errors between ends of one minimum, where least squares stop early.
    reach, again : float, tuple of float
        Times the noise, at first and to see whether it comes to the same end.
    least, most : float
        Growth of a horizon.
    lost : float
        Times the mean square of the noise: a start that leaves more is in another basin.
    samples : int
        Of a horizon.
    ftol, last_ftol : float
        Of the horizons, and of the whole run.
    tries, shorter : int, float
        Fits of the whole run, and steps of the next one over those of the last.
    promise : float
        Times the variance of the noise: gain of the sum of squares that a last step may promise.
    """

    moved: float = 0.1
    within: float = 3.0
    rounds: int = 8
    finest: float = 5e-13
    near: float = 2.0
    reach: float = 10.0
    again: tuple[float, ...] = (3.0, 5.0)
    least: float = 1.03
    most: float = 2.0
    lost: float = 2.0
    samples: int = 1000
    ftol: float = 1e-4
    last_ftol: float = 1e-6
    tries: int = 4
    shorter: float = 0.3
    promise: float = 2.0


PURSUIT = PursuitSettings()


def resolved(problem: Problem, x: Floats, samples: Samples) -> Problem:
    """The same problem with derivatives by steps that move the curve by no more than the noise does.

    They are taken along the singular directions of the derivatives: an error of the one that moves the curve
    most would else hide what the samples tell of the others. The tolerance of the integrator follows the
    shortest step. A problem whose steps are short enough is left as it is, and so is one without noise.

    Parameters
    ----------
    problem : Problem
        Of a single run.
    x : ndarray, shape (n_parameters,)
        The fitted numbers, near their best.
    samples : Samples
    """
    noise, steps = _noise(problem), _usual_steps(problem)
    for _ in range(PURSUIT.rounds):
        jacobian = problem.jacobian(x, samples)
        if noise == 0 or _are_apt(problem, jacobian):
            break
        directions = _directions(jacobian, steps, PURSUIT.moved * noise)
        stride = float(np.min(np.linalg.norm(directions / steps[:, None], axis=0)))
        fine = max(PURSUIT.finest, RTOL_DERIVATIVES * stride)
        problem = replace(
            problem, directions=directions, stride=stride, fine=fine, rtol=min(problem.rtol, fine)
        )
    return problem


def multiplies_errors(problem: Problem, x: Floats) -> bool:
    """Whether the usual steps are too long for the derivatives of a run: of a block that is hardly damped."""
    if not is_lively(problem, x) or _noise(problem) == 0:
        return False
    usual = _with_usual_steps(problem)
    return not _are_apt(usual, usual.jacobian(x, problem.samples(most=PURSUIT.samples)))


def _with_usual_steps(problem: Problem) -> Problem:
    """The same problem with the usual steps and tolerances of derivatives."""
    return replace(problem, rtol=RTOL_DERIVATIVES, fine=RTOL_DERIVATIVES, stride=1.0, directions=None)


def _noise(problem: Problem) -> float:
    """Of the run [rad]."""
    return math.sqrt(least_mean_square(problem.motions[0]))


def _usual_steps(problem: Problem) -> Floats:
    """Of the fitted numbers."""
    return np.abs([parameter_of(name).step for name in problem.names])


def _are_apt(problem: Problem, jacobian: Floats) -> bool:
    """Whether the steps move the curve as they ought to, or may be the usual ones."""
    steps, apt = _usual_steps(problem), PURSUIT.moved * _noise(problem)
    most = PURSUIT.within * apt
    if problem.directions is None:
        quotients = np.array([name != "t0" for name in problem.names])
        return bool(np.all((problem.stride * steps * _size(jacobian))[quotients] <= most))
    moved = _size(jacobian @ problem.directions)
    longest = np.linalg.norm(problem.directions / steps[:, None], axis=0) > 0.99 * STRIDE
    return bool(np.all((moved <= most) & (longest | (moved >= apt / PURSUIT.within))))


def _directions(jacobian: Floats, steps: Floats, moved: float) -> Floats:
    """Singular directions, each as long as moves the curve so much [rad], but at most STRIDE usual steps."""
    _, size, directions = np.linalg.svd(
        jacobian * steps / moved / np.sqrt(len(jacobian)), full_matrices=False
    )
    return np.asarray(steps[:, None] * directions.T * np.minimum(1 / np.maximum(size, 1 / STRIDE), STRIDE))


def _size(columns: Floats) -> Floats:
    """Root mean square of each column."""
    return np.asarray(np.sqrt(np.mean(columns**2, axis=0)))


def is_beyond(problem: Problem) -> bool:
    """Whether the motion multiplies errors by more than the integrator can follow."""
    return problem.fine <= PURSUIT.finest


def pursue(problem: Problem, x: Floats, span_s: float, reach: float = PURSUIT.reach) -> Solution | None:
    """Least squares over horizons that grow as far as the numbers are known, by less where they lose them.

    None where they do so all the same. Where they had come to multiply errors by then, or do so by more than
    can be followed, the solution is what the last horizon gave, with a message: the motion is the law's.

    Parameters
    ----------
    problem : Problem
        Of a single run.
    x : ndarray, shape (n_parameters,)
        The fitted numbers, from a fit of the first horizon.
    span_s : float
        The first horizon [s].
    reach : float
        By how much what a horizon leaves open may move the curve until the end of the next one, times the
        noise.
    """
    problem, evaluations = _with_usual_steps(problem), 0
    last, noise = problem.motions[0].time_s[-1], least_mean_square(problem.motions[0])
    known_s = 0.0
    while True:
        samples = problem.samples(span_s, PURSUIT.samples)
        finer = resolved(problem, x, samples)
        end = least_squares(finer, x, samples, ftol=PURSUIT.ftol)
        evaluations += end.evaluations
        if end.mean_square > PURSUIT.lost * noise:
            if span_s < PURSUIT.least**2 * known_s or known_s == 0:
                multiplied = problem.directions is not None
                return end.losing("least squares stagnate") if multiplied else None
            span_s = float(np.sqrt(span_s * known_s))  # from where the motion is still known
            continue
        problem, x, known_s = finer, end.x, span_s
        if is_beyond(problem):
            return end.losing("the motion multiplies errors beyond precision")
        if span_s >= last:
            return replace(end, evaluations=evaluations)
        span_s = _next_span(problem, x, span_s, reach)


def are_one(problem: Problem, x: Floats, other: Floats) -> bool:
    """Whether two ends of a single run lie as near as those of one minimum do, in standard errors at both."""
    samples, usual = problem.samples(most=PURSUIT.samples), _with_usual_steps(problem)

    def spread(x: Floats) -> Floats:
        jacobian = resolved(usual, x, samples).jacobian(x, samples)
        size = np.where(problem.varied, np.linalg.norm(jacobian, axis=0), 1.0)
        return np.asarray(_noise(problem) * np.linalg.norm(np.linalg.pinv(jacobian / size), axis=1) / size)

    return all(bool(np.all(np.abs(x - other) <= PURSUIT.near * spread(end))) for end in (x, other))


def settle(problem: Problem, x: Floats) -> tuple[Problem, Solution]:
    """Least squares of a whole run, begun anew with shorter steps while these promise a further gain.

    Parameters
    ----------
    problem : Problem
        Of a single run, as `resolved` gives it.
    x : ndarray, shape (n_parameters,)
        The fitted numbers to start from.
    """
    samples, noise, evaluations = problem.samples(), least_mean_square(problem.motions[0]), 0
    for _ in range(PURSUIT.tries):
        end = least_squares(problem, x, samples, ftol=PURSUIT.last_ftol, reported=True)
        x, evaluations = end.x, evaluations + end.evaluations
        if problem.directions is not None:
            problem = replace(problem, directions=PURSUIT.shorter * problem.directions)
        basis, _ = np.linalg.qr(problem.jacobian(x, samples)[:, ~problem.held(x)])
        gain = float(np.sum((basis.T @ problem.residual(x, samples)) ** 2))
        if gain <= PURSUIT.promise * noise or end.mean_square > PURSUIT.lost * noise:
            return problem, replace(end, evaluations=evaluations)
    return problem, replace(end, evaluations=evaluations).losing("least squares stagnate")


def _next_span(problem: Problem, x: Floats, span_s: float, reach: float) -> float:
    """How far the numbers that a horizon gives are known to follow the motion [s]."""
    low, high = PURSUIT.least * span_s, PURSUIT.most * span_s
    samples = problem.samples(high, 2 * PURSUIT.samples)
    jacobian, known = problem.jacobian(x, samples)[:, problem.varied], samples.time_s <= span_s
    jacobian /= np.sqrt(np.mean(jacobian[known] ** 2, axis=0))
    _, size, directions = np.linalg.svd(jacobian[known], full_matrices=False)
    spread = np.linalg.norm(jacobian @ directions.T / size, axis=1)  # times the noise
    beyond = samples.time_s[spread > reach]
    return float(max(low, beyond[0])) if len(beyond) else high
