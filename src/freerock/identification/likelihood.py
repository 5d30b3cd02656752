"""Whittle's likelihood of a residual under the noise at rest, and information criteria."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.fft import rfft
from scipy.linalg.lapack import dtbtrs

from freerock.arrays import Floats, Indices
from freerock.identification.against_noise import NO_TRACE, of_runs
from freerock.noise.spectrum import Noise, smoothed


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


class Whitened:
    """A residual and derivatives as they are where the law of the noise is taken out, and their likelihood.

    That is Whittle's of a residual under the noise at rest. The level of the noise in each band is known from
    the rest with its degrees of freedom ν, and integrated out: Σ (ν + n) ln((ν s + q)/(ν + n)), with n the
    real numbers that the band holds, s the ratio of `Noise`, q the power of the residual over the law
    (Whittle 1953, doi:10.1007/BF02590998; Student's distribution of a scale that was measured). Where no rest
    was seen the noise is white and its level that of the residual: n ln(Σe²/n).

    Least squares weigh all frequencies alike, so that slow noise moves their end away from that of the
    likelihood. One step of least squares weighted by the spectrum, from the derivatives, corrects for that.

    Effective are (ΣS)²/ΣS² of the averaged samples (`Noise`), with S the spectral density: as many
    independent ones would give the variance of the noise as well (Bayley and Hammersley 1946,
    doi:10.2307/2983560).

    Parameters
    ----------
    residual, jacobian, lengths :
        As for `against_rest`, without the columns of parameters held at a bound.
    noises : sequence of Noise or None
        At rest, of each run; None where none was seen.
    prior : (ndarray, ndarray), optional
        Rows of unit variance beside the samples: their values, shape (n_rows,), and their derivatives, shape
        (n_rows, n_parameters).
    level : float
        Standard deviation of a sample where no noise takes it out [rad].
    """

    def __init__(
        self,
        residual: Floats,
        jacobian: Floats,
        lengths: Sequence[int],
        noises: Sequence[Noise | None],
        prior: tuple[Floats, Floats] | None = None,
        level: float = 1.0,
    ) -> None:
        self._lengths, self._noises, self._level = lengths, noises, level
        self._prior = prior or (np.empty(0), np.empty((0, jacobian.shape[1])))
        scale = np.sqrt(np.mean(jacobian**2, axis=0)) + np.finfo(float).tiny
        columns = of_runs(np.column_stack([residual, jacobian / scale]), lengths, noises)
        self._runs = [_Spectrum.of(len(own), noise) for own, noise in zip(columns, noises, strict=True)]
        self._scale, self._values = scale, self._taken_out(columns)

    @property
    def rows(self) -> Floats:
        """Residual and derivatives side by side, over real numbers of unit variance, without the priors."""
        unscaled = np.append(1.0, self._scale)
        return np.asarray(np.concatenate([*map(self._weighted, self._both(self._values))]) * unscaled)

    def _both(self, values: Sequence[Floats]) -> "list[tuple[_Spectrum, Floats]]":
        return list(zip(self._runs, values, strict=True))

    def _weighted(self, both: "tuple[_Spectrum, Floats]") -> Floats:
        run, own = both
        level = 1.0 if run.innovations else self._level
        return np.asarray(own / (level * np.sqrt(run.ratio)[:, None]))

    def likelihood(self) -> Likelihood:
        """Of the residual, with these derivatives."""
        return self._likelihood(self._values, self._scale)

    def adding(self, column: Floats) -> Likelihood:
        """The same with one derivative more, shape (n_time,)."""
        scale = np.sqrt(np.mean(column**2)) + np.finfo(float).tiny
        columns = of_runs(column[:, None] / scale, self._lengths, self._noises)
        both = zip(self._values, self._taken_out(columns), strict=True)
        return self._likelihood([np.hstack(each) for each in both], np.append(self._scale, scale))

    def _taken_out(self, columns: Sequence[Floats]) -> list[Floats]:
        return [run.taken_out(own) for run, own in zip(self._runs, columns, strict=True)]

    def _likelihood(self, values: Sequence[Floats], scale: Floats) -> Likelihood:
        both, (prior, rows) = self._both(values), self._prior
        rows = np.hstack([rows, np.zeros((len(rows), len(scale) - rows.shape[1]))]) / scale
        weighted = np.concatenate([*map(self._weighted, both), np.column_stack([prior, rows])])
        step = np.linalg.lstsq(weighted[:, 1:], weighted[:, 0], rcond=NO_TRACE)[0]
        least = min(
            sum(run.minus_two_log(own @ np.append(1.0, -share * step)) for run, own in both)
            + float(np.sum((prior - share * rows @ step) ** 2))
            for share in (0.0, 1.0)
        )
        return Likelihood(least, sum(run.effective for run in self._runs), -step / scale)


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """The noise of one run, over the real numbers into which its samples are transformed.

    Parameters
    ----------
    band : ndarray of int, shape (n_time,)
        Band of each.
    ratio : ndarray, shape (n_time,)
        Density of the noise that is left where its law is taken out, by the ratio of its band.
    noise : Noise or None
        None where it is white, of any level.
    innovations : _Innovations or None
        How the law is taken out.
    effective : float
        Effective samples.
    """

    band: Indices
    ratio: Floats
    noise: Noise | None
    innovations: "_Innovations | None"
    effective: float

    @classmethod
    def of(cls, n: int, noise: Noise | None) -> "_Spectrum":
        if noise is None or not noise.white + noise.slow > 0:
            return cls(np.zeros(n, np.intp), np.ones(n), None, None, float(n))
        frequency = _frequencies(n)
        density, band = noise.density(np.maximum(frequency, 1 / n)), noise.band(frequency)
        effective = float(density.sum() ** 2 / (density @ density))
        return cls(band, noise.ratio[band], noise, _Innovations.of(n, noise), effective)

    def taken_out(self, columns: Floats) -> Floats:
        """Columns of the run without the law of its noise, transformed: as many real numbers as samples."""
        return _transformed(self.innovations.of_columns(columns) if self.innovations else columns)

    def minus_two_log(self, residual: Floats) -> float:
        """Minus twice the logarithm of the likelihood of a residual, transformed as the columns are."""
        power, n = residual**2, len(residual)
        if self.noise is None or self.innovations is None:
            return float(n * np.log(power.sum() / n))
        n_bands, dof = len(self.noise.ratio), self.noise.dof
        number = np.bincount(self.band, minlength=n_bands) + dof
        known = np.bincount(self.band, power, n_bands) + dof * self.noise.ratio
        return float(number @ np.log(known / number)) + self.innovations.logarithms


class _Innovations(NamedTuple):
    """What the law of the noise does not foretell of each sample, over its standard deviation.

    Noise of the law is an ARMA(1,1) process; its innovations are exact from the first sample (Brockwell and
    Davis 1991, example 5.3.3), so that the ends of a run are not taken for neighbours.

    Parameters
    ----------
    phi, theta : float
        Of the process.
    variance : float
        Of the innovations of a long run [rad²].
    settling : ndarray
        That of the first innovations over it.
    logarithms : float
        Sum of the logarithms of the variances.
    """

    phi: float
    theta: float
    variance: float
    settling: Floats
    logarithms: float

    @classmethod
    def of(cls, n: int, noise: Noise, settled: float = 1e-3) -> "_Innovations":
        """Of n samples, exact but for an excess of the variance over that of a long run below `settled`."""
        phi = math.exp(-2 * math.pi * noise.corner)
        slow, less = noise.slow * (1 - phi) ** 2, smoothed(noise.averaged) / 2
        # white (1 - 2 φ cos ω + φ²) + slow (1 - less + less cos ω) = variance (1 + 2 θ cos ω + θ²)
        middle, side = noise.white * (1 + phi**2) + slow * (1 - less), noise.white * phi - slow * less / 2
        variance = (middle + math.sqrt(max(middle**2 - 4 * side**2, 0.0))) / 2
        theta = -side / variance
        r = [(1 + 2 * theta * phi + theta**2) / (1 - phi**2)]
        while r[-1] > 1 + settled and len(r) < n:
            r.append(1 + theta**2 - theta**2 / r[-1])
        logarithms = n * math.log(variance) + float(np.sum(np.log(r)))
        return cls(phi, theta, variance, np.array(r), logarithms)

    def of_columns(self, columns: Floats) -> Floats:
        """Of the samples in columns, shape (n_time, n_columns)."""
        n, r = len(columns), self.settling
        differences = columns.copy()
        differences[1:] -= self.phi * columns[:-1]
        bands = np.array([np.ones(n), np.full(n, self.theta)])
        bands[1, : len(r) - 1] /= r[:-1]
        differences = dtbtrs(bands, differences, uplo="L", diag="U")[0]
        differences[: len(r)] /= np.sqrt(r)[:, None]
        return np.asarray(differences / math.sqrt(self.variance))


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
