"""Noise of θ at rest: its spectrum, how uncertain that is, and what it does to weighted sums of θ.

A spectral model, white noise plus a first-order autoregressive part, describes the spectrum and extends it
below the lowest frequency that a rest resolves. The ratio of measured power to that of the model, octave by
octave, contains all else: mains lines, other colours, the converter. `rotation_noise` finds it in a
record; σ of a sample is that of `signal_noise`. A mean or a least-squares fit is such a sum.

Power is measured by sine tapers (Riedel and Sidorenko 1995, doi:10.1109/78.365298). Their leakage falls with
the fourth power of the frequency, so that slow noise does not spill into fast.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import ndtri, stdtrit

from freerock.arrays import Floats, Indices

TAPERS = 3
LEAST_RATE_HZ = 400.0  # after averaging: what is faster says nothing of a rocking block
EFFICIENCY = 1 / (1 + 1 / (2 * TAPERS))  # share of the degrees of freedom that the tapers leave
VARIANCE_STEPS = 4096  # frequencies at which a density is summed
OCTAVE = 0.7  # of its upper end: the middle of an octave
QUANTILE = 0.975  # of the intervals that are stated
LEAST = 1e-9  # of the variance: its white part
OCTAVES = 8  # below half the sampling rate, where there is no rest
CERTAIN = 1e9  # degrees of freedom of what is given and not measured
SLOWEST = 0.15  # times one over the length of a stretch: the lowest corner of the slow part
FARTHEST = 30.0  # logarithm of a density over that of the fastest noise
GROUPS = 80  # of frequencies, which are looked at together
ROUNDED = 0.15  # share of the rounding in σ² by which σ² may be off; set on converter steps of 10 σ


@dataclass(frozen=True, eq=False)
class Noise:
    """Spectral density of the noise of θ, over frequencies in cycles per sample.

    Samples are means of `averaged` measured ones, times the root of that number, so that white noise keeps
    its variance. The density is that of `slow_and_white`, about white + slow / (1 + (f/corner)²), times the
    ratio of the band in which f lies. It is the variance per sample where the noise is white.

    Parameters
    ----------
    white, slow : float
        Densities [rad²].
    corner : float
        [cycles per sample].
    edges : ndarray, shape (n_bands + 1,)
        Of octaves from 0 to 0.5 [cycles per sample]; the lowest band holds all that is slower.
    ratio : ndarray, shape (n_bands,)
        Measured power over that of the law.
    dof : ndarray, shape (n_bands,)
        Degrees of freedom of the ratio.
    averaged : int
        How many measured samples make one.
    rate_hz : float
        Samples per second, after averaging.
    step : float
        Of the converter [rad]; 0 where it is too fine to be seen.
    """

    white: float
    slow: float
    corner: float
    edges: Floats
    ratio: Floats
    dof: Floats
    averaged: int
    rate_hz: float
    step: float = 0.0

    def density(self, frequency: Floats) -> Floats:
        """Spectral density [rad²] at frequencies in cycles per sample."""
        law = slow_and_white(frequency, self.white, self.slow, self.corner, self.averaged)
        return np.asarray(law * self.ratio[self.band(frequency)])

    def band(self, frequency: Floats) -> Indices:
        """Number of the band in which each frequency lies."""
        return np.clip(np.searchsorted(self.edges, frequency, "right") - 1, 0, len(self.ratio) - 1)

    def spectrum(self) -> tuple[Floats, Floats]:
        """Middle of each octave [Hz], and the one-sided spectral density of θ there [rad²/Hz]."""
        middle = OCTAVE * self.edges[1:]
        return middle * self.rate_hz, 2 * self.density(middle) / (self.averaged * self.rate_hz)

    @property
    def variance(self) -> float:
        """Of a sample that is not averaged [rad²]."""
        frequency = np.arange(0.5, VARIANCE_STEPS) / (2 * VARIANCE_STEPS)
        slow = float(np.mean(self.density(frequency))) - self.white
        return self.white + max(slow, 0.0) / self.averaged

    @property
    def stuck(self) -> float:
        """Mean square of the quantisation error that a resting block does not show, of noise over σ.

        Its first harmonic over the place between two steps (Widrow and Kollár 2008,
        doi:10.1017/CBO9780511754661). σ holds the error of rounding. A rest shows more or less of it, so that
        what σ holds besides is known to `ROUNDED` of it.
        """
        if not self.step:
            return 0.0
        rounding = self.step**2 / 12
        before = max(1 - (1 + ROUNDED) * rounding, 0.0)
        first: float = self.step / math.pi * math.exp(-2 * before * (math.pi / self.step) ** 2)
        return min(first**2 / 2, rounding)

    def wander(self, apart: float, together: float) -> float:
        """Mean square of the difference of two levels beyond what a rest shows [rad²].

        Each is of so many samples together, so many apart. Where the density grows towards the lowest octave,
        and where beyond its law, it goes on as that of 1/f noise, A/f: 2A (ln(apart/together) + 1.5).
        """
        if len(self.ratio) < 4:
            return 0.0
        lowest = OCTAVE * float(self.edges[1])
        density = (self.density(lowest * np.array([1.0, 4.0])) - self.white).tolist()
        exponents = [  # by which what is low falls to what is high two octaves above
            min(math.log(low / high) / math.log(4.0), 1.0) if high > 0 else 1.0
            for low, high in (density, self.ratio[[0, 2]].tolist())
            if low > max(high, 0.0)
        ]
        grows = max(exponents, default=0.0)
        a: float = 2 * grows * max(density[0], 0.0) / self.averaged * lowest * unsure(self.dof[0]) ** 2
        return 2 * a * (math.log(max(apart / together, 1.0)) + 1.5)

    def by_law(self, place: Indices) -> Floats:
        """Covariance of means of `averaged` samples at some places, by the model alone [rad²], (n, n)."""
        kept = math.exp(-2 * math.pi * self.corner)
        slow = self.slow * (1 - kept) / (1 + kept)
        white = max(self.white, LEAST * (slow + self.white))
        apart = np.abs(np.subtract.outer(place, place))
        return np.asarray(slow * kept**apart + white * np.eye(place.size)) / self.averaged

    def scaled(self, factor: float) -> "Noise":
        """The same noise with its standard deviation times a factor."""
        white, slow = factor**2 * self.white, factor**2 * self.slow
        return replace(self, white=white, slow=slow, step=factor * self.step)


def unsure(dof: float) -> float:
    """Student's over the normal quantile of what is known with so many degrees of freedom."""
    return float(stdtrit(max(dof, 1.0), QUANTILE) / ndtri(QUANTILE))


def white_noise(
    sigma_theta: float, rate_hz: float, n_bands: int = OCTAVES + 1, dof: float = CERTAIN
) -> Noise:
    """White noise of a standard deviation [rad], of samples at a rate [Hz]; taken as known, or with a dof."""
    edges = np.append(0.0, 0.5 ** np.arange(n_bands, 0, -1))
    m = samples_averaged(rate_hz)
    ratio, known = np.ones(n_bands), np.full(n_bands, dof)
    return Noise(sigma_theta**2, 0.0, 0.5, edges, ratio, known, m, rate_hz / m)


def samples_averaged(rate_hz: float) -> int:
    """How many samples at a rate are averaged into one: a power of two."""
    return int(2 ** max(0, math.floor(math.log2(rate_hz / LEAST_RATE_HZ))))


def averaged(values: Floats, m: int) -> Floats:
    """Means of m samples along the first axis, times √m: white noise keeps its variance."""
    if m == 1:
        return values
    whole = values[: len(values) // m * m]
    if values.ndim == 1:
        return np.asarray(math.sqrt(m) * whole.reshape(-1, m).mean(axis=1))
    return np.asarray(math.sqrt(m) * (sum(whole[i::m] for i in range(m)) / m))  # its means would be slower


def expected_power(noise: Noise, n: int) -> Floats:
    """What `tapered_power` of n samples of noise is on average [rad²]."""
    window = np.mean(np.abs(rfft(tapers(n), 2 * n)) ** 2, axis=0)
    of_tapers = irfft(window, 2 * n)[:n]  # their autocovariance
    size = next_fast_len(n, real=True)
    return round_a_circle(autocovariance(noise, n) * of_tapers, size)[1 : (size + 1) // 2]


def round_a_circle(lags: Floats, size: int) -> Floats:
    """Transform of covariances at lags from 0 on, laid round a circle of so many samples both ways."""
    around = np.zeros(size)
    around[: len(lags)] += lags
    around[size - len(lags) + 1 :] += lags[:0:-1]
    return np.asarray(rfft(around).real)


def degrees_of_freedom(band: Indices, taken: Floats, n: int, n_bands: int) -> Floats:
    """Degrees of freedom of the mean power in each band, of n samples of which a fit has taken a share."""
    each = n / next_fast_len(n, real=True) * EFFICIENCY
    return np.asarray(each * np.maximum(np.bincount(band, 2 - 2 * taken, n_bands), 0.0))


@lru_cache(16)
def autocovariance(noise: Noise, n: int) -> Floats:
    """Of noise at lags of 0 to n - 1 of its samples [rad²], shape (n,)."""
    size = 4 * n  # so that slow noise does not wrap around
    whole = irfft(noise.density(np.arange(size // 2 + 1) / size), size)
    return np.asarray(whole[:n].copy())  # without the rest, which is kept as long


def slow_and_white(frequency: Floats, white: float, slow: float, corner: float, m: int = 1) -> Floats:
    """Density of white noise with a slow part, which is autoregressive of the first order.

    Frequencies and the corner in cycles per sample, each of which is the mean of m measured ones, times √m.
    Of a random walk means have the share 1 - 2/3 (1 - 1/m²) sin²πf of the density that it has when it is only
    looked at as often: its increments have the variance (2m² + 1)/3m² and the neighbours' covariance
    (m² - 1)/6m² (Working 1960, doi:10.2307/1907574).
    """
    squared, away = np.sin(np.pi * frequency) ** 2, -math.expm1(-2 * math.pi * corner)
    beyond = 1 + 4 * (1 - away) * squared / away**2  # by what the slow part falls beyond its corner
    return np.asarray(white + slow * (1 - 2 / 3 * (1 - 1 / m**2) * squared) / beyond)


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
    medians = [np.median(each) for each in np.split(power, edges[1:-1])]
    kept = power <= line * np.repeat(medians, np.diff(edges))
    number = np.add.reduceat(kept, edges[:-1], dtype=int)
    power, frequency = (np.add.reduceat(each * kept, edges[:-1]) / number for each in (power, frequency))
    level, weight = float(power[-1]), number.astype(float)
    low, high = np.array([(-FARTHEST, -FARTHEST, np.log(SLOWEST / n)), (FARTHEST, FARTHEST, 0)])

    def misfit(x: Floats) -> float:
        white, slow, corner = np.exp(np.clip(x, low, high)).tolist()
        expected = slow_and_white(frequency, level * white, level * slow, corner, m)
        return float(weight @ (np.log(expected) + power / expected))

    starts = [
        np.array([0.0, np.log(ratio), np.log(f_0)])
        for ratio in (1.0, 100.0)
        for f_0 in (2 / n, 20 / n, 200 / n)
    ]
    best = min(starts, key=misfit)
    simplex = np.vstack([best, best - np.eye(3)])  # SciPy's own hardly moves a number that starts at zero
    options = {"maxiter": 400, "xatol": 1e-2, "fatol": 1e-1, "initial_simplex": simplex}
    found = minimize(misfit, best, method="Nelder-Mead", options=options).x
    white, slow, corner = np.exp(np.clip(found, low, high)).tolist()
    return level * white, level * slow, corner


def tapered_power(values: Floats) -> tuple[Floats, Floats]:
    """Frequencies without zero and the highest, and the power there by sine tapers.

    Parameters
    ----------
    values : ndarray, shape (n_time,)

    Returns
    -------
    frequency : ndarray, shape (n_frequencies,)
        [cycles per sample].
    power : ndarray, shape (n_frequencies,)
        Of white noise it is the variance of a sample.
    """
    transform, size = tapered(values), next_fast_len(len(values), real=True)
    power = np.mean(transform.real**2 + transform.imag**2, axis=0)
    return np.arange(1, (size + 1) // 2) / size, np.asarray(power)


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
    around = round_a_circle(autocovariance(noise, -(-n // LAGS) * LAGS)[:n] / noise.averaged, size)
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
    known = autocovariance(noise, -(-(n + 1) // LAGS) * LAGS)[: n + 1]
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
