"""Test whether a residual agrees with the noise of the sensor at rest."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import fdtrc, fdtri

from freerock.arrays import Complexes, Floats, Indices
from freerock.identification.significance_levels import RESIDUAL
from freerock.noise.at_rest import noise_at_rest
from freerock.noise.spectrum import (
    Noise,
    averaged,
    degrees_of_freedom,
    expected_power,
    filtered,
    frequencies,
    power_taken,
    share_taken,
    tapered,
    tapered_power,
    white_noise,
)
from freerock.runs.motion import Motion

NO_TRACE = 1e-7  # of the largest singular value, below which a direction of the parameters leaves no trace


@dataclass(frozen=True)
class Loudness:
    """How much louder than the noise at rest a residual may be; by judgement.

    Parameters
    ----------
    louder : float
        Times the noise, up to which a residual is no model error: sensors differ that much.
    loudest : float
        Times its power, from which a residual is no noise, however short the rest.
    hopeless : float
        Times its power: a quick fit beyond it tells that a full one won't do. Followed to its end it leaves
        0.8 to 1.23 under what explains the run (15 records of eleven kinds of laboratories); over the first
        swings a push or a tilt leaves more than 5.
    """

    louder: float = 1.1
    loudest: float = 1000.0
    hopeless: float = 30.0


LOUDNESS = Loudness()


@dataclass(frozen=True)
class AgainstRest:
    """A residual against the noise at rest.

    Parameters
    ----------
    p : float
        Chance of noise as at rest, and a little louder (`Loudness.louder`), to leave as loud a residual: that
        of the most telling band, of which one holds all frequencies, times the number of bands (Bonferroni),
        at most 1. 0 where the power of all frequencies is beyond `Loudness.loudest`.
    ratio : float
        Power of the residual over that at rest: in the most telling octave, where it alone tells enough.
    low_hz, high_hz : float
        Ends of that band [Hz].
    noises : tuple of Noise
        Of each run, with the level in each band that rest and residual show together.
    averages : Averages or None
        What was looked at.
    """

    p: float
    ratio: float
    low_hz: float
    high_hz: float
    noises: tuple[Noise, ...] = ()
    averages: "Averages | None" = None

    @property
    def is_noise(self) -> bool:
        """Whether the residual agrees with the noise."""
        return self.p > RESIDUAL


def noise_of(motion: Motion) -> Noise:
    """Noise of a motion at rest; where none was seen, white noise of its sigma_theta."""
    if motion.noise is not None:
        return motion.noise
    return white_noise(motion.sigma_theta, (len(motion.time_s) - 1) / float(np.ptp(motion.time_s)))


def least_mean_square(motion: Motion) -> float:
    """Mean square of a residual that is noise [rad²]: of that at rest, or of sigma_theta if it is more."""
    return max(motion.sigma_theta**2, noise_of(motion).variance)


def hopeless_from(motions: Sequence[Motion]) -> float:
    """Mean square of a quick fit [rad²] from which a full one won't do.

    `motions` are those that are fitted together.
    """
    return LOUDNESS.hopeless * max(noise_of(motion).variance for motion in motions)


def against_rest(
    residual: Floats, jacobian: Floats, lengths: Sequence[int], noises: Sequence[Noise]
) -> AgainstRest:
    """Whether a residual is the noise at rest, band by band: level and shape.

    In each band the power of the residual over that of the noise at rest follows Fisher's F, with the
    degrees of freedom of both; what the fitted parameters have taken of the noise is accounted for. So does
    the power of all bands, by the degrees of freedom of a sum (Welch and Satterthwaite, doi:10.2307/3002019):
    a rest tells little of the slowest noise, and more of all of it.

    Parameters
    ----------
    residual : ndarray, shape (n_time,)
        Of all runs, one after the other [rad].
    jacobian : ndarray, shape (n_time, n_parameters)
        Derivatives by the fitted numbers.
    lengths : sequence of int
        Samples of each run.
    noises : sequence of Noise
        At rest, of each run.
    """
    averages = Averages.of(residual, jacobian, lengths, noises)
    seen = _seen(averages, noises)
    found = [_bands(own) for own in seen]
    n = sum(map(len, found))
    octave, every = (
        min(bands, key=lambda band: (band.p, -band.ratio))
        for bands in ([band for run in found for band in run[:-1]], [run[-1] for run in found])
    )
    most = octave if n * octave.p <= RESIDUAL or octave.p <= every.p else every
    p, together = min(1.0, n * min(octave.p, every.p)), tuple(map(_together, seen))
    return replace(most, p=p, noises=together, averages=averages)


def noise_of_residual(
    residual: Floats,
    jacobian: Floats,
    lengths: Sequence[int],
    rates_hz: Sequence[float],
    averages: "Averages | None" = None,
) -> tuple[Noise, ...]:
    """Noise of each run, were its residual nothing else: where no rest tells of it.

    Parameters
    ----------
    residual, jacobian, lengths :
        As for `against_rest`.
    rates_hz : sequence of float
        Samples per second of each run.
    averages : Averages, optional
        Of these, as `against_rest` has left them.

    Returns
    -------
    tuple of Noise
        White of a run that is too short for a spectrum.
    """
    parts = np.split(residual, np.cumsum(lengths)[:-1])
    alone = [
        noise_at_rest([own], rate_hz) or white_noise(float(np.sqrt(np.mean(own**2))), rate_hz)
        for own, rate_hz in zip(parts, rates_hz, strict=True)
    ]
    if averages is None or averages.together != tuple(noise.averaged for noise in alone):
        averages = Averages.of(residual, jacobian, lengths, alone)
    seen = _seen(averages, alone)
    return tuple(_together(replace(own, noise=replace(own.noise, dof=0.0 * own.whole))) for own in seen)


def of_runs(values: Floats, lengths: Sequence[int], noises: Sequence[Noise | None]) -> list[Floats]:
    """Values of each run, averaged as its noise is, from those of all runs one after the other."""
    parts = np.split(values, np.cumsum(lengths)[:-1]) if len(lengths) > 1 else [values]
    return [averaged(own, noise.averaged if noise else 1) for own, noise in zip(parts, noises, strict=True)]


@dataclass(frozen=True, eq=False)
class Averages:
    """A residual, averaged as the noise of each run is, and what the fitted numbers can take of it.

    Each run is about its own level, as each stretch at rest is: a level says nothing of the slowest noise.

    Parameters
    ----------
    together : tuple of int
        Samples in a mean, of each run.
    n_fitted : int
        How many of the basis the fit takes up; the others are the levels.
    residuals : list of ndarray, shape (n_time,)
    basis : list of ndarray, shape (n_time, at most n_parameters + n_runs)
        Rows of each run of one orthonormal basis.
    levels : list of ndarray, shape (n_time,)
        What was taken of each residual as its level.
    """

    together: tuple[int, ...]
    n_fitted: int
    residuals: list[Floats]
    basis: list[Floats]
    levels: list[Floats]

    @classmethod
    def of(
        cls, residual: Floats, jacobian: Floats, lengths: Sequence[int], noises: Sequence[Noise]
    ) -> "Averages":
        residuals, jacobians = (of_runs(values, lengths, noises) for values in (residual, jacobian))
        own = [len(each) for each in residuals]
        fitted, of_all = _orthonormal(np.concatenate(jacobians)), np.concatenate(residuals)
        levels = np.repeat(np.eye(len(own)), own, axis=0)
        levels = _orthonormal(levels - fitted @ (fitted.T @ levels))
        level, basis, ends = levels @ (levels.T @ of_all), np.hstack([fitted, levels]), np.cumsum(own)[:-1]
        together = tuple(noise.averaged for noise in noises)
        parts = (np.split(each, ends) for each in (of_all - level, basis, level))
        return cls(together, fitted.shape[1], *parts)

    @cached_property
    def powers(self) -> list[Floats]:
        """Power of each residual."""
        return [tapered_power(own) for own in self.residuals]

    @cached_property
    def powers_with_level(self) -> list[Floats]:
        """The same of the residuals about zero, whose error a fit has in its numbers."""
        return [tapered_power(own + level) for own, level in zip(self.residuals, self.levels, strict=True)]

    @cached_property
    def transforms(self) -> list[Complexes]:
        """Of each basis under the tapers."""
        return [tapered(own.T) for own in self.basis]


@dataclass(frozen=True, eq=False)
class _Seen:
    """A residual beside the noise of its run.

    Parameters
    ----------
    noise : Noise
    n : int
        Samples, averaged as those of the noise are.
    band : ndarray of int, shape (n_frequencies,)
        In which each frequency lies.
    power, with_level, at_rest, taken : ndarray, shape (n_frequencies,)
        Power of the residual about its level and about zero, that of the noise, and what the fit takes of the
        latter [rad²].
    left, left_with_level, whole : ndarray, shape (n_bands,)
        Degrees of freedom of the residual about its level and about zero, and of noise of which nothing is
        fitted.
    """

    noise: Noise
    n: int
    band: Indices
    power: Floats
    with_level: Floats
    at_rest: Floats
    taken: Floats
    left: Floats
    left_with_level: Floats
    whole: Floats


def _seen(averages: Averages, noises: Sequence[Noise]) -> list[_Seen]:
    """The residual of each run beside its noise."""
    basis, transforms = averages.basis, averages.transforms
    through = [filtered(noise, each) for each, noise in zip(basis, noises, strict=True)]
    inner = np.sum([each.T @ own for each, own in zip(basis, through, strict=True)], axis=0)
    found = []
    powers = zip(averages.powers, averages.powers_with_level, strict=True)
    each_run = zip(powers, basis, transforms, through, noises, strict=True)
    for power, taking, of_taking, passed, noise in each_run:
        n, n_bands = len(taking), len(noise.ratio)
        taken, share = power_taken(taking, of_taking, passed, inner)
        band = noise.band(frequencies(n))
        of_fit = share_taken(of_taking[: averages.n_fitted])
        left, left_with_level, whole = (
            degrees_of_freedom(band, each, n, n_bands) for each in (share, of_fit, np.zeros(len(share)))
        )
        at_rest = expected_power(noise, n)
        found.append(_Seen(noise, n, band, *power, at_rest, taken, left, left_with_level, whole))
    return found


def _bands(seen: _Seen) -> list[AgainstRest]:
    """A residual against the noise in each band, at last in all together; p is that of the band alone."""
    noise, band, n_bands = seen.noise, seen.band, len(seen.left)
    count = np.bincount(band, minlength=n_bands)
    dof = np.maximum(seen.left, 1.0)
    power, expected = seen.power, seen.at_rest - seen.taken
    some, whole = np.flatnonzero(count), max(float(expected.sum()), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (np.bincount(band, power / expected, n_bands) / count)[some]
        part = np.bincount(band, expected, n_bands)[some] / whole if whole else count[some] / seen.n
        every = float(power.sum() / whole) if whole else np.inf
    both_dof = np.array([dof[some], noise.dof[some]])
    p = fdtrc(*both_dof, np.maximum(ratio, 0.0) / LOUDNESS.louder**2)
    chance = float(fdtrc(*(1 / np.sum(part**2 / both_dof, axis=1)), every / LOUDNESS.louder**2))
    ends_hz = np.array([noise.edges[some], noise.edges[some + 1]]) * noise.rate_hz
    found = zip(p.tolist(), ratio.tolist(), *ends_hz.tolist(), strict=True)
    chance = 0.0 if every > LOUDNESS.loudest else chance
    all_of_them = chance, every, float(ends_hz[0, 0]), float(ends_hz[1, -1])
    return [AgainstRest(*each) for each in (*found, all_of_them)]


def octave_limits(noise: Noise, n: int) -> Floats:
    """Largest ratio to the power at rest that chance allows in each octave, shape (n_bands,).

    Of a residual of `n` samples, averaged as those of the noise are, of which no fit absorbs any.
    """
    band = noise.band(frequencies(n))
    dof = degrees_of_freedom(band, np.zeros(len(band)), n, len(noise.ratio))
    tests = len(np.unique(band)) + 1  # one of all bands together
    return np.asarray(LOUDNESS.louder**2 * fdtri(np.maximum(dof, 1.0), noise.dof, 1 - RESIDUAL / tests))


def _together(seen: _Seen) -> Noise:
    """Noise of a run with the level in each band that rest and residual show together.

    What the fit takes of the noise is no evidence: it counts neither as power nor as degrees of freedom.
    """
    noise, band, n_bands = seen.noise, seen.band, len(seen.left)
    dof = noise.dof + seen.left_with_level
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.bincount(band, seen.with_level / seen.at_rest, n_bands) / np.bincount(
            band, minlength=n_bands
        )
        factor = (noise.dof + seen.whole * mean) / dof
    known = np.isfinite(factor) & (factor > 0)
    return replace(noise, ratio=noise.ratio * np.where(known, factor, 1.0), dof=dof)


def _orthonormal(jacobian: Floats) -> Floats:
    """Orthonormal basis of the columns, shape (n_time, at most n_parameters)."""
    scale = np.sqrt(np.mean(jacobian**2, axis=0))
    basis, size, _ = np.linalg.svd(jacobian[:, scale > 0] / scale[scale > 0], full_matrices=False)
    return np.asarray(basis[:, size > NO_TRACE * size[:1]])


def is_white(residual: Floats, level: float = 1.63) -> bool:
    """Whether a residual agrees with white noise: Bartlett's test of the cumulative periodogram.

    The cumulated periodogram of white noise rises along the diagonal; its greatest distance from it
    follows Kolmogorov's law (Durbin 1969, doi:10.1093/biomet/56.1.1).

    Parameters
    ----------
    residual : array_like, shape (n_time,)
        In any unit, equally spaced.
    level : float
        Greatest distance times the root of the number of frequencies: 1.63 is exceeded by chance once in a
        hundred times, 1.36 once in twenty.
    """
    transform = np.fft.rfft(residual - np.mean(residual))[1:]
    power = transform.real**2 + transform.imag**2
    share = np.cumsum(power) / np.sum(power)
    n = len(share)
    return bool(np.max(np.abs(share - np.arange(1, n + 1) / n)) * np.sqrt(n) < level)
