"""Stretches of a record in which θ shows nothing but the noise of the sensor."""

from collections.abc import Iterator, Sequence

import numpy as np

from freerock.arrays import Floats
from freerock.rotation.still import Phase, stationary_phases, stretches
from freerock.runs.noise_spectrum import Noise, noise_at_rest

BLOCK_S = 0.02  # averaging time in which a swing stands out of the noise
PARTS = 8  # into which a phase is cut
LAST = 2  # of these parts, which show what the phase is like when it has settled
SWINGS = 4.0  # times the usual mean square of averages, from which a part still swings


def quiet_stretches(
    time_s: Floats,
    theta: Floats,
    sigma_theta: Floats,
    window_s: float = 0.25,
    phases: Sequence[Phase] | None = None,
) -> Iterator[Floats]:
    """Yield θ about its level in each quiet stretch of a record, scaled to the usual noise [rad].

    These are its rests and holds (`freerock.rotation.still.stationary_phases`) away from their ends, cut
    where samples are flagged. A rest that follows a motion begins when that has died out: a block in full
    contact swings on below the noise of a sample. A phase that is unsteady throughout is left out.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Evenly spaced time [s].
    theta, sigma_theta : ndarray, shape (n_time,)
        Rotation and the standard deviation of its white noise [rad]; NaN where flagged.
    window_s : float
        Window of the search for stillness [s].
    phases : sequence of Phase, optional
        Of stillness, where they are known.
    """
    step = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
    known = stationary_phases(time_s, theta, window_s=window_s) if phases is None else phases
    phases = [each for each in known if each.kind != "paused"]
    usual_noise, cores = usual_of(sigma_theta), [phase.core(time_s, window_s) for phase in phases]
    block = max(1, round(BLOCK_S / step))
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


def sensor_noise(
    time_s: Floats,
    theta: Floats,
    sigma_theta: Floats,
    step: float = 0.0,
    window_s: float = 0.25,
    phases: Sequence[Phase] | None = None,
) -> Noise | None:
    """Noise of a sensor in units of sigma_theta, from all quiet stretches of a record; None if too short.

    Parameters
    ----------
    time_s, theta, sigma_theta, window_s, phases :
        As for `quiet_stretches`.
    step : float
        Of the converter [rad].
    """
    rate_hz = (len(time_s) - 1) / float(time_s[-1] - time_s[0])
    usual = usual_of(sigma_theta)
    found = noise_at_rest(quiet_stretches(time_s, theta, sigma_theta, window_s, phases), rate_hz, step)
    return found.scaled(1 / usual) if found and found.variance > 0 else None


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
