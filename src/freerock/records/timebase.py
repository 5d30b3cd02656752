"""Time stamps of a record: a uniform grid for them, or why there is none.

A grid is right where the samples were taken evenly and only their stamps are coarse, jittery or missing.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freerock.errors import FreerockError
from freerock.records.channels import Samples

MILD_JITTER = 0.25  # of the sampling interval: largest deviation of a stamp from the grid
GAP = 1.5  # sampling intervals between two stamps from which a sample is missing
ROUNDED_SHARE = 0.01  # rarer than that, an odd interval is a fault and not rounding
ROUNDED_STAMPS = 10  # different stamps that show rounding at least
NAMEABLE = 1e-3  # of the sampling interval: smaller deviations are not worth a note

SPLIT = "split it into one file per recording"


@dataclass(frozen=True)
class Grid:
    """Uniform grid of a column of stamps.

    Parameters
    ----------
    start_s, step_s : float
        First instant and sampling interval [s].
    size : int
        Number of instants.
    place : ndarray of int, shape (n_stamps,), or None
        Instant that each stamp belongs to; None when the n-th stamp is the n-th instant.
    faults : tuple of str
        What was found and how it was handled.
    """

    start_s: float
    step_s: float
    size: int
    place: NDArray[np.int64] | None = None
    faults: tuple[str, ...] = ()


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
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        what = f"{bad.size} time stamps are missing or infinite, the first at sample {bad[0]}"
        raise FreerockError(where, what, "export the time column again")
    steps = np.diff(time)
    back = np.flatnonzero(steps < 0)
    if back.size:
        n = back[0]
        what = f"time runs backwards {_times(back.size)}, first from {time[n]:.6g} to {time[n + 1]:.6g} s"
        raise FreerockError(where, f"{what} after sample {n}", SPLIT)
    if time[-1] == time[0]:
        raise FreerockError(where, f"all time stamps are {time[0]:.6g} s", "export the time column again")
    return _rounded(time, steps) or _pieces(where, time, steps)


def on_grid(where: object, grid: Grid, values: ArrayLike) -> Samples:
    """Samples at the instants of the grid, NaN where none was taken.

    Raises
    ------
    FreerockError
        Two samples with one stamp that differ.
    """
    samples: Samples = np.asarray(values, float)
    if grid.place is None:
        return samples
    repeated = np.flatnonzero(np.diff(grid.place) == 0)
    same = (samples[repeated] == samples[repeated + 1]) | np.isnan(samples[repeated + 1])
    if not same.all():
        n = repeated[~same][0]
        two = f"{samples[n]:.6g}, {samples[n + 1]:.6g}"
        what = f"samples {n} and {n + 1} have one time stamp and differ ({two})"
        raise FreerockError(where, what, "export the time column with more digits")
    placed = np.full(grid.size, np.nan)
    placed[grid.place[::-1]] = samples[::-1]  # the first of two stays
    return placed


def _times(n: int) -> str:
    return "once" if n == 1 else f"{n} times"


def _rounded(time: Samples, steps: Samples) -> Grid | None:
    """Grid of stamps that were rounded to few decimal digits, else None."""
    digit = steps[steps > 0].min()
    if abs(math.log10(digit) - round(math.log10(digit))) > 1e-3:
        return None
    counts = np.rint(steps / digit)
    low = counts.min()
    odd = np.count_nonzero(counts != low) / counts.size
    if np.count_nonzero(steps) < ROUNDED_STAMPS:
        return None
    if counts.max() != low + 1 or not ROUNDED_SHARE <= odd <= 1 - ROUNDED_SHARE:
        return None
    if np.abs(steps - counts * digit).max() > 1e-3 * digit:
        return None
    number = np.arange(time.size)
    step, start = np.polyfit(number, time, 1)
    if np.abs(time - start - step * number).max() > digit:
        return None
    fault = f"time stamps rounded to {digit:.3g} s; evenly spaced by {step:.6g} s on average"
    return Grid(float(start), float(step), time.size, faults=(fault,))


def _pieces(where: object, time: Samples, steps: Samples) -> Grid:
    """Grid of stamps in stretches between gaps, with one sampling interval for all."""
    typical = np.median(steps[steps > 0])
    piece = np.concatenate([[0], np.cumsum(steps > GAP * typical)])
    number = np.concatenate([[0], np.cumsum(steps > 0)]).astype(float)
    samples = np.bincount(piece)
    mean_time, mean_number = (np.bincount(piece, x) / samples for x in (time, number))
    centred = number - mean_number[piece]
    step = (centred @ (time - mean_time[piece])) / (centred @ centred) if centred.any() else typical
    start = mean_time - step * mean_number
    deviation = np.abs(time - start[piece] - step * number).max() / step
    if not deviation <= MILD_JITTER:
        what = (
            f"the time stamps leave an even grid of {step:.6g} s by up to {deviation:.2g} sampling intervals"
        )
        raise FreerockError(where, what, "export with the logger's own clock, or resample it evenly")

    shift = np.rint((start - start[0]) / step)
    place = (number + shift[piece]).astype(np.int64)
    size = int(place[-1]) + 1
    taken = int(number[-1]) + 1
    if size > 2 * taken:
        what = f"{size - taken} of {size} samples are missing in {_gaps(samples.size - 1)}"
        raise FreerockError(where, what, SPLIT)

    faults = []
    if deviation > NAMEABLE:
        faults.append(f"time stamps jitter by up to {100 * deviation:.2g} % of the sampling interval")
    if time.size > taken:
        faults.append(f"{time.size - taken} repeated samples dropped")
    if size > taken:
        longest = np.argmax(np.diff(place))
        faults.append(
            f"{size - taken} samples missing in {_gaps(samples.size - 1)}, "
            f"the longest of {place[longest + 1] - place[longest] - 1} after {time[longest]:.6g} s"
        )
    whole = size == time.size and taken == size
    first = time[0] if deviation <= NAMEABLE else start[0]
    return Grid(float(first), float(step), size, None if whole else place, tuple(faults))


def _gaps(n: int) -> str:
    return "1 gap" if n == 1 else f"{n} gaps"
