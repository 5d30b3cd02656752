"""Returns the noise of θ of a record, a `spectrum.Noise`: at rest, and as loud as it is in motion.

At rest it is seen where θ shows nothing else. σ of a sample is found by `signal_noise`.
While the block moves the noise may be louder, by one factor per octave. Sixth differences of means cancel a
smooth motion, so only noise remains. Means of twice as many samples show the octave below. Differences are
taken near the peaks, away from impacts.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.noise.spectrum import (
    CERTAIN,
    Noise,
    averaged,
    covariance_of_sums,
    degrees_of_freedom,
    expected_power,
    fit_law,
    samples_averaged,
    tapered_power,
    white_noise,
)
from freerock.noise.still_phases import Phase, stationary_phases, stretches

BLOCK_S = 0.02  # averaging time in which a swing stands out of the noise
PARTS = 8  # into which a phase is cut
LAST = 2  # of these parts, which show what the phase is like when it has settled
SWINGS = 4.0  # times the usual mean square of averages, from which a part still swings
LINE = 8.0  # tapered power above so many times the median of its neighbours is a line
SHORTEST = 64  # samples of a stretch that says something of a spectrum
RESOLVED = 2.5  # the lowest band ends at so many times 1/(length of the longest stretch), or higher
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

    These are its rests and holds (`freerock.noise.still_phases.stationary_phases`) away from their ends, cut
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
    block, relative = max(1, round(BLOCK_S / step)), relative_noise(sigma_theta)[1]
    cores = [each.core(time_s, window_s) for each in phases if each.kind != "paused"]
    cores = [core for core in cores if core.stop - core.start >= PARTS * block]
    alike = [theta[core] / relative[core] for core in cores]
    swings = [_mean_squares(np.array_split(own, PARTS), block) for own in alike]
    usual = float(np.median([np.mean(own[-LAST:]) for own in swings])) if swings else 0.0
    for own, swing in zip(alike, swings, strict=True):
        loud = np.flatnonzero(swing > SWINGS * usual)
        first = int(loud[-1]) + 1 if len(loud) else 0
        if first < PARTS:
            settled = sum(map(len, np.array_split(own, PARTS)[:first]))
            for begin, last in stretches(np.isfinite(own[settled:])):
                part = own[settled + begin : settled + last + 1]
                part -= part.mean()
                yield part


class AtRest(NamedTuple):
    """The still phases of a record and the noise of its sensor.

    Parameters
    ----------
    phases : list of Phase
        When the block stands still.
    noise : Noise or None
        Noise [rad] of samples with the usual sigma_theta; None where no phase is long enough.
    relative : Noise or None
        The same over the usual sigma_theta; None where there is no noise.
    """

    phases: list[Phase]
    noise: Noise | None
    relative: Noise | None = None


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
    noise = noise_at_rest(quiet, rate_hz, step)
    if noise is None or not noise.variance > 0:
        return AtRest(phases, noise)
    return AtRest(phases, noise, noise.scaled(1 / relative_noise(sigma_theta)[0]))


def relative_noise(sigma_theta: Floats) -> tuple[float, Floats]:
    """Usual standard deviation of the noise of a record [rad], and that of each sample over it.

    Both are 1 where it is not known. A beam sees the same displacement as another angle where the block is
    tilted.
    """
    known = np.isfinite(sigma_theta) & (sigma_theta > 0)
    usual = np.median(sigma_theta[known]) if known.any() else 1.0
    return usual, np.asarray(np.where(known, sigma_theta, usual) / usual, float)


def _mean_squares(parts: Sequence[Floats], block: int) -> Floats:
    """Mean square of block means in each part, about the level that the last ones show."""
    means = list[Floats]()
    for part in parts:
        blocks = part[: len(part) // block * block].reshape(-1, block)
        valid = np.isfinite(blocks)
        with np.errstate(invalid="ignore"):  # NaN where a block has no sample that is valid
            means.append(np.where(valid, blocks, 0.0).sum(axis=1) / valid.sum(axis=1))
    settled = np.concatenate(means[-LAST:])
    level = settled[np.isfinite(settled)].mean() if np.isfinite(settled).any() else np.nan
    return np.array([np.mean((own[np.isfinite(own)] - level) ** 2) for own in means])


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
    loud = [each for each in still if float(each @ each) / len(each) > (STANDS * step) ** 2]
    longest = max(map(len, loud or still))
    n_bands = max(1, math.ceil(math.log2(longest / RESOLVED)) - 1)
    coarse = step > COARSE * math.sqrt(variance)
    alone = replace(white_noise(step / math.sqrt(12), rate_hz, n_bands, COARSELY), step=step)
    if not loud:
        return alone
    seen = [np.array(tapered_power(each))[:, 1:] for each in loud]  # the lowest goes with the level
    at, every = np.hstack(seen)
    white, slow, corner = fit_law(at, every, longest, LINE, m)
    law = replace(alone, white=white, slow=slow, corner=corner)
    total, count, dof = np.zeros((3, n_bands))
    for each, (frequency, power) in zip(loud, seen, strict=True):
        band = law.band(frequency)
        total += np.bincount(band, power / expected_power(law, len(each))[1:], n_bands)
        count += np.bincount(band, minlength=n_bands)
        dof += degrees_of_freedom(band, np.zeros(len(band)), len(each), n_bands)
    law = replace(law, ratio=total / count, dof=dof)
    if coarse:
        law = replace(law, white=law.white + step**2 / 12, dof=np.minimum(dof, COARSELY))
    return law


SIXTH = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
HIGH_SWING = 20.0  # standard deviations of the noise that a swing is high which tells of it
LONGEST = 8  # means of the noise in one of a difference, at most: beyond them the motion itself is seen
INNER = 0.8  # of a swing, about its middle, that is looked at
OF_MEDIAN = 0.4549  # the median of squares of normal numbers
FARTHEST = 9.0  # a square counts as at most so many times the variance by the median: a jump is no noise
SIZES = int(math.log2(LONGEST)) + 1  # of differences
EFFICIENCY = 0.8  # degrees of freedom of a square: its differences overlap
SURE = 10.0  # twice the logarithm of a likelihood ratio, from which noise is louder
# Octaves below those seen in which it grows on as between the lowest two; set on noises of 1 to 200 ms.
UNSEEN = 3
STEEPEST, SLIGHT = 4.0, 1e-3  # growth from an octave to the one below, at most; power over that at rest


def in_motion(noise: Noise, theta: Floats, sigma: Floats, swings: Iterable[slice]) -> Noise:
    """Noise of a sensor, as loud in each octave as it is while the block swings.

    Parameters
    ----------
    noise : Noise
        At rest, over sigma.
    theta, sigma : ndarray, shape (n_time,)
        Of a motion, rotation and the standard deviation of its noise [rad].
    swings : iterable of slice
        Between impacts.
    """
    m, pieces = noise.averaged, list[Floats]()
    for each in swings:
        values = theta[each] / sigma[each]
        margin = int((1 - INNER) / 2 * len(values))
        inner = values[margin : len(values) - margin]
        pieces.append(inner[: len(inner) // m * m].reshape(-1, m).mean(axis=1))
    ratio, dof = np.ones(SIZES), np.zeros(SIZES)
    for k in range(SIZES):
        weights = np.repeat(SIXTH, 2**k) / 2**k  # of a difference of means of 2ᵏ
        expected = float(covariance_of_sums(noise, weights[None])[0, 0])
        long = [each for each in pieces if len(each) >= len(weights)]
        found = np.array([x for each in long for x in np.convolve(each, weights, "valid")[:: 3 * 2**k]])
        squares = found[np.isfinite(found)] ** 2 / expected
        if squares.size:
            ratio[k] = np.mean(np.minimum(squares, FARTHEST / OF_MEDIAN * np.median(squares)))
            dof[k] = squares.size * EFFICIENCY
    louder = ratio > 1
    if float(dof[louder] @ (ratio - 1 - np.log(ratio))[louder]) < SURE:
        return noise
    excess = np.maximum(ratio - 1, 0.0)
    growth = min(max(excess[-1] / max(excess[-2], SLIGHT), 1.0), STEEPEST)
    excess = np.append(excess, excess[-1] * growth ** np.arange(1, UNSEEN + 1))
    octave = np.minimum(np.arange(len(noise.ratio))[::-1], len(excess) - 1)
    known = np.where(louder, dof, CERTAIN)[np.minimum(octave, SIZES - 1)]
    return replace(noise, ratio=noise.ratio * (1 + excess[octave]), dof=np.minimum(noise.dof, known))
