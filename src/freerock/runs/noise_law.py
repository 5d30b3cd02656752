"""Law of the noise of a sensor, white noise with a slow part, and how it is found from a measured power."""

import math

import numpy as np

from freerock.arrays import Floats, Indices

SLOWEST = 0.15  # times one over the length of a stretch: the lowest corner of the slow part
FARTHEST = 30.0  # logarithm of a density over that of the fastest noise
GROUPS = 80  # of frequencies, which are looked at together


def slow_and_white(frequency: Floats, white: float, slow: float, corner: float, m: int = 1) -> Floats:
    """Density of white noise with a slow part, which is autoregressive of the first order.

    Frequencies and the corner in cycles per sample, each of which is the mean of m measured ones, times √m.
    """
    squared = np.sin(np.pi * frequency) ** 2
    return np.asarray(white + slow * (1 - smoothed(m) * squared) / _rise(squared, corner))


def _rise(squared: Floats, corner: float) -> Floats:
    """By what the slow part falls beyond its corner, of sin²πf."""
    away = -math.expm1(-2 * math.pi * corner)
    return 1 + 4 * (1 - away) * squared / away**2


def smoothed(m: int) -> float:
    """What means of m samples lack of the power of slow noise at half their rate.

    Of a random walk they have the share 1 - 2/3 (1 - 1/m²) sin²πf of the density that it has when it is only
    looked at as often: its increments have the variance (2m² + 1)/3m² and the neighbours' covariance
    (m² - 1)/6m² (Working 1960, doi:10.2307/1907574).
    """
    return 2 / 3 * (1 - 1 / m**2)


def fit_law(frequency: Floats, power: Floats, n: int, line: float, m: int = 1) -> tuple[float, float, float]:
    """White, slow and corner of `slow_and_white`, by Whittle's likelihood of a measured power.

    Whittle 1953, doi:10.1007/BF02590998.

    Parameters
    ----------
    frequency, power : ndarray, shape (n_frequencies,)
        Frequencies in cycles per sample.
    n : int
        Samples of the longest stretch: what is slower is not known, and would grow without bounds.
    line : float
        Power over the median of its neighbours, above which it is a line, such as that of the mains, and left
        out.
    m : int
        Samples averaged into one.
    """
    from scipy.optimize import minimize  # a fifth of a second, and most jobs only read what was found

    order = np.argsort(frequency)
    frequency, power = frequency[order], power[order]
    edges = np.unique(np.geomspace(1, len(power) + 1, GROUPS).astype(int)) - 1
    kept = power <= line * np.repeat(_medians(power, edges), np.diff(edges))
    number = np.add.reduceat(kept, edges[:-1], dtype=int)
    power, frequency = (np.add.reduceat(each * kept, edges[:-1]) / number for each in (power, frequency))
    squared, level = np.sin(np.pi * frequency) ** 2, float(power[-1])
    coarse, weight = 1 - smoothed(m) * squared, number.astype(float)
    low, high = np.array([(-FARTHEST, -FARTHEST, np.log(SLOWEST / n)), (FARTHEST, FARTHEST, 0)])

    def law(x: Floats) -> tuple[float, float, float]:
        a, b, f_0 = np.exp(np.minimum(np.maximum(x, low), high))
        return float(level * a), float(level * b), float(f_0)

    def misfit(x: Floats) -> float:
        white, slow, corner = law(x)
        expected = white + slow * coarse / _rise(squared, corner)
        return float(weight @ (np.log(expected) + power / expected))

    starts = [
        np.array([0.0, np.log(ratio), np.log(f_0)])
        for ratio in (1.0, 100.0)
        for f_0 in (2 / n, 20 / n, 200 / n)
    ]
    best = min(starts, key=misfit)
    simplex = np.vstack([best, best - np.eye(3)])  # SciPy's own hardly moves a number that starts at zero
    options = {"maxiter": 400, "xatol": 1e-2, "fatol": 1e-1, "initial_simplex": simplex}
    return law(minimize(misfit, best, method="Nelder-Mead", options=options).x)


def _medians(values: Floats, edges: Indices) -> Floats:
    """Of the groups of values between neighbouring edges."""
    group = np.repeat(np.arange(len(edges) - 1), np.diff(edges))
    ordered = values[np.lexsort((values, group))]
    first, size = edges[:-1], np.diff(edges)
    return np.asarray((ordered[first + (size - 1) // 2] + ordered[first + size // 2]) / 2)
