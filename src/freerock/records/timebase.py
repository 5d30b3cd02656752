"""Time stamps of a record: a uniform grid for them, or why there is none.

A grid is right where the samples were taken evenly and only their stamps are coarse, jittery or missing.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats, Indices
from freerock.errors import FreerockError

MILD_JITTER = 0.25  # of the sampling interval: largest deviation of a stamp from the grid
GAP = 1.5  # sampling intervals between two stamps from which a sample is missing
ROUNDED_SHARE = 0.01  # rarer than that, an odd interval is a fault and not rounding
ROUNDED_STAMPS = 10  # different stamps that show rounding at least
NAMEABLE = 1e-3  # of the sampling interval: smaller deviations are not worth a note

EXPORT = "export the time column again"
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
    places : ndarray of int, shape (n_stamps,), or None
        Instant of each stamp; None when the n-th stamp is the n-th instant.
    faults : tuple of str
        What was found and how it was handled.
    """

    start_s: float
    step_s: float
    size: int
    places: Indices | None = field(default=None, compare=False)
    faults: tuple[str, ...] = field(default=(), compare=False)


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
        raise FreerockError(where, what, EXPORT)
    back = np.flatnonzero(time[1:] < time[:-1])
    if back.size:
        two = f"from {time[back[0]]:.6g} to {time[back[0] + 1]:.6g} s"
        raise FreerockError(where, f"time runs backwards {two} after sample {back[0]}", SPLIT)
    if time[-1] == time[0]:
        raise FreerockError(where, f"all time stamps are {time[0]:.6g} s", EXPORT)
    return _rounded(time) or _pieces(where, time)


def typical_step(time_s: Floats) -> float:
    """Typical interval between time stamps [s]."""
    return float(np.median(np.diff(time_s)))


def on_grid(where: object, grid: Grid, samples: Floats) -> Floats:
    """Samples at the instants of the grid, NaN where none was taken.

    Raises
    ------
    FreerockError
        Two samples with one stamp that differ; samples without a stamp at the end.
    """
    stamped = grid.size if grid.places is None else grid.places.size
    if late := np.count_nonzero(np.isfinite(samples[stamped:])):
        raise FreerockError(where, f"{late} samples at the end have no time stamp", EXPORT)
    samples = samples[:stamped]
    if grid.places is None:
        return samples
    repeated = np.flatnonzero(np.diff(grid.places) == 0)
    differ = (samples[repeated] != samples[repeated + 1]) & ~np.isnan(samples[repeated + 1])
    if differ.any():
        n = repeated[differ][0]
        what = f"samples {n} and {n + 1} have one time stamp and differ"
        raise FreerockError(where, what, "export the time column with more digits")
    first = np.ones(samples.size, bool)
    first[repeated + 1] = False  # the first of two stays
    placed = np.full(grid.size, np.nan)
    placed[grid.places[first]] = samples[first]
    return placed


def _rounded(time: Floats) -> Grid | None:
    """Grid of stamps that were rounded to few decimal digits, else None."""
    steps = np.diff(time)
    digit = steps[steps > 0].min()
    counts = np.rint(steps / digit)
    often = np.mean(counts > counts.min())
    decimal = abs(np.log10(digit) - np.rint(np.log10(digit))) < 1e-3
    exact = np.abs(steps - counts * digit).max() <= 1e-3 * digit
    shown = np.count_nonzero(steps) >= ROUNDED_STAMPS and ROUNDED_SHARE <= often <= 1 - ROUNDED_SHARE
    if not (decimal and exact and shown and np.ptp(counts) == 1):
        return None
    step, start, off = _line(time, np.arange(time.size, dtype=float), np.zeros(time.size, np.intp), digit)
    if off > digit:
        return None
    fault = f"time stamps rounded to {digit:.3g} s; evenly spaced by {step:.6g} s on average"
    return Grid(float(start[0]), step, time.size, faults=(fault,))


def _line(time: Floats, number: Floats, piece: Indices, typical: float) -> tuple[float, Floats, float]:
    """Straight lines of one slope through the stamps of each stretch over their numbers.

    Returns the slope (typical where they give none), the start of each stretch and the largest deviation [s].
    """
    sums = [np.bincount(piece, weights) for weights in (None, time, number)]
    mean_time, mean_number = sums[1] / sums[0], sums[2] / sums[0]
    centred = number - mean_number[piece]
    product = centred @ centred
    step = centred @ (time - mean_time[piece]) / product if product else typical
    start = mean_time - step * mean_number
    return float(step), start, float(np.abs(time - start[piece] - step * number).max())


def _pieces(where: object, time: Floats) -> Grid:
    """Grid of stamps in stretches between gaps, with one sampling interval for all."""
    steps = np.diff(time, prepend=time[0])
    typical = float(np.median(steps[steps > 0]))
    number = np.cumsum(steps > 0, dtype=float)
    piece = np.cumsum(steps > GAP * typical, dtype=np.intp)
    told = "1 gap" if piece[-1] == 1 else f"{piece[-1]} gaps"
    step, start, off = _line(time, number, piece, typical)
    deviation = off / step
    if not deviation <= MILD_JITTER:
        what = f"the stamps leave an even grid of {step:.6g} s by up to {deviation:.2g} sampling intervals"
        raise FreerockError(where, what, "export with the logger's own clock, or resample it evenly")
    places = (number + np.rint((start - start[0]) / step)[piece]).astype(np.intp)
    size, taken = int(places[-1]) + 1, int(number[-1]) + 1
    if size > 2 * taken:
        raise FreerockError(where, f"{size - taken} of {size} samples are missing in {told}", SPLIT)

    faults = []
    if deviation > NAMEABLE:
        faults.append(f"time stamps jitter by up to {100 * deviation:.2g} % of the sampling interval")
    if time.size > taken:
        faults.append(f"{time.size - taken} repeated samples dropped")
    if size > taken:
        begins = time[np.flatnonzero(np.diff(places) > 1)[0]]
        faults.append(f"{size - taken} samples missing in {told}, the first after {begins:.6g} s")
    even = size == time.size and taken == size
    first = time[0] if deviation <= NAMEABLE else start[0]
    return Grid(float(first), step, size, None if even else places, tuple(faults))
