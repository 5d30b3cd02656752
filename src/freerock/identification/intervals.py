"""How well parameters are known: standard errors and 95 % intervals in SI units, and profile intervals."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

from freerock.arrays import Floats, Mask
from freerock.identification.covariance import Known, covariance
from freerock.identification.estimate import NORMAL_95
from freerock.identification.noise import AgainstRest, noise_of_residual
from freerock.identification.nuisances import Posterior
from freerock.identification.problem import FINE, Problem, Samples
from freerock.models.laws import MODELS, law_of
from freerock.rotation.laboratory import Contributions

if TYPE_CHECKING:
    import lmfit

SURPRISE = 3.0  # standard errors by which the halves of a run may disagree
MANY = 1e6  # degrees of freedom that are as good as infinitely many
LEARNED = 1e-2  # least share of the variance of an input that a fit removes, from which there is a pull
STEEPEST = 3.0  # ratio of standard errors beyond which the profile has no level to find


@dataclass(frozen=True)
class Uncertainty:
    """Of all parameters of a fit, in their units; NaN where the data do not determine them.

    Parameters
    ----------
    covariance : ndarray, shape (n_parameters, n_parameters)
    stderr, low, high : ndarray, shape (n_parameters,)
        Standard errors and ends of the 95 % intervals.
    coloured : bool
        Whether neighbouring residuals correlate.
    widened : float
        Largest factor by which a standard error was raised because the halves of the run disagree.
    """

    covariance: Floats
    stderr: Floats
    low: Floats
    high: Floats
    coloured: bool
    widened: float

    def unknown(self) -> "Uncertainty":
        """The same without any number: of a fit that is not to be used."""
        nothing = np.full_like(self.stderr, np.nan)
        return replace(
            self,
            covariance=np.full_like(self.covariance, np.nan),
            stderr=nothing,
            low=nothing.copy(),
            high=nothing.copy(),
        )


def uncertainty(
    problem: Problem,
    x: Floats,
    residual: Floats,
    jacobian: Floats,
    rest: AgainstRest,
    apart: Floats | None,
) -> Uncertainty:
    """Uncertainty of the fitted numbers, in SI units.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    residual, jacobian : ndarray, shapes (n_samples,) and (n_samples, n_parameters)
        There, of all samples.
    rest : AgainstRest
        The residual against the noise at rest.
    apart : ndarray, shape (n_parameters,), or None
        What the first half of the run would change of x, where that counts.
    """
    free, samples = ~problem.held(x), problem.samples()
    own = jacobian[:, free]
    is_noise = rest.is_noise and all(motion.noise is not None for motion in problem.motions)
    noises = rest.noises
    if not is_noise:
        noises = noise_of_residual(residual, own, samples.lengths, _rates(problem), rest.averages)
    theta = samples.theta + residual
    known = covariance(residual, own, samples.lengths, noises, theta, is_noise=is_noise)
    of_x = np.full((len(x), len(x)), np.nan)
    of_x[np.ix_(free, free)] = known.covariance
    of_x, widened = (of_x, 1.0) if apart is None else _widened(of_x, apart)
    return _in_si_units(problem, x, free, of_x, known, widened)


def with_inputs(best: Posterior, rest: AgainstRest) -> tuple[Uncertainty, Contributions]:
    """Uncertainty by noise of a run whose inputs moved, in SI units, and what the inputs contribute.

    The estimate is linear in noise and priors: its covariance is the sum of that by the noise of the samples,
    of that by the measured release, and of the squares of the contributions (JCGM 100:2008, 5.1).

    Parameters
    ----------
    best : Posterior
    rest : AgainstRest
        Its residual against the noise at rest.
    """
    problem, x, free = best.problem, best.x, best.free
    rows, theta, n = best.level * best.prior[1], best.curve, int(best.free.sum())
    is_noise, lengths, noises = problem.motions[0].noise is not None, best.samples.lengths, rest.noises
    if not is_noise:
        noises = noise_of_residual(best.residual, best.taken, lengths, _rates(problem), rest.averages)
    known = covariance(best.residual, best.columns, lengths, noises, theta, is_noise=is_noise, prior=rows)
    by_release, by_inputs = np.split(best.by_prior, [len(rows) - len(best.z)], axis=1)
    both = known.covariance + by_release @ by_release.T
    of_x = np.full((len(x), len(x)), np.nan)
    of_x[np.ix_(free, free)] = both[:n, :n]
    found = _in_si_units(problem, x, free, of_x, replace(known, dof=known.dof[:n]), 1.0)
    shifts = problem.gradient(x)[:, free] @ by_inputs[:n]
    left = np.eye(len(best.z)) - by_inputs[n:]
    of_z = np.diag(both)[n:]
    with np.errstate(invalid="ignore", divide="ignore"):
        pulls = best.z / np.sqrt(of_z + np.sum(left**2, axis=1))
        remaining = np.sqrt(of_z + np.sum(by_inputs[n:] ** 2, axis=1))
    laboratory = best.nuisances.problem.motions[0].laboratory
    inputs = laboratory.inputs if laboratory else ()
    every = Contributions.held(inputs, np.zeros((len(x), len(inputs))))
    at = [inputs.index(each) for each in best.nuisances.sources]
    every.values[:, at], every.moved[at], every.remaining[at] = shifts, best.z, remaining
    every.impacts[:, at] = problem.gradient(x)[:, free] @ best.impacts
    every.pulls[at] = np.where(remaining**2 < 1 - LEARNED, pulls, np.nan)
    for j, each in enumerate(inputs):
        if (
            each.name == "mass_kg" and j not in at and law_of(problem.model).is_foundation
        ):  # forces are as the mass
            forces = problem.is_logarithm
            every.values[forces, j] = problem.physical(x)[forces] * each.u / problem.blocks[0].mass_kg
            every.impacts[forces, j] = every.values[forces, j]
    return found, every


def _in_si_units(
    problem: Problem, x: Floats, free: Mask, of_x: Floats, known: Known, widened: float
) -> Uncertainty:
    """Uncertainty of the parameters from the covariance of the fitted numbers."""
    among, found = (
        np.ix_(free, free),
        ~problem.at_bound(x),
    )  # one that is fixed has no error, a tied one its own
    value, gradient = problem.physical(x), problem.gradient(x)[np.ix_(found, free)]
    of_value = np.full_like(of_x, np.nan)
    of_value[np.ix_(found, found)] = gradient @ of_x[among] @ gradient.T
    stderr = np.sqrt(np.diag(of_value))
    half = _student_95(problem, free, known.dof) * stderr
    with np.errstate(over="ignore"):
        factor = np.exp(half / np.abs(value))
        low = np.where(problem.is_logarithm, value / factor, value - half)
        high = np.where(problem.is_logarithm, value * factor, value + half)
    return Uncertainty(of_value, stderr, low, high, known.coloured, widened)


def _rates(problem: Problem) -> list[float]:
    """Samples per second of each run."""
    return [(len(motion.time_s) - 1) / float(np.ptp(motion.time_s)) for motion in problem.motions]


def _student_95(problem: Problem, free: Mask, dof: Floats) -> Floats:
    """Standard errors from the value to the ends of its 95 % interval, by Student's t.

    Of damping, fitted as its ratio to k, with the degrees of freedom of the one that has fewer.
    """
    of_x = np.full(len(free), np.inf if problem.varied.all() else dof.min(initial=np.inf))
    of_x[free] = dof
    of_x = np.where(problem.is_ratio, np.minimum(of_x, of_x[0]), of_x)
    return np.asarray(np.where(np.isfinite(of_x), stdtrit(np.minimum(of_x, MANY), 0.975), NORMAL_95))


def _widened(covariance_x: Floats, apart: Floats) -> tuple[Floats, float]:
    """Covariance that covers the difference of the first half of a run from the whole, and the factor.

    Under a law that is not the whole truth, parts of a run disagree by more than the correlation of the
    residual explains. What is beyond three standard errors counts: √(1 + d² - 3²) of d standard errors apart.
    """
    stderr = np.sqrt(np.diag(covariance_x))
    beyond = np.maximum((apart / stderr) ** 2 - SURPRISE**2, 0.0)
    factor = np.where(np.isfinite(beyond), np.sqrt(1 + beyond), 1.0)
    return covariance_x * np.outer(factor, factor), float(np.nanmax(factor, initial=1.0))


def with_profile(problem: Problem, x: Floats, m: int, known: Uncertainty) -> tuple[Uncertainty, bool]:
    """Uncertainty with intervals of the model's parameters by the profile likelihood, and if there are any.

    Where the residual is coloured the likelihood's curvature exaggerates what is known: the level is raised
    by the ratio of the standard errors. Beyond a ratio of three there is no level to find, and no interval.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    m : int
        Samples averaged into one.
    known : Uncertainty
    """
    problem = replace(problem, rtol=min(problem.rtol, FINE))
    intervals = _profile(problem, x, problem.samples(m=m), known.stderr)
    low, high = known.low.copy(), known.high.copy()
    for name, ends in intervals.items():
        low[problem.names.index(name)], high[problem.names.index(name)] = ends
    return replace(known, low=low, high=high), bool(intervals)


def _profile(problem: Problem, x: Floats, samples: Samples, stderr: Floats) -> dict[str, Floats]:
    """Ends of the intervals, by the name of the model's parameter."""
    import lmfit  # asked for by few

    names = MODELS[problem.model]
    value = problem.physical(x)[: len(names)]
    logarithms = problem.is_logarithm[: len(names)]
    spread = stderr[: len(names)] / np.where(logarithms, value, 1.0)
    minimizer, best = _in_standard_errors(problem, x, samples, stderr, spread)
    intervals = {}
    for i, name in enumerate(names):
        of_name = f"u{i}"
        ratio = max(1.0, 1 / (best.params[of_name].stderr or np.inf))
        if best.errorbars and ratio < STEEPEST:
            found = lmfit.conf_interval(minimizer, best, p_names=[of_name], sigmas=[NORMAL_95 * ratio])
            ends = spread[i] * (np.array([found[of_name][0][1], found[of_name][-1][1]]) - 10.0)
            intervals[name] = value[i] * np.exp(ends) if logarithms[i] else value[i] + ends
    return intervals


def _in_standard_errors(
    problem: Problem, x: Floats, samples: Samples, stderr: Floats, spread: Floats
) -> "tuple[lmfit.Minimizer, lmfit.minimizer.MinimizerResult]":
    """The problem with its numbers in standard errors, the best at 10, and its minimum.

    lmfit walks and finds the ends of an interval in shares of the value. Profiled are ln k and ln λ; fitted
    were ln k and ln λ/k.
    """
    import lmfit

    to_fitted = np.eye(len(x))
    to_fitted[problem.is_ratio, 0] = -1.0  # dampings, where nothing is given
    unit = np.where(np.isfinite(stderr), stderr, 1.0)
    unit[: len(spread)] = spread
    to_fitted *= unit
    parameters = lmfit.Parameters()
    for i, pinned in enumerate(problem.held(x)):
        parameters.add(f"u{i}", value=10.0, vary=not pinned)

    def fitted(p: "lmfit.Parameters") -> Floats:
        return np.asarray(x + to_fitted @ [p[name].value - 10.0 for name in parameters])

    def residual(p: "lmfit.Parameters") -> Floats:
        return problem.residual(fitted(p), samples)

    def jacobian(p: "lmfit.Parameters") -> Floats:
        columns = samples.averaged(problem.jacobian(fitted(p), samples)) @ to_fitted
        return np.asarray(columns[:, [p[name].vary for name in parameters]])

    minimizer = lmfit.Minimizer(residual, parameters, Dfun=jacobian)
    return minimizer, minimizer.leastsq()
