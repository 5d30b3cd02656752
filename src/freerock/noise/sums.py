"""Errors of weighted sums of θ, such as a mean or a least-squares fit, under the noise of a sensor."""

import math
from functools import lru_cache

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from freerock.arrays import Floats
from freerock.noise.spectrum import Noise, autocovariance, round_a_circle, unsure

LAGS = 128  # in steps of so many autocovariances are worked out


def covariance_of_sums(noise: Noise, weights: Floats) -> Floats:
    """Covariance of weighted sums of noise, shape (..., n_sums, n_sums) [rad²].

    The sums are of means of `averaged` samples that follow each other. A fit that is linear in its samples is
    such a sum.

    Parameters
    ----------
    noise : Noise
    weights : ndarray, shape (..., n_sums, n_means)
    """
    n = weights.shape[-1]
    size = next_fast_len(2 * n, real=True)
    around = round_a_circle(_lags(noise, n) / noise.averaged, size)
    through = irfft(around * rfft(weights, size), size)[..., :n]
    return np.asarray(through @ np.swapaxes(weights, -1, -2))


def covariance_of_means(noise: Noise, together: float, n: int) -> Floats:
    """Covariance of n means of so many samples each that follow each other, shape (n, n) [rad²]."""
    size = together / noise.averaged
    if size > 1:
        parts = np.arange(n * round(size)).reshape(n, -1)
        weights = np.zeros((n, parts.size))
        np.put_along_axis(weights, parts, 1 / parts.shape[1], axis=1)
        return covariance_of_sums(noise, weights)
    lags = np.arange(n) * size
    known = _lags(noise, n + 1)
    found = np.interp(lags, np.arange(n + 1), known) / noise.averaged
    found[0] += noise.white * (1 / together - 1 / noise.averaged)
    return np.asarray(found[np.abs(np.subtract.outer(np.arange(n), np.arange(n)))])


@lru_cache(64)
def stderr_of_mean(noise: Noise, n: int) -> float:
    """Standard error of the mean of n means of `averaged` samples [rad]."""
    weights = np.full(max(n, 1), 1 / max(n, 1))
    variance = float(covariance_of_sums(noise, weights[None])[0, 0])
    return math.sqrt(max(variance, 0.0)) * unsure_of_sum(noise, weights)


def unsure_of_sum(noise: Noise, weights: Floats) -> float:
    """Student's over the normal quantile of a weighted sum of noise, whose octaves are known as they are.

    Degrees of freedom by Welch and Satterthwaite (doi:10.2307/3002019).

    Parameters
    ----------
    noise : Noise
    weights : ndarray, shape (n_means,)
    """
    size = next_fast_len(2 * len(weights), real=True)
    frequency = np.arange(size // 2 + 1) / size
    power = np.abs(rfft(weights, size)) ** 2 * noise.density(frequency)
    parts = np.bincount(noise.band(frequency), power, len(noise.dof))
    spread = float(np.sum(parts**2 / np.maximum(noise.dof, 1.0)))
    return unsure(float(parts.sum()) ** 2 / spread) if spread > 0 else 1.0


def _lags(noise: Noise, n: int) -> Floats:
    """`autocovariance` at n lags, of lengths that are remembered."""
    return autocovariance(noise, -(-n // LAGS) * LAGS)[:n]
