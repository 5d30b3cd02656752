"""Flags of samples that can't be used, set before anything else is done to a signal; faults of the signal.

A fault has a name, start and end, and an effect on θ.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Flags, Floats
from freerock.errors import number_of
from freerock.noise.signal_noise import lattice_step
from freerock.noise.still_phases import between_breaks, stretches
from freerock.units import BASE

if TYPE_CHECKING:
    import xarray as xr

FLAGS = {"error_level": 1, "out_of_range": 2, "saturated": 4, "target_lost": 8, "dropout": 16, "spike": 32}
BY_HAND = {"left_out": 64}  # by a person, not by the signal

EQUAL = 5  # fewer equal samples in a row say nothing
BY_CHANCE = 1e-4  # chance of so many equal samples in a row somewhere in the record
WINDOW_S = 0.25  # the share of repeated samples is counted in windows this long
SPIKE = 8.0  # standard deviations of the noise
OF_JUMPS = 0.95  # of white noise: the median of what its jumps are, in absolute value
ROUGH = 6.0  # times what the neighbours differ by
AROUND = 24  # neighbours on either side show how rough the signal is there, less the next two
SPIKE_SAMPLES = 3  # what lasts longer is a dropout
LONGEST_S = 0.25  # a jump that has not gone back by then is no dropout
RESTLESS = 0.02  # more jumps than this share of the samples are no exception
NOISE_SAMPLES = 50_000  # suffice to know the noise
MERGED_S = 0.01  # invalid stretches this close are one fault


class Limits(NamedTuple):
    """Valid output of a sensor, and the level that means "no target", with its tolerance."""

    low: float
    high: float
    error_level: float
    error_tolerance: float


def flag_samples(signal: ArrayLike, limits: Limits | None = None, *, step: float = 5e-4) -> Flags:
    """Flag invalid samples.

    Parameters
    ----------
    signal : ndarray, shape (n_time,)
        As recorded, any unit.
    limits : Limits, optional
        None where the quantity has no limits.
    step : float
        Sampling interval [s].

    Returns
    -------
    ndarray of uint8, shape (n_time,)
        Sum of `FLAGS`; 0 is valid. "error_level": the sensor reports no target, wherever its output is that
        level, be it within the valid output and in passing; "out_of_range": outside the valid output;
        "saturated": more equal samples in a row at the record's largest or smallest valid value than chance
        explains, and every other sample at that value; "dropout": the same elsewhere, a jump away and back
        within `LONGEST_S`, or not a number; "spike": the same within three samples. Neither is sought in a
        signal most of whose samples repeat: a coarse converter, or no noise.
    """
    signal = np.asarray(signal, float)
    flags = np.where(np.isfinite(signal), 0, FLAGS["dropout"]).astype(np.uint8)
    if limits:
        with np.errstate(invalid="ignore"):
            flags[(signal < limits.low) | (signal > limits.high)] = FLAGS["out_of_range"]
            flags[np.abs(signal - limits.error_level) <= limits.error_tolerance] = FLAGS["error_level"]
    if flags.all() or signal.size < 2 * EQUAL:
        return flags
    valid = np.where(flags > 0, np.nan, signal)
    _flag_equal(valid, flags, step)
    _flag_excursions(valid, flags, step)
    return flags


def _flag_equal(valid: Floats, flags: Flags, step: float) -> None:
    """Flag samples that repeat, at an extreme as saturated, elsewhere as a dropout."""
    same = valid[1:] == valid[:-1]
    if not same.any():
        return
    low, high = np.nanmin(valid), np.nanmax(valid)
    window = min(same.size, max(2 * EQUAL, round(WINDOW_S / step)))
    inner, whole = (valid[1:] != low) & (valid[1:] != high), same.size // window * window
    count, repeated = (each[:whole].reshape(-1, window).sum(axis=1) for each in (inner, inner & same))
    telling = count >= EQUAL
    if not telling.any():
        return
    usual = float(np.percentile(repeated[telling] / count[telling], 75))  # that repeat where it is quiet
    if usual > 0.5:
        return
    longest = math.log(BY_CHANCE / same.size) / math.log(usual) if usual else 0.0
    first, last = np.transpose(stretches(same))
    last += 1  # samples first .. last are equal
    long = last - first + 1 >= max(EQUAL, longest)
    if not long.any():
        return
    size = np.abs(np.diff(valid))
    steps = size[(size > 0) & np.isfinite(size)][:: max(1, size.size // NOISE_SAMPLES)]
    if steps.size == 0:
        return
    abrupt = 0.1 * float(np.median(steps))
    far = 3 * float(np.percentile(steps, 99)) + 10 * _noise_of(valid)  # no motion gets there in one step
    for i, j in zip(first[long].tolist(), last[long].tolist(), strict=True):
        value = valid[i]
        into, out = size[i - 1] if i else np.nan, size[j] if j < size.size else np.nan
        if not (into >= abrupt or out >= abrupt):
            continue  # the block stands still and the signal has no noise
        if value in (low, high) and not np.fmax(into, out) > far:
            flags[valid == value] |= FLAGS["saturated"]
        else:
            flags[i : j + 1] |= FLAGS["dropout"]


def _noise_of(signal: Floats) -> float:
    """Standard deviation of white noise in a signal, by the steps of its quietest quarter."""
    n = signal.size - 1
    size = min(50, n)
    first = size * np.arange(0, n // size, max(1, n // NOISE_SAMPLES))
    part = np.abs(np.diff(signal[first[:, None] + np.arange(size + 1)], axis=1))
    part = part[np.isfinite(part).all(axis=1)]
    return float(1.13 * np.percentile(np.median(part, axis=1), 25)) if part.size else 0.0


def _flag_excursions(valid: Floats, flags: Flags, step: float) -> None:
    """Flag jumps away and back: spikes and dropouts."""
    noise, n_jumps = _noise_of(valid), valid.size - 1
    with np.errstate(invalid="ignore"):
        bends = np.flatnonzero(np.abs(np.diff(valid, 2)) > (SPIKE - 1) * noise)
    if bends.size == 0 or bends.size > RESTLESS * n_jumps:
        return
    at = np.union1d(bends, bends + 1)
    around = np.clip(at[:, None] + np.r_[-AROUND:-1, 2 : AROUND + 1], 0, n_jumps - 1)
    near, jumps = valid[around + 1] - valid[around], valid[at + 1] - valid[at]
    course = _median_of_finite(near)
    rough = _median_of_finite(np.abs(near - course[:, None]))
    size = np.abs(jumps - course)
    sudden = (size > ROUGH * rough) & (size > (SPIKE - 3) * noise)
    at, course, size = at[sudden], course[sudden], size[sudden]
    local = SPIKE * np.maximum(rough[sudden] / OF_JUMPS, noise)
    longest = round(LONGEST_S / step)
    sign, done = np.sign(jumps[sudden]), -1
    for i in np.flatnonzero(size > SPIKE * noise):
        if i <= done:
            continue
        start, before = at[i], valid[at[i]]
        for j in range(i + 1, np.searchsorted(at, start + longest, "right")):
            if sign[j] == sign[i]:
                continue
            n = np.arange(1, min(at[j] - start, SPIKE_SAMPLES) + 2)  # along its course for so long
            moved = before + course[i] * np.pad(n, (0, at[j] - start + 1 - n.size), mode="edge")
            away = np.abs(valid[start + 1 : at[j] + 1] - moved[:-1]).min()
            if abs(valid[at[j] + 1] - moved[-1]) < 0.5 * away and away > local[i]:
                n = at[j] - start
                flags[start + 1 : at[j] + 1] |= FLAGS["spike" if n <= SPIKE_SAMPLES else "dropout"]
                done = j
                break


def _median_of_finite(values: Floats) -> Floats:
    """Median along the last axis of what is finite; 0 where nothing is."""
    ordered = np.sort(values, axis=1)  # NaN last
    count = np.isfinite(values).sum(axis=1)
    middle = ordered[np.arange(len(values)), np.maximum(count - 1, 0) // 2]
    return np.where(count > 0, middle, 0.0)


def shares(flags: Flags) -> str:
    """Share of the samples by flag, in words."""
    found = {name: np.mean(flags & mask > 0) for name, mask in FLAGS.items()}
    return ", ".join(f"{share:.0%} {name}" for name, share in found.items() if share)


class Fault(NamedTuple):
    """What is wrong from when to when [s], in words, and by how much θ is wrong [rad], NaN where unknown."""

    name: str
    start_s: float
    end_s: float
    note: str
    angle: float = math.nan


@dataclass(frozen=True)
class SignalQuality:
    """Quality of θ(t) of a record.

    Standard error of its zero [rad], faults of its signal, and step of its converter [rad], 0 where that is
    too fine to be seen.
    """

    zero_stderr: float = 0.0
    faults: tuple[Fault, ...] = ()
    converter_step: float = 0.0


def signal_quality(record: "xr.Dataset") -> SignalQuality:
    """The quality of the signal of a dataset of `rotation.find_rotation`."""
    recorded, theta = next(record[name].values for name in BASE if name in record), record["theta"].values
    valid = np.isfinite(theta) & np.isfinite(recorded)
    step = lattice_step(recorded[valid])
    step = step and step * float(np.ptp(theta[valid]) / np.ptp(recorded[valid]))
    return SignalQuality(record.attrs["zero_stderr_rad"], tuple(listed_faults(record)), step)


def listed_faults(record: "xr.Dataset | xr.DataTree") -> list[Fault]:
    """The faults that a dataset of `rotation.find_rotation` holds."""
    names = ("fault", "fault_start", "fault_end", "fault_note", "fault_angle")
    columns = (np.asarray(record[name]).tolist() for name in names)
    return [Fault(*row) for row in zip(*columns, strict=True)]


def flagged_faults(time_s: Floats, flags: Flags) -> list[Fault]:
    """A fault per stretch of samples with the same flag; stretches closer than `MERGED_S` are one fault."""
    faults: list[Fault] = []
    every = np.flatnonzero(flags)
    step = (time_s[-1] - time_s[0]) / max(time_s.size - 1, 1)
    apart = max(1, round(MERGED_S / step))
    for name, mask in FLAGS.items():
        index = every[(flags[every] & mask) > 0]
        if index.size == 0:
            continue
        for i, j in zip(*between_breaks(np.diff(index) > apart), strict=True):
            note = number_of(j - i + 1, "sample")
            faults.append(Fault(name, float(time_s[index[i]]), float(time_s[index[j]]), note))
    return faults
