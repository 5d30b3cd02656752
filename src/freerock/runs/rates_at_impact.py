"""An impact from either side: the instant at which θ passes through zero, and the angular rates there."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.runs.peaks import Peak, Rigid, Samples, fit_polynomial, rigid_swing

TIME_WINDOWS, TIME_DEGREE = (0.25, 0.15, 0.1, 0.06), 3  # of the time from an impact to a peak
RATE_DEGREE = 2
RATE_BELOW = 0.7  # of the lower peak: the rates are read between the uplift amplitude and this
SMALLEST = np.finfo(float).eps ** 2


class Extrapolated(NamedTuple):
    """θ [rad] and its rate [rad/s] at an impact, their variances, whether the fit leaves only noise."""

    level: float
    rate: float
    level_variance: float
    rate_variance: float
    adequate: bool


class Side(NamedTuple):
    """The motion between a peak and the impact, through which it rises, less the peak's rigid swing.

    `sign` is -1 before the impact and +1 after it.
    """

    sign: int
    peak: Peak
    motion: Samples
    remainder: Floats

    def at(self, instant: float, which: slice, degree: int, block: Rigid) -> Extrapolated | None:
        """The motion extrapolated to the impact from some samples, None with too few of them."""
        t = self.motion.t[which]
        if t.size < degree + 3:
            return None
        reach = max(abs(t[0] - instant), abs(t[-1] - instant))
        noise, noise_known = self.motion.noise[which], self.motion.noise_known
        fit = fit_polynomial((t - instant) / reach, self.remainder[which], noise, noise_known, degree)
        if fit is None:
            return None
        swing = float(rigid_swing(np.asarray(instant), self.peak, block))
        energy = math.cos(block.theta_cr - self.peak.height) - math.cos(block.theta_cr - swing)
        rate = fit.coefficients[1] / reach + block.p * math.sqrt(2 * max(energy, 0.0))
        level = fit.coefficients[0] + self.sign * swing
        return Extrapolated(level, rate, fit.covariance[0, 0], fit.covariance[1, 1] / reach**2, fit.adequate)


def side_of(swing: Samples, passage: float, peak: Peak, sign: int, block: Rigid) -> Side:
    """The part of a swing between a passage through zero and its peak."""
    near = swing.part(slice(*np.searchsorted(swing.t, sorted((passage, peak.time_s)))))
    remainder = near.y - rigid_swing(near.t, peak, block)
    return Side(sign, peak, near._replace(y=sign * near.y), sign * remainder)


def impact_time(sides: Sequence[Side], instant: float, block: Rigid) -> tuple[float, float]:
    """Zero of θ and its standard error [s], from the widest windows that agree on it from either side."""
    found = instant, math.nan
    for window in TIME_WINDOWS:
        fits = []
        for side in sides:
            far = instant + window * (side.peak.time_s - instant)
            samples = slice(*np.searchsorted(side.motion.t, sorted((instant, far))))
            fit = side.at(instant, samples, TIME_DEGREE, block)
            if fit is not None:
                fits.append(fit)
        if len(fits) < len(sides):
            break
        shift = [-fit.level / fit.rate for fit in fits]
        variance = [max(fit.level_variance / fit.rate**2, SMALLEST) for fit in fits]
        weight = 1 / variance[0] + 1 / variance[1]
        disagreement = (shift[1] - shift[0]) ** 2 / (variance[0] + variance[1])
        instant += (shift[0] / variance[0] + shift[1] / variance[1]) / weight
        found = instant, math.sqrt(max(1.0, disagreement) / weight)
        if disagreement < 3**2 and all(fit.adequate for fit in fits):
            break
    return found


def rate_ratio(sides: Sequence[Side], instant: float, uplift: float, block: Rigid) -> tuple[float, float]:
    """Angular rate after over before the impact, each extrapolated to it from where the base is uplifted."""
    fits = []
    for side in sides:
        t, y = side.motion.t, side.motion.y
        below = RATE_BELOW * min(each.peak.height for each in sides)
        count = [np.count_nonzero(side.sign * y < level) for level in (uplift, below)]  # y is monotonic
        samples = slice(*count) if side.sign > 0 else slice(t.size - count[1], t.size - count[0])
        fit = side.at(instant, samples, RATE_DEGREE, block)
        if fit is None or fit.rate < 3 * math.sqrt(fit.rate_variance):
            return math.nan, math.nan
        fits.append(fit)
    before, after = fits
    ratio = after.rate / before.rate
    relative = before.rate_variance / before.rate**2 + after.rate_variance / after.rate**2
    return ratio, ratio * math.sqrt(relative)
