"""Samples of a run that count in a fit, and the means over neighbours and over a sensor's time."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from freerock.arrays import Floats
from freerock.noise.spectrum import averaged


@dataclass(frozen=True)
class Samples:
    """Samples of a run that count in a fit.

    Parameters
    ----------
    time_s, theta : ndarray, shape (n_samples,)
        Time since the release [s] and measured rotation [rad].
    m : int
        How many samples are averaged into one.
    """

    time_s: Floats
    theta: Floats
    m: int = 1

    @cached_property
    def measured(self) -> Floats:
        """Means of m measured rotations, times √m, shape (n,)."""
        return averaged(self.theta, self.m)

    @cached_property
    def middle_s(self) -> Floats:
        """Mean instant of each m samples [s], shape (n,)."""
        return self.time_s if self.m == 1 else averaged(self.time_s, self.m) / math.sqrt(self.m)

    @cached_property
    def spans_s2(self) -> tuple[Floats, float, float]:
        """Variance of the instants of each m samples, the largest of them, and square of the distance of
        their middles [s²]."""
        off = self.time_s[: self.middle_s.size * self.m].reshape(-1, self.m) - self.middle_s[:, None]
        spread_s2 = np.mean(off**2, axis=1)
        return spread_s2, float(np.max(spread_s2)), float(np.median(np.diff(self.middle_s))) ** 2

    def smoothed(self, theta: Floats, response_s2: float) -> Floats:
        """Means over m samples and over the time of a sensor, times √m, of rotations at their middles.

        θ + σ² θ̈/2, with σ² the variance of the instants that are averaged. Time is the last axis.
        """
        found = theta.copy()
        if self.m > 1 or response_s2:
            t = self.middle_s
            slopes = np.diff(theta) / np.diff(t)
            half = self.spans_s2[0][1:-1] if self.m > 1 else 0.0
            found[..., 1:-1] += (half + response_s2 / 12) * np.diff(slopes) / (t[2:] - t[:-2])
        return found * math.sqrt(self.m)
