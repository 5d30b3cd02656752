"""Whether a residual agrees with the noise of the sensor at rest, and how likely it is as that noise."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import rfft, rfftfreq
from scipy.special import fdtrc

from freerock.arrays import Floats
from freerock.identification.significance_levels import RESIDUAL
from freerock.noise.spectrum import (
    Noise,
    degrees_of_freedom,
    expected_power,
    tapered,
    tapered_power,
)

LOUDER = 1.1  # times the noise at rest, up to which a residual is no model error: sensors differ that much
NO_TRACE = 1e-7  # of the largest singular value, below which a direction of the parameters leaves no trace


@dataclass(frozen=True)
class Goodness:
    """A residual beside the noise at rest, octave by octave.

    Parameters
    ----------
    agrees : bool
        Whether chance explains its power in each octave and in all.
    p : float
        Chance of noise as at rest, and a little louder (`LOUDER`), to leave as loud a residual in the most
        telling octave, or in all together; by Bonferroni's rule, at most 1.
    over_noise : float
        Root of the power of the residual over that of the noise, all octaves together.
    low_hz, high_hz : float
        Ends of the most telling octave [Hz].
    excess : ndarray, shape (n_bands,)
        Power of the residual over that of the noise in each octave of `Noise`, at least 1.
    """

    agrees: bool
    p: float
    over_noise: float
    low_hz: float
    high_hz: float
    excess: Floats


def goodness(residual: Floats, columns: Floats, noise: Noise) -> Goodness:
    """How a residual compares with the noise at rest.

    In each octave its power over that of the noise follows Fisher's F, with the degrees of freedom of both;
    what the fitted numbers take of the noise is accounted for, as the level of the residual is.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Averaged as the noise is [rad].
    columns : ndarray, shape (n, n_parameters)
        Derivatives by all that the run itself determines, averaged likewise.
    noise : Noise
    """
    n = len(residual)
    residual = residual - residual.mean()
    columns = np.column_stack([columns, np.ones(n)])
    scale = np.sqrt(np.mean(columns**2, axis=0))
    used = columns[:, scale > 0] / scale[scale > 0]
    values, vectors = np.linalg.eigh(used.T @ used)
    kept = values > NO_TRACE * values[-1:]
    basis = used @ (vectors[:, kept] / np.sqrt(values[kept]))  # orthonormal
    share = np.mean(np.sum(np.abs(tapered(basis.T)) ** 2, axis=0), axis=0)
    frequency, power = tapered_power(residual)
    band, n_bands = noise.band(frequency), len(noise.ratio)
    expected = expected_power(noise, n) * np.maximum(1 - share, 1e-3)
    dof = np.maximum(degrees_of_freedom(band, np.minimum(share, 1.0), n, n_bands), 1.0)
    some = np.flatnonzero(np.bincount(band, minlength=n_bands))
    part = np.bincount(band, expected, n_bands)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.bincount(band, power, n_bands) / part
    every = float(power.sum() / expected.sum())
    both = np.array([dof[some], noise.dof[some]])
    p = fdtrc(*both, ratio[some] / LOUDER**2)
    dof_of_all = 1 / np.sum((part[some] / part.sum()) ** 2 / both, axis=1)  # Welch and Satterthwaite
    p_of_all = float(fdtrc(*dof_of_all, every / LOUDER**2))
    worst = int(np.argmin(p))
    low_hz, high_hz = (float(each * noise.rate_hz) for each in noise.edges[some[worst] : some[worst] + 2])
    chance = min(1.0, (len(some) + 1) * min(float(p[worst]), p_of_all))
    excess = np.ones(n_bands)
    excess[some] = np.maximum(ratio[some], 1.0)
    return Goodness(chance > RESIDUAL, chance, math.sqrt(every), low_hz, high_hz, excess)


def louder(noise: Noise, found: Goodness) -> Noise:
    """The noise with what a residual that does not agree with it adds in each octave."""
    return noise if found.agrees else replace(noise, ratio=noise.ratio * found.excess)


def level_of(noise: Noise, columns: Floats) -> float:
    """Standard deviation of a sample [rad] that least squares of some derivatives meet.

    Least squares know a number by the power of the noise at the frequencies at which it moves the curve.

    Parameters
    ----------
    noise : Noise
    columns : ndarray, shape (n, n_parameters)
        Derivatives, averaged as the noise is; without any the level is that of one sample.
    """
    columns = columns if columns.size else np.eye(len(columns), 1)
    power = np.abs(rfft(columns, axis=0)) ** 2
    power /= np.maximum(power.sum(axis=0), np.finfo(float).tiny)
    return float(np.sqrt(np.mean(noise.density(rfftfreq(len(columns))) @ power)))


def minus_two_log(residual: Floats, noise: Noise) -> float:
    """Minus twice the logarithm of Whittle's likelihood of a residual, but for a constant.

    The level of the noise in each octave is known from the rest with its degrees of freedom ν, and integrated
    out: Σ (ν + n) ln(ν + q), with q the power of the residual over the density, n real numbers in the octave
    (Whittle 1953, doi:10.1007/BF02590998; Student's distribution of a scale that was measured).

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Averaged as the noise is [rad].
    noise : Noise
    """
    n = len(residual)
    transform = rfft(residual, norm="ortho")
    at = rfftfreq(n)
    twice = np.full(len(at), 2.0)
    twice[0] = 1.0
    if n % 2 == 0:
        twice[-1] = 1.0
    density = noise.density(np.maximum(at, 1 / n))
    band, n_bands = noise.band(at), len(noise.ratio)
    q = np.bincount(band, twice * np.abs(transform) ** 2 / density, n_bands)
    number, dof = np.bincount(band, twice, n_bands), noise.dof
    return float(twice @ np.log(density) + np.sum((number + dof) * np.log1p(q / dof)))


def through(noise: Noise, columns: Floats) -> Floats:
    """Columnsᵀ Σ columns, shape (n_parameters, n_parameters), Σ the covariance of the noise."""
    transform = rfft(columns, axis=0, norm="ortho")
    n, at = len(columns), rfftfreq(len(columns))
    twice = np.full(len(at), 2.0)
    twice[0] = 1.0
    if n % 2 == 0:
        twice[-1] = 1.0
    weighted = transform * (twice * noise.density(np.maximum(at, 1 / n)))[:, None]
    return np.asarray((transform.conj().T @ weighted).real)
