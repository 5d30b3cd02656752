"""Returns the phases in which a signal stands still: at rest, held by hand before a release, or paused.

Neighbour of both `rotation` (the zero is read at rest) and `runs` (a run goes from the end of a held phase
to the start of the rest phase that follows). Works on volts, displacement or θ alike, signed or not.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from freerock.arrays import Floats, Indices, Mask

LONGER = 1.6  # windows that a phase lasts at least
BLOCKS_PER_WINDOW = 10  # ends of phases are resolved to a tenth of the window
MIN_PEAKS = 3  # an oscillation, unlike a hand, comes back at least this often
PEAK = 0.04  # of the largest deviation: what rises above it is a peak, what falls below half of it a passage
# Of the largest peak, the last before a rest: of foreign records at most 0.11, before a hold 0.6.
DECAYED = 0.3
NEAR_LEVEL = 10.0  # in units of the stillness limit: levels this close are one level
# Phases on either side of an oscillation, among which is the rest it goes about. Of 50 drawn records with up
# to six stops before a release, and a hand that catches, 12 find what all would; of 80 others 8 do.
AROUND = 32
UNSTEADY = 3e-3  # of the range of θ: an angle that wanders no more than this is still held
MOVED = 0.1  # of the largest held level: as far may the level at rest move


@dataclass(frozen=True)
class Phase:
    """A stationary phase of a record.

    Parameters
    ----------
    start_s, end_s : float
        First and last instant of stillness [s], good to about a tenth of the window.
    level, level_stderr : float
        Mean of the signal away from the ends, and its standard error from the scatter of block means
        (so that mains interference, drift and coloured noise count) [unit of the signal].
    kind : str
        "rest" (θ = 0), "held" (ends with a release: free oscillation about the rest level follows) or
        "paused" (still, off the rest level, and no release follows).
    """

    start_s: float
    end_s: float
    level: float
    level_stderr: float
    kind: str = "paused"

    @property
    def mid_s(self) -> float:
        """Middle of the phase [s]."""
        return (self.start_s + self.end_s) / 2

    def core(self, time_s: Floats, window_s: float) -> slice:
        """The samples at some instants [s] without the ends, which a window [s] leaves uncertain."""
        trim = min(window_s / 2, (self.end_s - self.start_s) / 4)
        return slice(*np.searchsorted(time_s, (self.start_s + trim, self.end_s - trim)))


def stationary_phases(
    time_s: ArrayLike, signal: ArrayLike, *, window_s: float = 0.25, floor_fraction: float = 5e-4
) -> list[Phase]:
    """Find the intervals in which a signal stands still, and which of them are rests and which holds.

    A window is cut into ten blocks. It is still when the standard deviation of the block means is below
    the scatter within the quietest blocks (5th percentile), which is the noise, or below `floor_fraction` of
    the signal's range, whichever is larger; a block without a valid sample is not still.
    A phase is at rest when a free oscillation (at least three peaks of falling height) about its own level
    ends in it, or when it lies at the level of such phases. If no oscillation ends within the record, the
    phase about which one goes most evenly to both sides, else the longest phase, gives the rest level. No
    time is set by hand.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Evenly spaced time [s].
    signal : ndarray, shape (n_time,)
        Any measure of the rotation, in any unit; NaN where invalid. May be unsigned (V-shaped at touch-down).
    window_s : float
        Length of the window that must be still [s]; shorter than a quarter of a rocking cycle.
    floor_fraction : float
        The lower limit of stillness, see above.

    Returns
    -------
    list of Phase
        In the order of time; empty when the signal never stands still.
    """
    time_s, signal = np.asarray(time_s, float), np.asarray(signal, float)
    if time_s.size < 2:
        return []
    step = (time_s[-1] - time_s[0]) / (time_s.size - 1)
    per_block = max(1, round(window_s / BLOCKS_PER_WINDOW / step))
    if time_s.size // per_block < BLOCKS_PER_WINDOW:
        return []
    blocks = signal[: signal.size // per_block * per_block].reshape(-1, per_block)
    valid = np.isfinite(blocks)
    count = valid.sum(axis=1)
    if not count.any():
        return []
    centre = float(blocks[valid][0])  # what is centred loses no digits
    blocks = np.where(valid, blocks - centre, 0.0)
    total, filled = blocks.sum(axis=1), count > 0
    means = total / np.maximum(count, 1)
    square = np.einsum("ij,ij->i", blocks, blocks) / np.maximum(count, 1)
    noise = np.percentile(np.sqrt(np.maximum(square - means**2, 0.0))[filled], 5)
    limit = float(max(noise, floor_fraction * np.ptp(means[filled])))
    shortest = max(BLOCKS_PER_WINDOW + 3, LONGER * window_s / (per_block * step))
    still = _still_spans(np.where(filled, means, np.nan), limit)
    spans = [(i, j) for i, j in still if j - i + 1 >= shortest]
    phases = []
    for first, last in spans:
        start, end = time_s[first * per_block], time_s[(last + 1) * per_block - 1]
        core = slice(first + BLOCKS_PER_WINDOW // 2, last + 1 - BLOCKS_PER_WINDOW // 2)  # away from the ends
        level = float(centre + total[core].sum() / count[core].sum())
        known = means[core][filled[core]]
        stderr = float(np.std(known, ddof=1) / np.sqrt(known.size))
        phases.append(Phase(float(start), float(end), level, stderr))
    samples = [(i * per_block, (j + 1) * per_block) for i, j in spans]
    return _classify(phases, samples, signal, max(1, round(0.002 / step)), limit) if phases else []


def _still_spans(means: Floats, limit: float) -> list[tuple[int, int]]:
    """First and last block of each still stretch, by the means of blocks, NaN where a block has no sample.

    Two that touch or overlap at one level are one.
    """
    windows = sliding_window_view(means, BLOCKS_PER_WINDOW)
    spans: list[tuple[int, int, float]] = []
    for first, last in stretches(np.std(windows, axis=1) <= limit):
        last += BLOCKS_PER_WINDOW - 1
        level = float(np.median(means[first : last + 1]))
        if (
            spans
            and first - spans[-1][1] <= BLOCKS_PER_WINDOW
            and abs(level - spans[-1][2]) < NEAR_LEVEL * limit
        ):
            first = spans.pop()[0]
        spans.append((first, last, level))
    return [(first, last) for first, last, _ in spans]


def stretches(mask: Mask) -> list[tuple[int, int]]:
    """First and last index of every run of True in a boolean array, as pairs."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).view(np.int8)))
    return list(zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True))


def between_breaks(breaks: Mask) -> tuple[Indices, Indices]:
    """First and last index of each group of n values; `breaks`, shape (n - 1,), divide some neighbours."""
    after = np.flatnonzero(breaks) + 1
    return np.append(0, after), np.append(after - 1, breaks.size)


def swings_of(theta: Floats, least: float | Floats) -> list[slice]:
    """The stretches in which |θ| is higher than `least` with one sign."""
    high = np.flatnonzero(np.abs(theta) > least)
    if not high.size:
        return []
    first, last = between_breaks(np.diff(theta[high] > 0))
    return [slice(i, j + 1) for i, j in zip(high[first].tolist(), high[last].tolist(), strict=True)]


def _classify(
    phases: list[Phase], spans: list[tuple[int, int]], signal: Floats, stride: int, limit: float
) -> list[Phase]:
    """Name each phase rest, held or paused by what happens before and after it."""
    ends = [0, *(j for _, j in spans)]
    starts = [*(i for i, _ in spans), signal.size]
    gaps = [signal[j:i:stride] for j, i in zip(ends, starts, strict=True)]  # gap g lies before phase g

    at_rest = (
        [
            phase
            for phase, gap in zip(phases, gaps, strict=False)
            # Swings pass the level of a later hold as well; but from where they end a hand goes there, and
            # that is as far from it as many a peak.
            if np.any(_peaks(gap, phase.level, limit)[-1:] <= DECAYED)
        ]
        or _rocked_about(phases, gaps, limit)
        or [max(phases, key=lambda p: p.end_s - p.start_s)]
    )
    middles, levels = zip(*((p.mid_s, p.level) for p in at_rest), strict=True)
    resting = {*at_rest}
    zeros = np.interp([phase.mid_s for phase in phases], middles, levels).tolist()
    held = [
        phase not in resting
        and abs(phase.level - zero) > NEAR_LEVEL * limit
        and _peaks(gap, zero, limit).size > 0
        for phase, zero, gap in zip(phases, zeros, gaps[1:], strict=True)
    ]
    angle = max((abs(p.level - z) for p, z, h in zip(phases, zeros, held, strict=True) if h), default=0.0)
    named = []
    for phase, zero, is_held in zip(phases, zeros, held, strict=True):
        off = abs(phase.level - zero)
        if phase in resting or off <= NEAR_LEVEL * limit or (off <= MOVED * angle and not is_held):
            kind = "rest"
        else:
            kind = "held" if is_held else "paused"
        named.append(replace(phase, kind=kind))
    return named


def _rocked_about(phases: list[Phase], gaps: list[Floats], limit: float) -> list[Phase]:
    """The phases about whose level an oscillation goes, at that about which it goes most evenly."""
    found = [
        (float(np.median(np.abs(np.diff(np.log(peaks))))), phase)
        for i, phase in enumerate(phases)
        for gap in gaps[max(0, i - AROUND) : i + AROUND + 1]
        if (peaks := _peaks(gap, phase.level, limit)).size
    ]
    if not found:
        return []
    level = min(found, key=lambda each: each[0])[1].level
    every = {phase.mid_s: phase for _, phase in found if abs(phase.level - level) <= NEAR_LEVEL * limit}
    return list(every.values())


def _peaks(signal: Floats, level: float, limit: float) -> Floats:
    """Peaks of a signal that rocks freely about a level, from the largest on and over it; else none.

    A peak is the largest deviation between two passages of the level. On each side they fall.
    """
    deviation = signal[np.isfinite(signal)] - level
    away = max(PEAK * np.abs(deviation).max(initial=0), NEAR_LEVEL * limit)
    side = np.where(np.abs(deviation) > away, np.sign(deviation), 0)
    telling = side != 0
    if not ((side > 0).any() and (side < 0).any()):  # passages of a signed signal are changes of its sign
        telling |= np.abs(deviation) < away / 2  # between the two: no change of excursion
    side, height = side[telling], np.abs(deviation[telling])
    if not side.any():
        return np.empty(0)
    start = np.flatnonzero(np.concatenate(([True], side[1:] != side[:-1])))
    peaks = np.maximum.reduceat(height, start)[side[start] != 0]
    peaks = peaks[np.argmax(peaks) :] / peaks.max()
    first = peaks[: MIN_PEAKS + 1]  # the two sides may be seen at different scales
    falls = first.size >= MIN_PEAKS and bool(np.all(first[2:] <= first[:-2]))
    return np.asarray(peaks if falls else np.empty(0))
