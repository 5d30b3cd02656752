"""The end of a motion: where it is lost in the noise of the rest that follows."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from freerock.arrays import Floats, Mask
from freerock.rotation.still import Phase
from freerock.runs.signal import Signal, scatter

SMOOTH_S = 0.005  # averaging time in which the last of the motion stands out of the noise
PIECE = 1 << 15  # samples at a time
OUT_OF_NOISE = 5.0  # standard deviations


def core(signal: Signal, phase: Phase, window_s: float) -> slice:
    """The samples of a phase without its uncertain ends."""
    trim = min(window_s / 2, (phase.end_s - phase.start_s) / 4)
    return signal.during(phase.start_s + trim, phase.end_s - trim)


def end_of_motion(signal: Signal, still: slice, start_s: float, until_s: float) -> float:
    """Last instant [s] at which θ, averaged over `SMOOTH_S`, stands out of what it is while still.

    It is sought from `start_s` to `until_s` of the record [s]; `still` are samples of the rest that follows.
    """
    t, theta = signal.t, signal.theta
    width = max(1, round(SMOOTH_S / (t[1] - t[0])))
    first, last = np.searchsorted(t, (start_s, until_s))
    origin = max(0, min(first, still.start) - width)
    part = theta[origin : max(last, still.stop) + width]
    valid = np.isfinite(part)
    every = valid.all()
    mean = _window_sums(part if every else np.where(valid, part, 0.0), width)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean /= _numbers(part.size, width) if every else _window_sums(valid, width, np.int32)
    sought, rest = (
        mean[first - origin : last - origin].copy(),
        mean[still.start - origin : still.stop - origin],
    )
    noise = max(scatter(rest), np.finfo(float).eps)
    moving = np.abs(sought - np.nanmedian(rest, overwrite_input=True)) > OUT_OF_NOISE * noise
    return float(t[first + np.flatnonzero(moving).max(initial=0)])


def _numbers(n: int, width: int) -> NDArray[np.int32]:
    """How many of n samples the window about each holds, as `_window_sums` of ones."""
    first = np.arange(-(width // 2), n + 1, dtype=np.int32)
    return np.asarray(np.minimum(first + width, n) - np.maximum(first, 0), np.int32)


def _window_sums(values: Floats | Mask, width: int, kind: type = float) -> NDArray[Any]:
    """Sum of so many samples about each, fewer at the ends; a rest may be most of a long record."""
    begin, end = width // 2 + 1, width // 2 + 1 + values.size
    sums: NDArray[Any] = np.zeros(end + width, kind)
    np.cumsum(values, out=sums[begin:end])
    sums[end:] = values.sum()
    for i in range(0, end, PIECE):
        part = slice(i, min(i + PIECE, end))
        sums[part] = sums[part.start + width : part.stop + width] - sums[part]
    return sums[:end]
