"""Whittle's likelihood of a residual under the noise that the sensor has at rest, and the criteria of it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft
from scipy.linalg.lapack import dtbtrs

from freerock.arrays import Floats
from freerock.identification.noise import SINGULAR, of_runs
from freerock.runs.noise import Indices, Noise, smoothed

SETTLED = 1e-3  # excess of an innovation's variance over that of a long run, below which there is none


@dataclass(frozen=True)
class Likelihood:
    """How likely a residual is as noise.

    Parameters
    ----------
    minus_two_log : float
        Minus twice the logarithm of the likelihood, but for a constant.
    effective : float
        Effective samples.
    step : ndarray, shape (n_parameters,)
        Of the fitted numbers to the end of least squares that are weighted by the spectrum.
    """

    minus_two_log: float
    effective: float
    step: Floats

    def criteria(self, n_parameters: int) -> tuple[float, float]:
        """Akaike's and the Bayesian information criterion of so many freed numbers."""
        return (
            self.minus_two_log + 2 * n_parameters,
            self.minus_two_log + math.log(self.effective) * n_parameters,
        )


def likelihood(
    residual: Floats, jacobian: Floats, lengths: Sequence[int], noises: Sequence[Noise | None]
) -> Likelihood:
    """Whittle's likelihood of a residual under the noise at rest.

    The level of the noise in each band is known from the rest with its degrees of freedom ν, and integrated
    out: Σ (ν + n) ln((ν s + q)/(ν + n)), with n the real numbers that the band holds, s the ratio of
    `Noise`, q the power of the residual over the law (Whittle 1953, doi:10.1007/BF02590998; Student's
    distribution of a scale that was measured). Where no rest was seen the noise is white and its level that
    of the residual: n ln(Σe²/n).

    Least squares weigh all frequencies alike, so that slow noise moves their end away from that of the
    likelihood. One step of least squares weighted by the spectrum, from the derivatives, makes up for it.

    Effective are (ΣS)²/ΣS² of the averaged samples (`Noise`), with S the spectral density: as many
    independent ones would give the variance of the noise as well (Bayley and Hammersley 1946,
    doi:10.2307/2983560).

    Parameters
    ----------
    residual, jacobian, lengths :
        As for `against_rest`, without the columns of parameters held at a bound.
    noises : sequence of Noise or None
        At rest, of each run; None where none was seen.

    Returns
    -------
    Likelihood
    """
    scale = np.sqrt(np.mean(jacobian**2, axis=0)) + np.finfo(float).tiny
    columns = of_runs(np.column_stack([jacobian / scale, residual]), lengths, noises)
    runs = [_Whitened.of(own, noise) for own, noise in zip(columns, noises, strict=True)]
    weighted = np.concatenate([each.values / np.sqrt(each.ratio)[:, None] for each in runs])
    step = np.linalg.lstsq(weighted[:, :-1], weighted[:, -1], rcond=SINGULAR)[0]
    values = (
        sum(each.minus_two_log(each.values @ np.append(-share * step, 1.0)) for each in runs)
        for share in (0.0, 1.0)
    )
    return Likelihood(min(values), sum(each.effective for each in runs), -step / scale)


@dataclass(frozen=True)
class _Whitened:
    """Columns of one run as they are where the law of the noise is taken out, transformed to frequencies.

    Parameters
    ----------
    values : ndarray, shape (n_time, n_columns)
        As many real numbers as there are samples.
    band : ndarray of int, shape (n_time,)
        Band of each.
    ratio : ndarray, shape (n_time,)
        Density of the noise that is left, by the ratio of its band.
    noise : Noise or None
    logarithms : float
        Sum of the logarithms of the variances that were taken out.
    effective : float
        Effective samples.
    """

    values: Floats
    band: Indices
    ratio: Floats
    noise: Noise | None
    logarithms: float
    effective: float

    @classmethod
    def of(cls, columns: Floats, noise: Noise | None) -> "_Whitened":
        n = len(columns)
        frequency = _frequencies(n)
        if noise is None or not noise.white + noise.slow > 0:
            band = np.zeros(n, np.intp)
            return cls(_transformed(columns), band, np.ones(n), None, 0.0, float(n))
        density, band = noise.density(np.maximum(frequency, 1 / n)), noise.band(frequency)
        innovations, logarithms = _innovations(columns, noise)
        effective = float(density.sum() ** 2 / (density @ density))
        return cls(_transformed(innovations), band, noise.ratio[band], noise, logarithms, effective)

    def minus_two_log(self, residual: Floats) -> float:
        """Minus twice the logarithm of the likelihood of a residual, transformed as the columns are."""
        power, n = residual**2, len(residual)
        if self.noise is None:
            return float(n * np.log(power.sum() / n))
        n_bands, dof = len(self.noise.ratio), self.noise.dof
        number = np.bincount(self.band, minlength=n_bands) + dof
        known = np.bincount(self.band, power, n_bands) + dof * self.noise.ratio
        return float(number @ np.log(known / number)) + self.logarithms


def _innovations(columns: Floats, noise: Noise) -> tuple[Floats, float]:
    """What the law of the noise does not foretell of each sample, over its standard deviation.

    Noise of the law is an ARMA(1,1) process; its innovations are exact from the first sample (Brockwell and
    Davis 1991, example 5.3.3), so that the ends of a run are not taken for neighbours.

    Returns
    -------
    innovations : ndarray, shape (n_time, n_columns)
    logarithms : float
        Sum of the logarithms of their variances.
    """
    n, phi = len(columns), math.exp(-2 * math.pi * noise.corner)
    slow, less = noise.slow * (1 - phi) ** 2, smoothed(noise.averaged) / 2
    # white (1 - 2 φ cos ω + φ²) + slow (1 - less + less cos ω) = variance (1 + 2 θ cos ω + θ²)
    middle, side = noise.white * (1 + phi**2) + slow * (1 - less), noise.white * phi - slow * less / 2
    variance = (middle + math.sqrt(max(middle**2 - 4 * side**2, 0.0))) / 2
    theta = -side / variance
    r = [(1 + 2 * theta * phi + theta**2) / (1 - phi**2)]
    while r[-1] > 1 + SETTLED and len(r) < n:
        r.append(1 + theta**2 - theta**2 / r[-1])
    differences = columns.copy()
    differences[1:] -= phi * columns[:-1]
    bands = np.array([np.ones(n), np.full(n, theta)])
    bands[1, : len(r) - 1] /= r[:-1]
    differences = dtbtrs(bands, differences, uplo="L", diag="U")[0]
    differences[: len(r)] /= np.sqrt(r)[:, None]
    return differences / math.sqrt(variance), n * math.log(variance) + float(np.sum(np.log(r)))


def _transformed(values: Floats) -> Floats:
    """Orthonormal transform of real numbers along the first axis, as many as there are samples."""
    n = len(values)
    transform = rfft(values, axis=0, norm="ortho")
    twice = transform[1 : (n + 1) // 2] * np.sqrt(2)
    alone = [transform[:1].real, *([transform[-1:].real] if n % 2 == 0 else [])]
    return np.concatenate([*alone, twice.real, twice.imag])


def _frequencies(n: int) -> Floats:
    """Frequency of each number of `_transformed` [cycles per sample]."""
    frequency = np.fft.rfftfreq(n)
    twice = frequency[1 : (n + 1) // 2]
    alone = [frequency[:1], *([frequency[-1:]] if n % 2 == 0 else [])]
    return np.concatenate([*alone, twice, twice])
