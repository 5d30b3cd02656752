"""Uncertainty of parameters by noise: covariance, standard errors, intervals.

`Fit.u_total` adds the inputs of the laboratory and the law.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import lmfit
import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, fftfreq, irfft, next_fast_len, rfft
from scipy.special import stdtrit

from freerock.arrays import Floats, Mask
from freerock.identification.against_noise import noise_of_residual
from freerock.identification.inputs_with_priors import Posterior, contributed
from freerock.identification.problem import RTOL_DERIVATIVES, Problem, Samples
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.laws import MODELS
from freerock.noise.spectrum import Noise, averaged
from freerock.rotation.u_total import Contributions

SINGULAR = 1e13  # condition of a scaled normal matrix beyond which samples do not separate the parameters


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
        numbers = ("covariance", "stderr", "low", "high")
        return replace(self, **{name: np.full_like(getattr(self, name), np.nan) for name in numbers})


def uncertainty(
    best: Posterior, apart: Floats | None = None, learned: float = 1e-2
) -> tuple[Uncertainty, Contributions]:
    """Uncertainty by noise of the numbers of a fit, in SI units, and what the inputs that moved contribute.

    The estimate is linear in noise and priors: its covariance is the sum of that by the noise of the samples,
    of that by the measured release, and of the squares of the contributions (JCGM 100:2008, 5.1).

    Parameters
    ----------
    best : Posterior
    apart : ndarray, shape (n_parameters,), optional
        What the first half of the run would change of the fitted numbers, where that counts.
    learned : float
        Least share of the variance of an input that a fit removes, from which there is a pull.
    """
    problem, x, free, rest = best.problem, best.x, best.free, best.against_rest
    rows, theta, n = best.prior[1], best.curve, int(free.sum())
    rows = best.level * rows if len(rows) else rows
    passes = rest.is_noise or best.result is not None
    is_noise = passes and all(motion.noise is not None for motion in problem.motions)
    lengths, noises = best.samples.lengths, rest.noises
    if not is_noise:
        noises = noise_of_residual(best.residual, best.taken, lengths, _rates(problem), rest.averages)
    known = covariance(best.residual, best.columns, lengths, noises, theta, is_noise=is_noise, prior=rows)
    by_release, by_inputs = np.split(best.by_prior, [len(rows) - len(best.z)], axis=1)
    both = known.covariance + by_release @ by_release.T
    of_x = np.full((len(x), len(x)), np.nan)
    of_x[np.ix_(free, free)] = both[:n, :n]
    of_x, widened = (of_x, 1.0) if apart is None else _widened(of_x, apart)
    found = _in_si_units(problem, x, free, of_x, replace(known, dof=known.dof[:n]), widened)
    left = np.eye(len(best.z)) - by_inputs[n:]
    of_z = np.diag(both)[n:]
    of_shifts = both[n:, n:] + left @ left.T
    with np.errstate(invalid="ignore", divide="ignore"):
        pulls = best.z / np.sqrt(np.diag(of_shifts))
        remaining = np.sqrt(of_z + np.sum(by_inputs[n:] ** 2, axis=1))
    of_inputs = np.zeros((len(x), len(best.z)))
    of_inputs[free] = by_inputs[:n]
    every = contributed(replace(best.nuisances, problem=problem), x, of_inputs)
    at = [every.inputs.index(each) for each in best.nuisances.sources]
    every.moved[at], every.remaining[at] = best.z, remaining
    every.impacts[:, at] = problem.gradient(x)[:, free] @ best.impacts
    every.pulls[at] = np.where(remaining**2 < 1 - learned, pulls, np.nan)
    return found, replace(every, enlarged=_enlarged(best.z, of_shifts, learned))


def _enlarged(z: Floats, covariance: Floats, learned: float) -> float:
    """How many times their covariance allows the shifts z of inputs are; at least 1.

    √(χ²/ν) of the ν directions that the run sees, with more than a share `learned` of variance (Birge 1932,
    doi:10.1103/PhysRev.40.207).
    """
    if not np.isfinite(covariance).all():  # the data do not determine the numbers
        return 1.0
    size, directions = np.linalg.eigh(covariance)
    seen = size > learned
    squares = (z @ directions[:, seen]) ** 2 / size[seen]
    return max(1.0, float(np.sqrt(squares.mean()))) if seen.any() else 1.0


def _in_si_units(
    problem: Problem, x: Floats, free: Mask, of_x: Floats, known: "KnownCovariance", widened: float
) -> Uncertainty:
    """Uncertainty of the parameters from the covariance of the fitted numbers."""
    among, found = np.ix_(free, free), ~problem.at_bound(x)  # a fixed one has no error, a tied one its own
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
    problem = replace(problem, rtol=min(problem.rtol, RTOL_DERIVATIVES))
    intervals = _profile(problem, x, problem.samples(m=m), known.stderr)
    low, high = known.low.copy(), known.high.copy()
    for name, ends in intervals.items():
        low[problem.names.index(name)], high[problem.names.index(name)] = ends
    return replace(known, low=low, high=high), bool(intervals)


def _profile(
    problem: Problem, x: Floats, samples: Samples, stderr: Floats, steepest: float = 3.0
) -> dict[str, Floats]:
    """Ends of the intervals, by the name of the model's parameter; none beyond a ratio `steepest`."""
    names = MODELS[problem.model]
    value = problem.physical(x)[: len(names)]
    logarithms = problem.is_logarithm[: len(names)]
    spread = stderr[: len(names)] / np.where(logarithms, value, 1.0)
    minimizer, best = _in_standard_errors(problem, x, samples, stderr, spread)
    intervals = {}
    for i, name in enumerate(names):
        of_name = f"u{i}"
        ratio = max(1.0, 1 / (best.params[of_name].stderr or np.inf))
        if best.errorbars and ratio < steepest:
            found = lmfit.conf_interval(minimizer, best, p_names=[of_name], sigmas=[NORMAL_95 * ratio])
            ends = spread[i] * (np.array([found[of_name][0][1], found[of_name][-1][1]]) - 10.0)
            intervals[name] = value[i] * np.exp(ends) if logarithms[i] else value[i] + ends
    return intervals


def _in_standard_errors(
    problem: Problem, x: Floats, samples: Samples, stderr: Floats, spread: Floats
) -> tuple[lmfit.Minimizer, lmfit.minimizer.MinimizerResult]:
    """The problem with its numbers in standard errors, the best at 10, and its minimum.

    lmfit walks and finds the ends of an interval in shares of the value. Profiled are ln k and ln λ; fitted
    were ln k and ln λ/k.
    """
    to_fitted = np.eye(len(x))
    to_fitted[problem.is_ratio, 0] = -1.0  # dampings, where nothing is given
    unit = np.where(np.isfinite(stderr), stderr, 1.0)
    unit[: len(spread)] = spread
    to_fitted *= unit
    parameters = lmfit.Parameters()
    for i, pinned in enumerate(problem.held(x)):
        parameters.add(f"u{i}", value=10.0, vary=not pinned)

    def fitted(p: lmfit.Parameters) -> Floats:
        return np.asarray(x + to_fitted @ [p[name].value - 10.0 for name in parameters])

    def residual(p: lmfit.Parameters) -> Floats:
        return problem.residual(fitted(p), samples)

    def jacobian(p: lmfit.Parameters) -> Floats:
        columns = samples.averaged(problem.jacobian(fitted(p), samples)) @ to_fitted
        return np.asarray(columns[:, [p[name].vary for name in parameters]])

    minimizer = lmfit.Minimizer(residual, parameters, Dfun=jacobian)
    return minimizer, minimizer.leastsq()


def _rates(problem: Problem) -> list[float]:
    """Samples per second of each run."""
    return [(len(motion.time_s) - 1) / float(np.ptp(motion.time_s)) for motion in problem.motions]


def _student_95(problem: Problem, free: Mask, dof: Floats, many: float = 1e6) -> Floats:
    """Standard errors from the value to the ends of its 95 % interval, by Student's t.

    Of damping, fitted as its ratio to k, with the degrees of freedom of the one that has fewer; `many` are as
    good as infinitely many.
    """
    of_x = np.full(len(free), np.inf if problem.varied.all() else dof.min(initial=np.inf))
    of_x[free] = dof
    of_x = np.where(problem.is_ratio, np.minimum(of_x, of_x[0]), of_x)
    return np.asarray(np.where(np.isfinite(of_x), stdtrit(np.minimum(of_x, many), 0.975), NORMAL_95))


def _widened(covariance_x: Floats, apart: Floats, surprise: float = 3.0) -> tuple[Floats, float]:
    """Covariance that covers the difference of the first half of a run from the whole, and the factor.

    Under a law that is not the whole truth, parts of a run disagree by more than the correlation of the
    residual explains. What is beyond three standard errors (`surprise`) counts: √(1 + d² - 3²) of d standard
    errors apart.
    """
    stderr = np.sqrt(np.diag(covariance_x))
    beyond = np.maximum((apart / stderr) ** 2 - surprise**2, 0.0)
    factor = np.where(np.isfinite(beyond), np.sqrt(1 + beyond), 1.0)
    return covariance_x * np.outer(factor, factor), float(np.nanmax(factor, initial=1.0))


@dataclass(frozen=True)
class KnownCovariance:
    """How well least squares know the fitted numbers.

    Parameters
    ----------
    covariance : ndarray, shape (n_parameters, n_parameters)
        NaN where the samples do not separate the parameters.
    dof : ndarray, shape (n_parameters,)
        Degrees of freedom with which the noise tells the variances.
    coloured : bool
        Whether neighbouring residuals correlate.
    """

    covariance: Floats
    dof: Floats
    coloured: bool


def covariance(
    residual: Floats,
    jacobian: Floats,
    lengths: Sequence[int],
    noises: Sequence[Noise],
    theta: Floats,
    *,
    is_noise: bool,
    prior: Floats | None = None,
) -> KnownCovariance:
    """Covariance of the least-squares estimate: the sandwich (JᵀJ)⁻¹ JᵀΓJ (JᵀJ)⁻¹.

    Γ is the covariance of the noise, by its spectrum. The variance of each number is a sum over the octaves
    of the spectrum, of which each is known with its degrees of freedom; those of the sum are Welch's and
    Satterthwaite's (doi:10.2307/3002019).

    A residual that is not noise, or of which nothing says that it is, has at least the covariances of white
    noise, s²(JᵀJ)⁻¹, and where neighbours correlate (lag-one correlation beyond four standard errors) of the
    Bartlett-weighted long-run covariance of the scores J_i e_i, bandwidth by Andrews (1991),
    doi:10.2307/2938229. That assumes nothing of the noise, but needs runs much longer than its correlation.

    Noise that is louder where a number moves the curve, such as speckle, raises its variance by the ratio of
    Σ(I e)² to ΣI² mean(e²), with I the influence of each sample (White 1980, doi:10.2307/1912934).

    Parameters
    ----------
    residual : ndarray, shape (n_time,)
        Of all runs, one after the other.
    jacobian : ndarray, shape (n_time, n_parameters)
    lengths : sequence of int
        Samples of each run.
    noises : sequence of Noise
        Of each run.
    theta : ndarray, shape (n_time,)
        Modelled rotation [rad], which goes through the steps of the converter.
    is_noise : bool
        Whether the residual is known to be noise.
    prior : ndarray, shape (n_rows, n_parameters), optional
        Rows that priors add to the derivatives [rad]; the covariance is that by the noise alone.
    """
    n, n_parameters = jacobian.shape
    prior = np.empty((0, n_parameters)) if prior is None else prior
    scale = np.sqrt((np.sum(jacobian**2, axis=0) + np.sum(prior**2, axis=0)) / max(n, 1))
    nothing = np.full((n_parameters, n_parameters), np.nan), np.full(n_parameters, np.inf)
    if not (n_parameters and np.all(scale > 0)):
        return KnownCovariance(*nothing, False)
    jacobian, prior = jacobian / scale, prior / scale
    normal = jacobian.T @ jacobian + prior.T @ prior
    if not np.linalg.cond(normal) < SINGULAR:
        return KnownCovariance(*nothing, False)
    inverse = np.linalg.inv(normal)
    influence = jacobian @ inverse
    centred = residual - residual.mean()
    correlation = centred[1:] @ centred[:-1] / (centred @ centred)
    coloured = bool(abs(correlation) > 4 / np.sqrt(n))
    best, dof = _of_noise(residual, influence, lengths, noises, theta)
    if is_noise:
        uneven = np.sqrt(np.maximum(_unevenness(residual, influence), 1.0))
        best *= np.outer(uneven, uneven)
    else:
        others = [residual @ residual / (n - n_parameters) * inverse]
        others += [_long_run(influence * residual[:, None], lengths)] if coloured else []
        for other in others:
            widen = np.sqrt(np.maximum(np.diag(best) / np.diag(other), 1.0))
            best = other * np.outer(widen, widen)
    return KnownCovariance(best / np.outer(scale, scale), dof, coloured)


def _unevenness(residual: Floats, influence: Floats) -> Floats:
    """How much louder noise is where samples count for each number, as a ratio of powers.

    Without what chance does: the standard deviation of the ratio under white noise.
    """
    weight, square, least = influence**2, residual**2, float(np.finfo(float).tiny)
    total = np.maximum(np.sum(weight, axis=0), least)
    chance = np.sqrt(2 * np.sum(weight**2, axis=0)) / total
    return np.asarray(square @ weight / (total * max(float(square.mean()), least)) - chance)


def _of_noise(
    residual: Floats,
    influence: Floats,
    lengths: Sequence[int],
    noises: Sequence[Noise],
    theta: Floats,
    padding: int = 4,
) -> tuple[Floats, Floats]:
    """Covariance by the spectrum of the noise and the steps of the converter, and its degrees of freedom.

    Runs are padded to so many times their length, so that slow noise does not wrap around.
    """
    total = np.zeros((influence.shape[1],) * 2)
    spread = np.zeros(influence.shape[1])
    parts = (np.split(values, np.cumsum(lengths)[:-1]) for values in (residual, influence, theta))
    for noise, own, columns, moving in zip(noises, *parts, strict=True):
        mean_square = float(own @ own / len(own))
        waves = _waves(moving, noise.step, mean_square)
        if len(waves):
            of_waves = waves @ columns
            total += np.real(np.conj(of_waves).T @ of_waves)
        columns = averaged(columns, noise.averaged)
        size = next_fast_len(padding * len(columns), real=True)
        frequency = np.arange(size // 2 + 1) / size
        density, band, n_bands = noise.density(frequency), noise.band(frequency), len(noise.ratio)
        if len(waves):
            least = mean_square - float(np.sum(np.abs(waves) ** 2)) / len(own)
            density = np.maximum(density - _density_of(waves, noise)[band], max(least, 0.0))
        weight = density * np.where((frequency == 0) | (frequency == 0.5), 1, 2) / size
        transform = rfft(np.ascontiguousarray(columns.T), size)
        total += np.real((transform * weight) @ np.conj(transform).T)
        for j, power in enumerate((transform.real**2 + transform.imag**2) * weight):
            spread[j] += np.sum(np.bincount(band, power, n_bands) ** 2 / np.maximum(noise.dof, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return total, np.diag(total) ** 2 / spread


def _waves(
    theta: Floats, q: float, mean_square: float, harmonics: int = 8, unseen: float = 1e-3
) -> NDArray[np.complex128]:
    """Error of a converter of steps q while a block goes through them, shape (n_harmonics, n_time) [rad].

    Under normal noise of σ before the converter its error has, over the place θ between two steps, the mean
    Σ ±(q/πk) exp(-2π²k²σ²/q²) sin(2πkθ/q) (Widrow and Kollár 2008, doi:10.1017/CBO9780511754661). It stays
    where the block stays, and is no more than white noise where it moves fast. Where the zero of the
    converter lies between two steps is not known, and any place as likely: then the covariance of the error
    is the real part of the products of these waves. Harmonics too weak to be seen are left out.

    Parameters
    ----------
    theta : ndarray, shape (n_time,)
        [rad]
    q : float
        [rad]
    mean_square : float
        Of the residual [rad²]: noise before the converter, and q²/12.
    harmonics : int
    unseen : float
        Share of the power of the residual, below which a harmonic does not show.
    """
    k = np.arange(1, harmonics + 1 if q else 1)
    before = max(mean_square - q**2 / 12, 0.0)
    size = q / (np.pi * k) * np.exp(-2 * before * (np.pi * k / (q or 1.0)) ** 2)
    seen = size**2 / 2 > unseen * mean_square
    turns = 2j * np.pi * np.outer(k[seen], theta) / (q or 1.0)
    return np.asarray(size[seen, None] / np.sqrt(2) * np.exp(turns))


def _density_of(waves: NDArray[np.complex128], noise: Noise) -> Floats:
    """Mean spectral density of the waves in each band of the noise [rad²]."""
    coarse = averaged(waves.real.T, noise.averaged) + 1j * averaged(waves.imag.T, noise.averaged)
    n, n_bands = len(coarse), len(noise.ratio)
    power = np.sum(np.abs(fft(coarse, axis=0)) ** 2, axis=1) / n
    band = noise.band(np.abs(fftfreq(n)))
    return np.asarray(np.bincount(band, power, n_bands) / np.maximum(np.bincount(band, minlength=n_bands), 1))


def _long_run(scores: Floats, lengths: Sequence[int]) -> Floats:
    """Bartlett-weighted long-run covariance of the scores, shape (n_parameters, n_parameters)."""
    bandwidth = _andrews_bandwidth(scores)
    inner = np.zeros((scores.shape[1],) * 2)
    for run in np.split(scores, np.cumsum(lengths)[:-1]):
        lags = np.arange(-min(bandwidth, len(run) // 3), min(bandwidth, len(run) // 3) + 1)
        weights = 1 - np.abs(lags) / (lags[-1] + 1)
        inner += run.T @ _smoothed(run, weights)
    return inner


def _smoothed(columns: Floats, weights: Floats) -> Floats:
    """Convolution of columns with weights of an odd number about each sample."""
    n, beside = len(columns), len(weights) // 2
    size = next_fast_len(n + 2 * beside, real=True)
    both = rfft(columns, size, axis=0) * rfft(weights, size)[:, None]
    return np.asarray(irfft(both, size, axis=0)[beside : beside + n])


def _andrews_bandwidth(scores: Floats) -> int:
    scores = scores[:, np.any(scores != 0, axis=0)]  # of what the samples depend on
    if not scores.size:
        return 0
    rho = np.array([s[1:] @ s[:-1] / (s @ s) for s in scores.T]).clip(-0.999, 0.999)
    power = scores.var(axis=0) ** 2
    alpha = np.sum(power * 4 * rho**2 / ((1 - rho) ** 6 * (1 + rho) ** 2)) / np.sum(power / (1 - rho) ** 4)
    return int(np.ceil(1.1447 * (alpha * len(scores)) ** (1 / 3)))
