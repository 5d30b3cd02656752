"""θ(t) of a record as the search for runs takes it, and where a motion in it is lost in the noise."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freerock.arrays import Flags, Floats, Mask, sampled
from freerock.noise.signal_noise import scatter
from freerock.noise.spectrum import Noise, white_noise
from freerock.rotation.flags import FLAGS


class Signal(NamedTuple):
    """Time [s], rotation and standard deviation of its noise [rad], flags; arrays of one length.

    Rotation is NaN where a sample is flagged. `converter_step` is that of the rotation [rad], 0 where it is
    too fine to be seen, `step_s` the time from a sample to the next [s]. The noise of a sample is `sigma`
    times `relative_noise`, which is white where it is not known.
    """

    t: Floats
    theta: Floats
    sigma: Floats
    flags: Flags
    converter_step: float
    step_s: float
    relative_noise: Noise

    def during(self, start_s: float, end_s: float) -> slice:
        """The samples from one instant to another."""
        return slice(*np.searchsorted(self.t, (start_s, end_s)))

    def noise(self, still: slice) -> float:
        """Standard deviation of a sample's noise [rad], from the second half of samples at rest.

        In the first one the block may swing on in full contact, below the noise. Where the converter hides
        the noise, one rest shows little, and what all of them show holds.
        """
        still = slice((still.start + still.stop) // 2, still.stop)
        usual = float(np.nanmedian(self.sigma[still])) if self.sigma[still].size else np.nan
        return usual if self.converter_step > usual else scatter(self.theta[still], self.converter_step)

    def smoothed(self, part: slice, over_s: float) -> Floats:
        """Means of θ [rad] over so long about each of some samples; NaN where none is valid."""
        width = max(1, round(over_s / (self.t[1] - self.t[0])))
        theta = self.theta[part]
        valid = np.isfinite(theta)
        every = bool(valid.all())
        mean = window_sums(theta if every else np.where(valid, theta, 0.0), width)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean /= window_sums(valid, width, np.int32)
        return mean


def signal_of(
    time_s: ArrayLike, theta: ArrayLike, sigma_theta: ArrayLike, flags: ArrayLike, converter_step: float = 0.0
) -> Signal:
    """θ(t) with the flagged samples left out; a single sigma holds for all samples."""
    flags, (time_s, theta) = np.asarray(flags), sampled(time_s, theta)
    if not np.isnan(theta[flags != 0]).all():
        theta = np.where(flags == 0, theta, np.nan)
    sigma = np.broadcast_to(np.asarray(sigma_theta, float), theta.shape)
    step_s = float(time_s[-1] - time_s[0]) / max(1, len(time_s) - 1)
    white = white_noise(1.0, 1 / step_s if step_s else 1.0)
    return Signal(time_s, theta, sigma, flags, converter_step, step_s, white)


def names_of(flags: Flags) -> str:
    """The flags of some samples, in brackets."""
    names = [name.replace("_", " ") for name, mask in FLAGS.items() if (flags & mask).any()]
    return f" ({', '.join(names)})" if names else ""


def invalid_in(signal: Signal, most: float) -> str:
    """How many samples are invalid, but for those flagged by hand, why, and which keys decide; or ""."""
    flags = signal.flags.astype(np.uint8) & np.uint8(sum(FLAGS.values()))
    share = float(np.mean(flags != 0))
    outside = ": check valid_low_v, valid_high_v (of a current valid_low_ma, valid_high_ma) of the laser"
    keys = outside if (flags & FLAGS["out_of_range"]).any() else ""
    return f"{share:.0%} of the samples are invalid{names_of(flags)}{keys}" if share > most else ""


def window_sums(values: Floats | Mask, width: int, kind: type = float) -> NDArray[Any]:
    """Sum of so many samples about each, fewer at the ends; a rest may be most of a long record."""
    before: NDArray[Any] = np.zeros(width // 2 + 1, kind)
    after: NDArray[Any] = np.full(width, values.sum(), kind)
    sums = np.concatenate([before, np.cumsum(values, dtype=kind), after])
    return np.asarray(sums[width:] - sums[:-width])


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
