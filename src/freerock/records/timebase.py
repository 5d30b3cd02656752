"""Time stamps of a record: a uniform grid for them, or why there is none.

A grid is right where the samples were taken evenly and only their stamps are coarse, jittery or missing.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats, Indices
from freerock.errors import FreerockError
from freerock.records.channels import SAMPLES_AT_ONCE, SampleColumn, whole

MILD_JITTER = 0.25  # of the sampling interval: largest deviation of a stamp from the grid
GAP = 1.5  # sampling intervals between two stamps from which a sample is missing
ROUNDED_SHARE = 0.01  # rarer than that, an odd interval is a fault and not rounding
ROUNDED_STAMPS = 10  # different stamps that show rounding at least
NAMEABLE = 1e-3  # of the sampling interval: smaller deviations are not worth a note

SPLIT = "split it into one file per recording"

Parts = Callable[[], Iterator[tuple[Floats, Floats, Indices]]]


@dataclass(frozen=True)
class Grid:
    """Uniform grid of a column of stamps.

    Parameters
    ----------
    start_s, step_s : float
        First instant and sampling interval [s].
    size : int
        Number of instants.
    stretches : two ndarrays of int, shape (n_stretches,), or None
        Stamp with which each stretch without a gap or a repeated stamp begins, and its instant; None when the
        n-th stamp is the n-th instant.
    faults : tuple of str
        What was found and how it was handled.
    """

    start_s: float
    step_s: float
    size: int
    stretches: tuple[Indices, Indices] | None = None
    faults: tuple[str, ...] = ()

    def place(self, first: int, last: int) -> Indices:
        """Instants of the stamps from the first up to the last, which does not count."""
        number = np.arange(first, last)
        if self.stretches is None:
            return number
        begins, instants = self.stretches
        of = np.searchsorted(begins, number, "right") - 1
        return instants[of] + number - begins[of]


def regular_grid(where: object, time_s: ArrayLike) -> Grid:
    """Uniform grid of the time stamps of a record.

    Samples count as evenly taken where their stamps are rounded to few digits, or leave the grid by
    MILD_JITTER of a sampling interval at most. Missing stamps leave instants empty. A stretch after a gap is
    moved on to the grid, by less than half a sampling interval.

    Parameters
    ----------
    where : str
        File or column named in errors.
    time_s : array, shape (n,)
        Stamps [s].

    Raises
    ------
    FreerockError
        Fewer than two stamps, missing or infinite ones, time that runs backwards or stands still, jitter that
        is not mild, a rate that drifts, gaps longer than the recording.
    """
    time = np.asarray(time_s, float)
    if time.size < 2:
        raise FreerockError(where, f"{time.size} time stamps give no sampling rate", "record more samples")
    _refuse_disorder(where, time)
    seen = _steps(time)
    return _rounded(time, seen) or _pieces(where, time, seen.typical)


def typical_step(time_s: Floats) -> float:
    """Typical interval between time stamps [s]."""
    starts = range(0, time_s.size - 1, SAMPLES_AT_ONCE)
    return float(
        np.median([np.median(np.diff(time_s[start : start + SAMPLES_AT_ONCE + 1])) for start in starts])
    )


def on_grid(where: object, grid: Grid, values: SampleColumn) -> Floats:
    """Samples at the instants of the grid, NaN where none was taken.

    They are placed part by part, lest memory holds them twice.

    Raises
    ------
    FreerockError
        Two samples with one stamp that differ.
    """
    if grid.stretches is None:
        return whole(values)
    placed = np.full(grid.size, np.nan)
    for start in range(0, len(values), SAMPLES_AT_ONCE):
        begin = max(0, start - 1)
        samples = np.asarray(values[begin : start + SAMPLES_AT_ONCE], float)
        place = grid.place(begin, begin + samples.size)
        repeated = np.flatnonzero(np.diff(place) == 0)
        same = (samples[repeated] == samples[repeated + 1]) | np.isnan(samples[repeated + 1])
        if not same.all():
            n = repeated[~same][0]
            two = f"{samples[n]:.6g}, {samples[n + 1]:.6g}"
            what = f"samples {begin + n} and {begin + n + 1} have one time stamp and differ ({two})"
            raise FreerockError(where, what, "export the time column with more digits")
        first = np.ones(place.size, bool)
        first[repeated + 1] = False  # the first of two stays
        first[: start - begin] = False  # placed before
        placed[place[first]] = samples[first]
    return placed


class _Steps(NamedTuple):
    """Intervals between stamps [s]: the shortest and the longest but 0, a typical one, how many are not 0."""

    shortest: float
    longest: float
    typical: float
    n: int


def _parts(time: Floats) -> Iterator[tuple[slice, Floats]]:
    """Parts of the stamps, with the intervals before each; 0 before the first."""
    for start in range(0, time.size, SAMPLES_AT_ONCE):
        part = slice(start, start + SAMPLES_AT_ONCE)
        yield part, np.diff(time[part], prepend=time[max(0, start - 1)])


def _refuse_disorder(where: object, time: Floats) -> None:
    """Refuse stamps that are missing, infinite, run backwards, or are all the same."""
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        what = f"{bad.size} time stamps are missing or infinite, the first at sample {bad[0]}"
        raise FreerockError(where, what, "export the time column again")
    back = np.flatnonzero(time[1:] < time[:-1])
    if back.size:
        first = back[0]
        often = "once" if back.size == 1 else f"{back.size} times"
        two = f"from {time[first]:.6g} to {time[first + 1]:.6g} s"
        raise FreerockError(where, f"time runs backwards {often}, first {two} after sample {first}", SPLIT)
    if time[-1] == time[0]:
        raise FreerockError(where, f"all time stamps are {time[0]:.6g} s", "export the time column again")


def _steps(time: Floats) -> _Steps:
    """The intervals between stamps, none of which goes backwards, but for those that are 0."""
    found = []
    for _, steps in _parts(time):
        steps = steps[steps > 0]
        if steps.size:
            found.append((steps.min(), steps.max(), np.median(steps), steps.size))
    shortest, longest, typical, n = np.transpose(found)
    return _Steps(float(shortest.min()), float(longest.max()), float(np.median(typical)), int(n.sum()))


def _rounded(time: Floats, seen: _Steps) -> Grid | None:
    """Grid of stamps that were rounded to few decimal digits, else None."""
    digit, n = seen.shortest, time.size - 1
    if abs(math.log10(digit) - round(math.log10(digit))) > 1e-3:
        return None
    low = 1 if seen.n == n else 0
    if seen.n < ROUNDED_STAMPS or round(seen.longest / digit) != low + 1:
        return None
    odd, off = -1 if low else 0, 0.0  # the interval before the first stamp is none
    for _, steps in _parts(time):
        counts = np.rint(steps / digit)
        odd += int(np.count_nonzero(counts != low))
        off = max(off, np.abs(steps - counts * digit).max())
    if not ROUNDED_SHARE <= odd / n <= 1 - ROUNDED_SHARE or off > 1e-3 * digit:
        return None

    def parts() -> Iterator[tuple[Floats, Floats, Indices]]:
        for part, steps in _parts(time):
            number = np.arange(part.start, part.start + steps.size, dtype=float)
            yield time[part], number, np.zeros(steps.size, np.intp)

    line = _line(parts, 1, digit)
    if line.off > digit:
        return None
    step, start = line.step, line.start[0]
    fault = f"time stamps rounded to {digit:.3g} s; evenly spaced by {step:.6g} s on average"
    return Grid(float(start), float(step), time.size, faults=(fault,))


class _Line(NamedTuple):
    """One sampling interval for all stretches, the start of each, largest deviation of a stamp [s]."""

    step: float
    start: Floats
    off: float


def _line(parts: Parts, n_pieces: int, typical: float) -> _Line:
    """Straight lines of one slope through stamps over their numbers, one for each stretch.

    parts gives stamps, their numbers and stretches, part by part; typical is the slope where they give none.
    """
    sums, products = np.zeros((3, n_pieces)), np.zeros(2)
    for time, number, piece in parts():
        own = slice(piece[0], piece[-1] + 1)
        sums[:, own] += [np.bincount(piece - piece[0], weights) for weights in (None, time, number)]
    mean_time, mean_number = sums[1:] / sums[0]
    for time, number, piece in parts():
        centred = number - mean_number[piece]
        products += centred @ (time - mean_time[piece]), centred @ centred
    step = products[0] / products[1] if products[1] else typical
    start = mean_time - step * mean_number
    off = max(np.abs(time - start[piece] - step * number).max() for time, number, piece in parts())
    return _Line(float(step), start, float(off))


def _pieces(where: object, time: Floats, typical: float) -> Grid:
    """Grid of stamps in stretches between gaps, with one sampling interval for all."""

    def parts() -> Iterator[tuple[Floats, Floats, Indices]]:
        last_number, last_piece = 0.0, 0
        for part, steps in _parts(time):
            number = last_number + np.cumsum(steps > 0, dtype=float)
            piece = last_piece + np.cumsum(steps > GAP * typical, dtype=np.intp)
            yield time[part], number, piece
            last_number, last_piece = float(number[-1]), int(piece[-1])

    gaps = sum(int(np.count_nonzero(steps > GAP * typical)) for _, steps in _parts(time))
    told = "1 gap" if gaps == 1 else f"{gaps} gaps"
    line = _line(parts, gaps + 1, typical)
    step, start = line.step, line.start
    deviation = line.off / step
    if not deviation <= MILD_JITTER:
        far = f"{deviation:.2g} sampling intervals"
        what = f"the time stamps leave an even grid of {step:.6g} s by up to {far}"
        raise FreerockError(where, what, "export with the logger's own clock, or resample it evenly")

    shift = np.rint((start - start[0]) / step)
    begins, instants, last, stamps = [], [], -1, 0
    for _, number, piece in parts():
        place = (number + shift[piece]).astype(np.intp)
        new = np.flatnonzero(np.diff(place, prepend=last) != 1)
        begins.append(stamps + new)
        instants.append(place[new])
        last, taken, stamps = place[-1], int(number[-1]) + 1, stamps + place.size
    size = int(last) + 1
    if size > 2 * taken:
        what = f"{size - taken} of {size} samples are missing in {told}"
        raise FreerockError(where, what, SPLIT)

    faults = []
    if deviation > NAMEABLE:
        faults.append(f"time stamps jitter by up to {100 * deviation:.2g} % of the sampling interval")
    if time.size > taken:
        faults.append(f"{time.size - taken} repeated samples dropped")
    begin, instant = np.concatenate([[0], *begins]), np.concatenate([[0], *instants])
    if size > taken:
        missing = np.diff(instant) - np.diff(begin)
        longest = int(np.argmax(missing))
        faults.append(
            f"{size - taken} samples missing in {told}, "
            f"the longest of {missing[longest]} after {time[begin[longest + 1] - 1]:.6g} s"
        )
    even = size == time.size and taken == size
    first = time[0] if deviation <= NAMEABLE else start[0]
    return Grid(float(first), step, size, None if even else (begin, instant), tuple(faults))
