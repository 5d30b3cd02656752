"""Covariance of least-squares parameters, where the noise is white and where it is coloured."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.fft import next_fast_len
from scipy.signal import fftconvolve

from freerock.arrays import Floats
from freerock.runs.noise import fit_law, slow_and_white

PADDING = 4  # times the length of a run, so that slow noise does not wrap around
LINE = 30.0  # times the median of its neighbours, above which the power at a frequency is a line
SINGULAR = 1e13  # condition of the scaled normal matrix beyond which the data do not separate the parameters


def covariance(residual: Floats, jacobian: Floats, lengths: Sequence[int]) -> tuple[Floats, bool]:
    """Covariance of the least-squares estimate, and whether the residual is coloured.

    White residual: s²(JᵀJ)⁻¹. Coloured residual (lag-one correlation beyond four standard errors): sandwich
    (JᵀJ)⁻¹ S (JᵀJ)⁻¹, with S in two ways, of which the larger variance counts. S = JᵀΓJ takes the noise for
    stationary, white with a slow part; Γ is that of the spectrum fitted to the residual (`noise_spectrum`).
    The Bartlett-weighted long-run covariance of the scores J_i e_i, bandwidth by Andrews (1991),
    doi:10.2307/2938229, assumes nothing, but needs runs much longer than the correlation time of the noise.

    Parameters
    ----------
    residual : ndarray, shape (n_time,)
        Of all runs, one after the other.
    jacobian : ndarray, shape (n_time, n_parameters)
    lengths : sequence of int
        Samples of each run.

    Returns
    -------
    covariance : ndarray, shape (n_parameters, n_parameters)
        NaN where the samples do not separate the parameters.
    coloured : bool
    """
    n, n_parameters = jacobian.shape
    scale = np.sqrt(np.mean(jacobian**2, axis=0))
    if not (n_parameters and np.all(scale > 0)):
        return np.full((n_parameters, n_parameters), np.nan), False
    jacobian = jacobian / scale
    normal = jacobian.T @ jacobian
    if not np.linalg.cond(normal) < SINGULAR:
        return np.full((n_parameters, n_parameters), np.nan), False
    inverse = np.linalg.inv(normal)
    best = residual @ residual / (n - n_parameters) * inverse
    centred = residual - residual.mean()
    correlation = centred[1:] @ centred[:-1] / (centred @ centred)
    coloured = bool(abs(correlation) > 4 / np.sqrt(n))
    if coloured:
        for inner in (
            _stationary(jacobian, residual, lengths),
            _long_run(jacobian * residual[:, None], lengths),
        ):
            sandwich = inverse @ inner @ inverse
            widen = np.sqrt(np.maximum(np.diag(best) / np.diag(sandwich), 1.0))
            best = sandwich * np.outer(widen, widen)
    return best / np.outer(scale, scale), coloured


def noise_spectrum(noise: Floats) -> Callable[[Floats], Floats]:
    """Spectral density of white noise with a slow part (`freerock.runs.noise.fit_law`).

    Lines, such as mains interference, are left out.

    Parameters
    ----------
    noise : ndarray, shape (n_time,)
        Equally spaced.

    Returns
    -------
    callable
        The density at frequencies in cycles per sample; it is the variance per sample where the noise is
        white.
    """
    n = len(noise)
    power = np.abs(np.fft.rfft(noise)[1 : (n + 1) // 2]) ** 2 / n
    law = fit_law(np.arange(1, len(power) + 1) / n, power, n, LINE)
    return lambda f: slow_and_white(f, *law)


def _stationary(jacobian: Floats, residual: Floats, lengths: Sequence[int]) -> Floats:
    """JᵀΓJ for noise of the residual's spectrum, shape (n_parameters, n_parameters)."""
    inner = np.zeros((jacobian.shape[1],) * 2)
    ends = np.cumsum(lengths)[:-1]
    for columns, noise in zip(np.split(jacobian, ends), np.split(residual, ends), strict=True):
        size = next_fast_len(PADDING * len(noise), real=True)
        transform = np.fft.rfft(columns, size, axis=0)
        power = noise_spectrum(noise)(np.asarray(np.fft.rfftfreq(size), np.float64))
        power[1:-1] *= 2
        inner += np.real(np.conj(transform).T @ (power[:, None] * transform)) / size
    return inner


def _long_run(scores: Floats, lengths: Sequence[int]) -> Floats:
    """Bartlett-weighted long-run covariance of the scores, shape (n_parameters, n_parameters)."""
    bandwidth = _andrews_bandwidth(scores)
    inner = np.zeros((scores.shape[1],) * 2)
    for run in np.split(scores, np.cumsum(lengths)[:-1]):
        lags = np.arange(-min(bandwidth, len(run) // 3), min(bandwidth, len(run) // 3) + 1)
        weights = 1 - np.abs(lags) / (lags[-1] + 1)
        inner += run.T @ fftconvolve(run, weights[:, None], mode="same", axes=0)
    return inner


def _andrews_bandwidth(scores: Floats) -> int:
    rho = np.array([s[1:] @ s[:-1] / (s @ s) for s in scores.T]).clip(-0.999, 0.999)
    power = scores.var(axis=0) ** 2
    alpha = np.sum(power * 4 * rho**2 / ((1 - rho) ** 6 * (1 + rho) ** 2)) / np.sum(power / (1 - rho) ** 4)
    return int(np.ceil(1.1447 * (alpha * len(scores)) ** (1 / 3)))
