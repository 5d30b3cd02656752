"""The end of a motion: where it is lost in the noise of the rest that follows."""

import math

import numpy as np

from freerock.rotation.lattice import scatter
from freerock.runs.signal import Signal

SMOOTH_S = 0.005  # averaging time in which the last of the motion stands out of the noise
OUT_OF_NOISE = 5.0  # standard deviations


def end_of_motion(signal: Signal, still: slice, start_s: float, until_s: float) -> float:
    """Last instant [s] at which θ, averaged over `SMOOTH_S`, stands out of what it is while still.

    It is sought from `start_s` to `until_s` of the record [s]; `still` are samples of the rest that follows.
    """
    t = signal.t
    width = max(1, round(SMOOTH_S / (t[1] - t[0])))
    first, last = np.searchsorted(t, (start_s, until_s))
    origin = max(0, min(first, still.start) - width)
    mean = signal.smoothed(slice(origin, max(last, still.stop) + width), SMOOTH_S)
    sought = mean[first - origin : last - origin].copy()
    rest = mean[still.start - origin : still.stop - origin]
    noise = max(scatter(rest), np.finfo(float).eps)
    if signal.converter_step > signal.noise(still):  # means of samples that hardly differ are rounded so
        noise = max(noise, signal.converter_step / math.sqrt(12))
    moving = np.abs(sought - np.nanmedian(rest, overwrite_input=True)) > OUT_OF_NOISE * noise
    return float(t[first + np.flatnonzero(moving).max(initial=0)])
