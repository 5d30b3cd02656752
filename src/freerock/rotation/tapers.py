"""Power of a stretch of samples, frequency by frequency, by sine tapers.

Riedel and Sidorenko 1995, doi:10.1109/78.365298. Their leakage falls with the fourth power of the
frequency, so that slow noise does not spill into fast.
"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft

from freerock.arrays import Floats

TAPERS = 3


def frequencies(n: int) -> Floats:
    """Frequencies [cycles per sample] of `tapered_power` of n samples, without zero and the highest."""
    size = next_fast_len(n, real=True)
    return np.asarray(np.arange(1, (size + 1) // 2) / size)


def tapered_power(values: Floats) -> Floats:
    """Power at `frequencies`, by sine tapers: of white noise it is the variance of a sample.

    Parameters
    ----------
    values : ndarray, shape (n_time,)
    """
    transform = tapered(values)
    return np.asarray(np.mean(transform.real**2 + transform.imag**2, axis=0))


@lru_cache(8)
def tapers(n: int) -> Floats:
    """Sine tapers, shape (TAPERS, n)."""
    order, sample = np.arange(1, TAPERS + 1)[:, None], np.arange(1, n + 1)
    return np.asarray(math.sqrt(2 / (n + 1)) * np.sin(np.pi / (n + 1) * order * sample))


def tapered(values: Floats) -> NDArray[np.complex128]:
    """Transforms of values under each taper, shape (..., TAPERS, n_frequencies)."""
    n = values.shape[-1]
    size = next_fast_len(n, real=True)
    return np.asarray(rfft(tapers(n) * values[..., None, :], size)[..., 1 : (size + 1) // 2])
