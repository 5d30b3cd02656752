"""θ(t) of a record as the search for runs takes it."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Flags, Floats
from freerock.rotation.flags import FLAGS
from freerock.runs.noise import Noise, white_noise

NOISE_SAMPLES = 50_000  # suffice to know the noise


class Signal(NamedTuple):
    """Time [s], rotation and standard deviation of its noise [rad], flags; arrays of one length.

    Rotation is NaN where a sample is flagged. The noise of a sample is `sigma` times `noise`, if known.
    """

    t: Floats
    theta: Floats
    sigma: Floats
    flags: Flags
    noise: Noise | None = None

    @property
    def step_s(self) -> float:
        """Time from a sample to the next [s]."""
        return float(self.t[-1] - self.t[0]) / max(1, len(self.t) - 1)

    @property
    def relative_noise(self) -> Noise:
        """Noise over `sigma`; white where it is not known."""
        return self.noise or white_noise(1.0, 1 / self.step_s)

    def during(self, start_s: float, end_s: float) -> slice:
        """The samples from one instant to another."""
        return slice(*np.searchsorted(self.t, (start_s, end_s)))


def signal_of(time_s: ArrayLike, theta: ArrayLike, sigma_theta: ArrayLike, flags: ArrayLike) -> Signal:
    """θ(t) with the flagged samples left out; a single sigma holds for all samples."""
    flags, theta = np.asarray(flags), np.asarray(theta, float)
    if not np.isnan(theta[flags != 0]).all():
        theta = np.where(flags == 0, theta, np.nan)
    sigma = np.broadcast_to(np.asarray(sigma_theta, float), theta.shape)
    return Signal(np.asarray(time_s, float), theta, sigma, flags)


def names_of(flags: Flags) -> str:
    """The flags of some samples, in brackets."""
    names = [name.replace("_", " ") for name, mask in FLAGS.items() if (flags & mask).any()]
    return f" ({', '.join(names)})" if names else ""


def scatter(x: Floats) -> float:
    """Standard deviation, robust against outliers; NaN samples are left out."""
    finite = np.isfinite(x)
    x = x if finite.all() else x[finite]
    x = x[:: max(1, x.size // NOISE_SAMPLES)]
    return float(1.4826 * np.median(np.abs(x - np.median(x))) or np.std(x)) if x.size else math.nan
