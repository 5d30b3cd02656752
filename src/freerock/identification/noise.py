"""Is a residual the noise that the sensor has at rest?"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc

from freerock.arrays import Floats
from freerock.runs.motion import Motion
from freerock.runs.noise import (
    Noise,
    averaged,
    degrees_of_freedom,
    expected_power,
    filtered,
    frequencies,
    power_taken,
    tapered_power,
    white_noise,
)

LOUDER = 1.1  # times the noise at rest, up to which a residual is no model error: sensors differ that much
HOPELESS = 30.0  # times the power of the noise: a quick fit beyond it tells that a full one won't do
LEVEL = 1e-3  # chance of noise as at rest to be taken for more
LOUDEST = 1000.0  # times the power at rest, from which a residual is no noise, however short the rest
SINGULAR = 1e-7  # of the largest singular value, below which a direction of the parameters leaves no trace


@dataclass(frozen=True)
class AgainstRest:
    """A residual against the noise at rest.

    Parameters
    ----------
    p : float
        Chance of noise as at rest, and up to `LOUDER` times as loud, to leave as loud a residual: that of the
        most telling band, of which one holds all frequencies, times the number of bands (Bonferroni), at
        most 1. 0 where the power of all frequencies is over `LOUDEST` times that at rest.
    ratio : float
        Power of the residual over that at rest: in the most telling octave, where it alone tells enough.
    low_hz, high_hz : float
        Ends of that band [Hz].
    """

    p: float
    ratio: float
    low_hz: float
    high_hz: float

    @property
    def is_noise(self) -> bool:
        """Whether the residual passes for noise."""
        return self.p > LEVEL


def noise_of(motion: Motion) -> Noise:
    """Noise of a motion at rest; where none was seen, white noise of its sigma_theta."""
    if motion.noise is not None:
        return motion.noise
    return white_noise(motion.sigma_theta, (len(motion.time_s) - 1) / float(np.ptp(motion.time_s)))


def hopeless_from(motions: Sequence[Motion]) -> float:
    """Mean square of a quick fit [rad²] from which a full one won't do.

    `motions` are those that are fitted together.
    """
    return HOPELESS * max(noise_of(motion).variance for motion in motions)


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
    residuals, jacobians = (of_runs(values, lengths, noises) for values in (residual, jacobian))
    ends = np.cumsum([len(each) for each in residuals])[:-1]
    basis = np.split(_orthonormal(np.concatenate(jacobians)), ends)
    through = [filtered(noise, each) for each, noise in zip(basis, noises, strict=True)]
    inner = np.sum([each.T @ own for each, own in zip(basis, through, strict=True)], axis=0)
    found = [
        _bands(own, noise, *power_taken(taking, passed, inner))
        for own, taking, passed, noise in zip(residuals, basis, through, noises, strict=True)
    ]
    n = sum(map(len, found))
    octave, every = (
        min(bands, key=lambda band: (band.p, -band.ratio))
        for bands in ([band for run in found for band in run[:-1]], [run[-1] for run in found])
    )
    most = octave if n * octave.p <= LEVEL or octave.p <= every.p else every
    return replace(most, p=min(1.0, n * min(octave.p, every.p)))


def of_runs(values: Floats, lengths: Sequence[int], noises: Sequence[Noise | None]) -> list[Floats]:
    """Values of each run, averaged as its noise is, from those of all runs one after the other."""
    parts = np.split(values, np.cumsum(lengths)[:-1])
    return [averaged(own, noise.averaged if noise else 1) for own, noise in zip(parts, noises, strict=True)]


def _bands(residual: Floats, noise: Noise, taken: Floats, share: Floats) -> list[AgainstRest]:
    """A residual against the noise in each band, at last in all together; p is that of the band alone."""
    n, n_bands = len(residual), len(noise.ratio)
    band = noise.band(frequencies(n))
    count = np.bincount(band, minlength=n_bands)
    dof = np.maximum(degrees_of_freedom(band, share, n, n_bands), 1.0)
    power, expected = tapered_power(residual), expected_power(noise, n) - taken
    some, whole = np.flatnonzero(count), max(float(expected.sum()), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (np.bincount(band, power / expected, n_bands) / count)[some]
        part = np.bincount(band, expected, n_bands)[some] / whole if whole else count[some] / n
        every = float(power.sum() / whole) if whole else np.inf
    both_dof = np.array([dof[some], noise.dof[some]])
    p = fdtrc(*both_dof, np.maximum(ratio, 0.0) / LOUDER**2)
    chance = float(fdtrc(*(1 / np.sum(part**2 / both_dof, axis=1)), every / LOUDER**2))
    ends_hz = np.array([noise.edges[some], noise.edges[some + 1]]) * noise.rate_hz
    found = zip(p.tolist(), ratio.tolist(), *ends_hz.tolist(), strict=True)
    all_of_them = 0.0 if every > LOUDEST else chance, every, float(ends_hz[0, 0]), float(ends_hz[1, -1])
    return [AgainstRest(*each) for each in (*found, all_of_them)]


def _orthonormal(jacobian: Floats) -> Floats:
    """Orthonormal basis of the columns, shape (n_time, at most n_parameters)."""
    scale = np.sqrt(np.mean(jacobian**2, axis=0))
    basis, size, _ = np.linalg.svd(jacobian[:, scale > 0] / scale[scale > 0], full_matrices=False)
    return np.asarray(basis[:, size > SINGULAR * size[:1]])
