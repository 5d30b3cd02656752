"""Faults of a signal, named with the time they last.

Samples that can't be used are flagged, before anything else is done to the signal. What spoils a signal as a
whole (a channel coupled for AC) is told by what it does to a block at rest.
"""

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from freerock.rotation.still import stretches

FLAGS = {"error_level": 1, "out_of_range": 2, "saturated": 4, "target_lost": 8, "dropout": 16, "spike": 32}
# On a run that meets the fault; flagged samples are judged by their share.
FAULT_VERDICTS: dict[str, Literal["warn", "fail"]] = {
    "aliasing": "warn",
    "sampling_rate": "warn",
    "lasers_disagree": "warn",
}

EQUAL = 5  # fewer equal samples in a row say nothing
BY_CHANCE = 1e-4  # chance of so many equal samples in a row somewhere in the record
BLOCK_S = 0.025  # the signal is looked at in means over this long where only its course matters
SPIKE = 8.0  # standard deviations of the noise
ROUGH = 6.0  # times what the neighbours differ by
SPIKE_SAMPLES = 3  # what lasts longer is a dropout
LONGEST_S = 0.25  # a jump that has not gone back by then is no dropout
RESTLESS = 0.02  # more jumps than this share of the samples are no exception
MERGED_S = 0.01  # invalid stretches this close are told as one
PIECE = 1 << 15  # samples at a time: what fits the processor's cache is several times faster
NOISE_SAMPLES = 50_000  # suffice to know the noise


class Fault(NamedTuple):
    """What is wrong from when to when [s], in words, and by how much θ is wrong [rad], NaN where unknown."""

    name: str
    start_s: float
    end_s: float
    note: str
    angle: float = math.nan


class Limits(NamedTuple):
    """Valid output of a sensor, and the level that means "no target", with its tolerance."""

    low: float
    high: float
    error_level: float
    error_tolerance: float


def flag_samples(signal, limits: Limits | None = None, *, step: float = 5e-4):
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
    flags = np.zeros(signal.size, np.uint8)
    finite = np.isfinite(signal)
    if not finite.all():
        flags[~finite] = FLAGS["dropout"]
    if limits:
        with np.errstate(invalid="ignore"):
            flags[(signal < limits.low) | (signal > limits.high)] = FLAGS["out_of_range"]
            flags[np.abs(signal - limits.error_level) <= limits.error_tolerance] = FLAGS["error_level"]
    invalid = flags > 0
    if invalid.all() or signal.size < 2 * EQUAL:
        return flags
    valid = np.where(invalid, np.nan, signal) if invalid.any() else signal
    jumps = np.diff(valid)
    _flag_equal(valid, jumps, flags, step)
    _flag_excursions(valid, jumps, flags, step)
    return flags


def _flag_equal(valid, jumps, flags, step):
    """Flag samples that repeat, at an extreme as saturated, elsewhere as a dropout."""
    same = jumps == 0
    if not same.any():
        return
    low, high = np.nanmin(valid), np.nanmax(valid)
    inner = (valid[1:] != low) & (valid[1:] != high)
    size = min(same.size, max(2 * EQUAL, round(10 * BLOCK_S / step)))
    whole = same.size // size * size
    count = inner[:whole].reshape(-1, size).sum(axis=1)
    repeated = (inner & same)[:whole].reshape(-1, size).sum(axis=1)
    telling = count >= EQUAL
    if not telling.any():
        return
    usual = float(np.percentile(repeated[telling] / count[telling], 75))  # that repeat where it is quiet
    if usual > 0.5:
        return
    longest = math.log(BY_CHANCE / same.size) / math.log(usual) if usual else 0.0
    edges = np.flatnonzero(np.diff(np.concatenate(([False], same, [False])).view(np.int8)))
    first, last = edges[::2], edges[1::2]  # samples first .. last are equal
    long = last - first + 1 >= max(EQUAL, longest)
    if not long.any():
        return
    size = np.abs(jumps)
    steps = size[(size > 0) & np.isfinite(size)][:: max(1, size.size // NOISE_SAMPLES)]
    if steps.size == 0:
        return
    abrupt = 0.1 * float(np.median(steps))
    far = 3 * float(np.percentile(steps, 99)) + 10 * noise_of(jumps)  # no motion gets there in one step
    for i, j in zip(first[long].tolist(), last[long].tolist(), strict=True):
        value = valid[i]
        into, out = size[i - 1] if i else np.nan, size[j] if j < jumps.size else np.nan
        if not (into >= abrupt or out >= abrupt):
            continue  # the block stands still and the signal has no noise
        if value in (low, high) and not np.fmax(into, out) > far:
            flags[valid == value] |= FLAGS["saturated"]
        else:
            flags[i : j + 1] |= FLAGS["dropout"]


def noise_of(jumps) -> float:
    """Standard deviation of white noise in a signal of which these are the steps, by its quietest quarter."""
    size = 50
    count = jumps.size // size
    if count == 0:
        return float(np.nanmedian(np.abs(jumps))) if np.isfinite(jumps).any() else 0.0
    every = max(1, jumps.size // NOISE_SAMPLES)
    part = np.abs(jumps[: count * size].reshape(count, size)[::every])
    part = part[np.isfinite(part).all(axis=1)]
    return float(1.13 * np.percentile(np.median(part, axis=1), 25)) if part.size else 0.0


def _flag_excursions(valid, jumps, flags, step):
    """Flag jumps away and back: spikes and dropouts."""
    noise = noise_of(jumps)
    with np.errstate(invalid="ignore"):
        bends = np.concatenate(
            [
                start
                + np.flatnonzero(np.abs(np.diff(jumps[start : start + PIECE + 1])) > (SPIKE - 1) * noise)
                for start in range(0, jumps.size, PIECE)
            ]
        )
    if bends.size == 0 or bends.size > RESTLESS * jumps.size:
        return
    at = np.union1d(bends, bends + 1)
    around = np.clip(at[:, None] + np.r_[-5:-1, 2:6], 0, jumps.size - 1)
    course = _median_of_finite(jumps[around])
    rough = _median_of_finite(np.abs(jumps[around] - course[:, None]))
    size = np.abs(jumps[at] - course)
    sudden = (size > ROUGH * rough) & (size > (SPIKE - 3) * noise)
    at, course, size = at[sudden], course[sudden], size[sudden]
    longest = round(LONGEST_S / step)
    sign, done = np.sign(jumps[at]), -1
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
            if abs(valid[at[j] + 1] - moved[-1]) < 0.5 * away and away > SPIKE * noise:
                n = at[j] - start
                flags[start + 1 : at[j] + 1] |= FLAGS["spike" if n <= SPIKE_SAMPLES else "dropout"]
                done = j
                break


def _median_of_finite(values):
    """Median along the last axis of what is finite; 0 where nothing is."""
    ordered = np.sort(values, axis=1)  # NaN last
    count = np.isfinite(values).sum(axis=1)
    middle = ordered[np.arange(len(values)), np.maximum(count - 1, 0) // 2]
    return np.where(count > 0, middle, 0.0)


def shares(flags) -> str:
    """Share of the samples by flag, in words."""
    told = [f"{np.mean(flags & mask > 0):.0%} {name}" for name, mask in FLAGS.items() if (flags & mask).any()]
    return ", ".join(told)


def flagged_faults(time_s, flags) -> list[Fault]:
    """A fault for every stretch of samples with the same flag, those closer than `MERGED_S` told as one."""
    faults, every = [], np.flatnonzero(flags)
    if every.size == 0:
        return []
    step = (time_s[-1] - time_s[0]) / max(time_s.size - 1, 1)
    apart = max(1, round(MERGED_S / step))
    for name, mask in FLAGS.items():
        index = every[(flags[every] & mask) > 0]
        if index.size == 0:
            continue
        breaks = np.flatnonzero(np.diff(index) > apart)
        first = index[np.concatenate(([0], breaks + 1))]
        last = index[np.concatenate((breaks, [index.size - 1]))]
        count = np.diff(np.concatenate(([0], breaks + 1, [index.size])))
        for i, j, n in zip(first.tolist(), last.tolist(), count.tolist(), strict=True):
            note = f"{n} sample{'s' if n > 1 else ''}"
            faults.append(Fault(name, float(time_s[i]), float(time_s[j]), note))
    return faults


def listed_faults(record) -> list[Fault]:
    """The faults that a dataset of `rotation.rotation` holds."""
    names = ("fault", "fault_start", "fault_end", "fault_note", "fault_angle")
    columns = (record[name].values.tolist() for name in names)
    return [Fault(*row) for row in zip(*columns, strict=True)]


def lost_at_large_angles(time_s, theta, flags) -> list[Fault]:
    """Stretches without a target that begin where the block was turning further than it is seen anywhere."""
    gone = (flags & (FLAGS["error_level"] | FLAGS["out_of_range"])) > 0
    if not gone.any():
        return []
    seen = np.flatnonzero(~gone & np.isfinite(theta))
    if seen.size == 0:
        return []
    step = (time_s[-1] - time_s[0]) / max(time_s.size - 1, 1)
    ago = max(1, round(0.05 / step))
    farthest = {side: np.max(side * theta[seen], initial=0.0) for side in (-1, 1)}
    faults = []
    for first, last in stretches(gone):
        k = np.searchsorted(seen, first) - 1
        if k < 0:
            continue
        before = theta[seen[k]]
        earlier = theta[seen[max(0, k - ago)]]
        after = theta[seen[k + 1]] if k + 1 < seen.size else before
        most = farthest[1 if before > 0 else -1]
        rising = abs(before) - abs(earlier) > 0.01 * most and before * earlier >= 0
        if abs(before) > 0.95 * most and before * after > 0 and abs(after) > 0.9 * most and rising:
            note = f"beyond {math.degrees(abs(before)):.1f}°"
            faults.append(Fault("target_lost", float(time_s[first]), float(time_s[last]), note))
    return faults


def ac_cutoff(step: float, signal) -> float | None:
    """Cut-off frequency [Hz] of a channel coupled for AC, None where a held angle stands still by itself.

    Behind a first-order high pass of rate λ, whatever stands still decays: y' = -λ (y - y₀). The rates of
    decay of short windows of the signal are gathered; those that occur most are tried. With the right one
    x = y + λ ∫ (y - y₀) dt, the signal before the high pass, stands still clearly longer than y does, and
    comes back to the level it began at; a hand that creeps makes the former true, not the latter.

    Parameters
    ----------
    step : float
        Sampling interval [s].
    signal : ndarray, shape (n_time,)
        As recorded; NaN where it is not a number.

    Returns
    -------
    float or None
    """
    size = max(1, round(BLOCK_S / step))
    n, wide = signal.size // size, 10
    if n < 8 * wide:
        return None
    blocks = signal[: n * size].reshape(n, size)
    with np.errstate(invalid="ignore", over="ignore"):
        y = blocks.mean(axis=1)
        scatter = np.std(blocks[:: max(1, n // 2000)], axis=1)
    good = np.isfinite(y)
    if good.sum() < 8 * wide or not np.isfinite(scatter).any():
        return None
    y = np.interp(np.arange(n), np.flatnonzero(good), y[good])
    dt = size * step
    span = float(np.ptp(y))
    limit = max(float(np.nanpercentile(scatter, 5)), 5e-4 * span)
    if not 0 < span < 1e100:
        return None

    def still(x):
        """Whether each window of ten blocks stands still."""
        ones = np.ones(wide) / wide
        x = x - x.mean()
        mean, square = np.convolve(x, ones, "valid"), np.convolve(x * x, ones, "valid")
        return np.maximum(square - mean**2, 0.0) <= limit**2

    at_first = still(y)
    if not at_first.any():
        return None
    first = int(np.argmax(at_first))
    y0 = float(y[first : first + wide].mean())
    area = (np.cumsum(y - y0) - (y - y0) / 2) * dt
    level = sliding_window_view(y, wide).mean(axis=1) - y0
    turned = np.abs(level) > 0.02 * span
    y_parts, areas = (sliding_window_view(each, wide)[turned] for each in (y, area))
    areas = areas - areas.mean(axis=1, keepdims=True)
    together, alone = (y_parts * areas).sum(axis=1), (areas**2).sum(axis=1)  # where y + λ area is constant
    with np.errstate(divide="ignore", invalid="ignore"):
        rates = np.sort(-together / alone)
    rates = rates[(rates > 0.01) & (rates < 20)]
    if rates.size < wide:
        return None
    density = np.log(rates[wide - 1 :] / rates[: 1 - wide or None])  # small where many windows agree
    candidates = rates[np.argsort(density)[:: max(1, wide // 2)][:40] + wide // 2]

    def stillness(rate):
        return int(np.count_nonzero(still(y + rate * area) & turned))

    best = max(candidates.tolist(), key=stillness)
    for _ in range(3):
        used = still(y + best * area)[turned]
        if not used.any():
            return None
        best = float(-together[used].sum() / alone[used].sum())
    x = y + best * area
    now = still(x)
    gained = np.count_nonzero(now & turned) - np.count_nonzero(at_first & turned)
    last = n - wide - int(np.argmax(now[::-1]))
    begin, end = x[first : first + wide].mean(), x[last : last + wide].mean()
    moved = np.abs(y[first:last] - y0).sum() * dt * best
    returned = moved > 0 and abs(end - begin) < 0.2 * moved
    if best > 0 and gained >= wide and returned:
        return best / (2 * math.pi)
    return None
