"""How exact a fit must be: the integrator's tolerance and the averaging that the standard errors allow."""

from dataclasses import dataclass, replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.problem import Problem, Samples
from freerock.models.laws import law_of

FINEST = 1e-12  # least rtol
EXACT = 1e-15  # least rtol with which one is compared
WORTH = 0.02  # largest share of a standard error that averaging of samples may cost
LEAST = 20  # averaged samples per parameter


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


def find_resolution(problem: Problem, x: Floats) -> Resolution:
    """Loosest tolerance and coarsest averaging that the standard errors allow.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers, near their best.
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
        finer = max(rtol / 100, EXACT)
        exact = known[0] if finer == problem.exact_rtol else problem.curve(x, samples, finer)
        shifts = np.abs(inverse @ (jacobian.T @ (theta - exact)))[spread > 0] / (spread[spread > 0] * noise)
        shift = float(np.max(shifts, initial=0.0))
        if not shift > problem.settings.integrator_error or rtol <= FINEST:
            return Resolution(rtol, m, shift, derivatives, theta)
        rtol /= 10
        theta = problem.curve(x, samples, rtol)


def _averaging(samples: Samples, jacobian: Floats, spread: Floats) -> int:
    """How many samples may be averaged into one: a power of two."""
    m, pairs, means = 1, replace(samples, m=2), jacobian
    while 2 * m * LEAST * jacobian.shape[1] < min(samples.lengths):
        means = pairs.averaged(means)
        wider = np.sqrt(np.diag(np.linalg.pinv(means.T @ means, hermitian=True)))
        if np.any(wider > (1 + WORTH) * spread):
            break
        m, pairs = 2 * m, replace(pairs, lengths=tuple(n // 2 for n in pairs.lengths))
    return m
