"""Covariance of least-squares parameters under the noise that the sensor has."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, fftfreq, irfft, next_fast_len, rfft

from freerock.arrays import Floats
from freerock.runs.noise import Noise, averaged

PADDING = 4  # times the length of a run, so that slow noise does not wrap around
SINGULAR = 1e13  # condition of the scaled normal matrix beyond which the data do not separate the parameters
HARMONICS = 8  # of the error of a converter, over the place between two steps
UNSEEN = 1e-3  # of the power of a residual, below which the steps of a converter do not show
TOLD = 4.0  # standard errors of a correlation, from which neighbours in a residual correlate


@dataclass(frozen=True)
class Known:
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
) -> Known:
    """Covariance of the least-squares estimate: the sandwich (JᵀJ)⁻¹ JᵀΓJ (JᵀJ)⁻¹.

    Γ is the covariance of the noise, by its spectrum. The variance of each number is a sum over the octaves
    of the spectrum, of which each is known with its degrees of freedom; those of the sum are Welch's and
    Satterthwaite's (doi:10.2307/3002019).

    A residual that is not noise, or of which nothing says that it is, has at least the covariances of white
    noise, s²(JᵀJ)⁻¹, and where neighbours correlate (lag-one correlation beyond four standard errors) of the
    Bartlett-weighted long-run covariance of the scores J_i e_i, bandwidth by Andrews (1991),
    doi:10.2307/2938229. That assumes nothing of the noise, but needs runs much longer than its correlation.

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
        return Known(*nothing, False)
    jacobian, prior = jacobian / scale, prior / scale
    normal = jacobian.T @ jacobian + prior.T @ prior
    if not np.linalg.cond(normal) < SINGULAR:
        return Known(*nothing, False)
    inverse = np.linalg.inv(normal)
    influence = jacobian @ inverse
    centred = residual - residual.mean()
    correlation = centred[1:] @ centred[:-1] / (centred @ centred)
    coloured = bool(abs(correlation) > TOLD / np.sqrt(n))
    best, dof = _of_noise(residual, influence, lengths, noises, theta)
    if not is_noise:
        others = [residual @ residual / (n - n_parameters) * inverse]
        others += [_long_run(influence * residual[:, None], lengths)] if coloured else []
        for other in others:
            widen = np.sqrt(np.maximum(np.diag(best) / np.diag(other), 1.0))
            best = other * np.outer(widen, widen)
    return Known(best / np.outer(scale, scale), dof, coloured)


def _of_noise(
    residual: Floats,
    influence: Floats,
    lengths: Sequence[int],
    noises: Sequence[Noise],
    theta: Floats,
) -> tuple[Floats, Floats]:
    """Covariance by the spectrum of the noise and the steps of the converter, and its degrees of freedom."""
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
        size = next_fast_len(PADDING * len(columns), real=True)
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


def _waves(theta: Floats, q: float, mean_square: float) -> NDArray[np.complex128]:
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
    """
    k = np.arange(1, HARMONICS + 1 if q else 1)
    before = max(mean_square - q**2 / 12, 0.0)
    size = q / (np.pi * k) * np.exp(-2 * before * (np.pi * k / (q or 1.0)) ** 2)
    seen = size**2 / 2 > UNSEEN * mean_square
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
    rho = np.array([s[1:] @ s[:-1] / (s @ s) for s in scores.T]).clip(-0.999, 0.999)
    power = scores.var(axis=0) ** 2
    alpha = np.sum(power * 4 * rho**2 / ((1 - rho) ** 6 * (1 + rho) ** 2)) / np.sum(power / (1 - rho) ** 4)
    return int(np.ceil(1.1447 * (alpha * len(scores)) ** (1 / 3)))
