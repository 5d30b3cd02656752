"""Noise of a sensor at rest, from the stretches of a record in which θ shows nothing else.

σ of a sample is found by `still_signal`, the spectrum by `spectrum`.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.noise.spectrum import (
    Noise,
    averaged,
    degrees_of_freedom,
    expected_power,
    fit_law,
    frequencies,
    samples_averaged,
    tapered_power,
    white_noise,
)
from freerock.noise.still import Phase, stationary_phases, stretches

BLOCK_S = 0.02  # averaging time in which a swing stands out of the noise
PARTS = 8  # into which a phase is cut
LAST = 2  # of these parts, which show what the phase is like when it has settled
SWINGS = 4.0  # times the usual mean square of averages, from which a part still swings
LINE = 8.0  # times the median of its neighbours: tapered power above it is a line
SHORTEST = 64  # samples of a stretch that says something of a spectrum
RESOLVED = 2.5  # times one over the length of a stretch: least upper end of the lowest band
COARSE = math.sqrt(3)  # standard deviations at rest, above which a converter's step hides the noise
STANDS = 1e-3  # of a converter's step: a stretch that scatters by less has one value, and no spectrum
COARSELY = 4.0  # degrees of freedom, at most, of noise that a converter's step hides


def quiet_stretches(
    time_s: Floats,
    theta: Floats,
    sigma_theta: Floats,
    phases: Sequence[Phase],
    window_s: float = 0.25,
) -> Iterator[Floats]:
    """Yield θ about its level in each quiet stretch of a record, scaled to the usual noise [rad].

    These are its rests and holds (`freerock.noise.still.stationary_phases`) away from their ends, cut
    where samples are flagged. A rest that follows a motion begins when that has died out: a block in full
    contact swings on below the noise of a sample. A phase that is unsteady throughout is left out.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Evenly spaced time [s].
    theta, sigma_theta : ndarray, shape (n_time,)
        Rotation and the standard deviation of its white noise [rad]; NaN where flagged.
    phases : sequence of Phase
        Of stillness.
    window_s : float
        Window of the search for stillness [s].
    """
    step = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
    block, usual_noise = max(1, round(BLOCK_S / step)), usual_of(sigma_theta)
    cores = [each.core(time_s, window_s) for each in phases if each.kind != "paused"]
    cores = [core for core in cores if core.stop - core.start >= PARTS * block]
    alike = [theta[core] / relative_noise(sigma_theta[core], usual_noise) for core in cores]
    swings = [_mean_squares(np.array_split(own, PARTS), block) for own in alike]
    usual = float(np.median([np.mean(own[-LAST:]) for own in swings])) if swings else 0.0
    for own, swing in zip(alike, swings, strict=True):
        loud = np.flatnonzero(swing > SWINGS * usual)
        first = int(loud[-1]) + 1 if len(loud) else 0
        if first < PARTS:
            settled = sum(map(len, np.array_split(own, PARTS)[:first]))
            yield from _valid(own[settled:])


class AtRest(NamedTuple):
    """What a record shows while it stands still: its phases, and the noise of the sensor [rad].

    The noise is that where sigma_theta is as usual; None where no phase is long enough.
    """

    phases: list[Phase]
    noise: Noise | None


def at_rest(
    time_s: Floats, theta: Floats, sigma_theta: Floats, step: float = 0.0, window_s: float = 0.25
) -> AtRest:
    """What a record shows while it stands still.

    Parameters
    ----------
    time_s, theta, sigma_theta, window_s :
        As for `quiet_stretches`.
    step : float
        Of the converter [rad].
    """
    phases = stationary_phases(time_s, theta, window_s=window_s)
    if len(time_s) < 2:
        return AtRest(phases, None)
    rate_hz = (len(time_s) - 1) / float(time_s[-1] - time_s[0])
    quiet = quiet_stretches(time_s, theta, sigma_theta, phases, window_s)
    return AtRest(phases, noise_at_rest(quiet, rate_hz, step))


def over_usual(noise: Noise | None, sigma_theta: Floats) -> Noise | None:
    """Noise [rad] in units of what sigma_theta usually is; None where there is none."""
    return noise.scaled(1 / usual_of(sigma_theta)) if noise and noise.variance > 0 else None


def usual_of(sigma_theta: Floats) -> float:
    """What the standard deviation of the noise usually is in a record [rad]; 1 where it is not known."""
    known = sigma_theta[np.isfinite(sigma_theta) & (sigma_theta > 0)]
    return np.median(known) if known.size else 1.0


def relative_noise(sigma_theta: Floats, usual: float) -> Floats:
    """Standard deviation of the noise [rad] over what it usually is; 1 where it is not known.

    A beam sees the same displacement as another angle where the block is tilted.
    """
    known = np.isfinite(sigma_theta) & (sigma_theta > 0)
    return np.asarray(np.where(known, sigma_theta, usual) / usual, float)


def _mean_squares(parts: Sequence[Floats], block: int) -> Floats:
    """Mean square of block means in each part, about the level that the last ones show."""
    means = [_block_means(part, block) for part in parts]
    settled = np.concatenate(means[-LAST:])
    level = settled[np.isfinite(settled)].mean() if np.isfinite(settled).any() else np.nan
    return np.array([np.mean((own[np.isfinite(own)] - level) ** 2) for own in means])


def _block_means(values: Floats, block: int) -> Floats:
    """Means of whole blocks of samples; NaN where a block has none that is valid."""
    blocks = values[: len(values) // block * block].reshape(-1, block)
    valid = np.isfinite(blocks)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(valid, blocks, 0.0).sum(axis=1) / valid.sum(axis=1))


def _valid(values: Floats) -> Iterator[Floats]:
    """The stretches between samples that are not finite, each about its own level; values are overwritten."""
    for first, last in stretches(np.isfinite(values)):
        part = values[first : last + 1]
        part -= part.mean()
        yield part


def noise_at_rest(stretches: Iterable[Floats], rate_hz: float, step: float = 0.0) -> Noise | None:
    """Noise of a sensor at rest; None where all stretches are too short.

    Parameters
    ----------
    stretches : iterable of ndarray, shape (n_time,)
        θ at rest, each about any level [rad].
    rate_hz : float
        Samples per second.
    step : float
        Of the converter [rad]. Where it hides the noise (less than 1/√3 of it), what a rest shows depends on
        where its level lies between two steps, and a moving block has the error of rounding, step²/12, as
        well: it is added, and the spectrum counts as known within a factor of about three only.
    """
    m = samples_averaged(rate_hz)
    squares, n, still = 0.0, 0, list[Floats]()
    for each in stretches:
        if len(each):
            about = each - each.mean()
            squares, n = squares + float(about @ about), n + len(each)
            still += [averaged(about, m)] if len(each) >= m * SHORTEST else []
    variance = squares / max(1, n)
    if not still:
        return None
    still = [each for each in still if _mean_square([each]) > (STANDS * step) ** 2] or still
    longest = max(map(len, still))
    n_bands = max(1, math.ceil(math.log2(longest / RESOLVED)) - 1)
    coarse = step > COARSE * math.sqrt(variance)
    alone = replace(white_noise(step / math.sqrt(12), rate_hz, n_bands, COARSELY), step=step)
    if _mean_square(still) <= (STANDS * step) ** 2:
        return alone
    where = [frequencies(len(each))[1:] for each in still]  # the lowest goes with the level
    power = [tapered_power(each)[1:] for each in still]
    white, slow, corner = fit_law(np.concatenate(where), np.concatenate(power), longest, LINE, m)
    law = replace(alone, white=white, slow=slow, corner=corner)
    total, count, dof = np.zeros((3, n_bands))
    for each, frequency, own in zip(still, where, power, strict=True):
        band = law.band(frequency)
        total += np.bincount(band, own / expected_power(law, len(each))[1:], n_bands)
        count += np.bincount(band, minlength=n_bands)
        dof += degrees_of_freedom(band, np.zeros(len(band)), len(each), n_bands)
    law = replace(law, ratio=total / count, dof=dof)
    if coarse:
        law = replace(law, white=law.white + step**2 / 12, dof=np.minimum(dof, COARSELY))
    return law


def _mean_square(values: Sequence[Floats]) -> float:
    return sum((float(each @ each) for each in values), 0.0) / max(1, sum(map(len, values)))
