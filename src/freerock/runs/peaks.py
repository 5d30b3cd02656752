"""Peaks of |θ| between two impacts: a rigid swing of Housner's equation plus a smooth remainder.

The remainder is none for rigid motion, small on a compliant base. Only it is fitted, by a low polynomial,
over the widest window whose residual is no more than noise. So rigid motion is estimated without bias from
almost the whole swing, and compliant motion from as much of it as the data allow.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv
from scipy.special import ellipj, ellipkinc

from freerock.arrays import Floats

PEAK_WINDOWS = (0.9, 0.7, 0.5, 0.35, 0.25)  # of the half swing, on either side of its peak
PEAK_DEGREE, LOW_PEAK_DEGREE, LOW_PEAK = 6, 4, 30.0  # a peak under 30 σ_θ can't carry the higher degree
SWING_SAMPLES = 200  # suffice
UNIT = [np.eye(degree + 1) for degree in range(PEAK_DEGREE + 1)]


class Samples(NamedTuple):
    """A motion, or a part of it: time [s], θ or |θ| and the standard deviation of its noise [rad].

    `noise_known` says whether that deviation is measured, rather than put in for a computed motion.
    """

    t: Floats
    y: Floats
    noise: Floats
    noise_known: bool

    def part(self, which: slice) -> "Samples":
        """Some of the samples."""
        return Samples(self.t[which], self.y[which], self.noise[which], self.noise_known)


class Peak(NamedTuple):
    """Height of a swing of |θ| [rad], its standard error, and its instant [s]."""

    height: float
    stderr: float
    time_s: float


UNKNOWN = Peak(math.nan, math.nan, math.nan)


class Rigid(NamedTuple):
    """What of a block its rigid swings depend on: critical angle [rad] and frequency parameter [rad/s]."""

    theta_cr: float
    p: float


class Polynomial(NamedTuple):
    """Polynomial fit: coefficients, their covariance, whether the residual is no more than noise."""

    coefficients: Floats
    covariance: Floats
    adequate: bool


def release_peak(motion: Samples, theta0: float | None, theta0_stderr: float, block: Rigid) -> Peak:
    """The release angle as a peak: its rigid swing meets the data at half its height.

    theta0 and its standard error are in rad, of either sign; None stands for the largest |θ|.
    """
    size = np.abs(motion.y)
    height = min(abs(theta0) if theta0 is not None else float(size.max()), 0.99 * block.theta_cr)
    i = int(np.argmax(size <= height / 2))
    return Peak(height, theta0_stderr, motion.t[i] - _fall_time(height, size[i], block))


def averaged(motion: Samples, which: slice, block: Rigid) -> Samples:
    """|θ| of a swing in no more than `SWING_SAMPLES` means, less what it bends within the time of one."""
    t, theta, noise, noise_known = motion.part(which)
    y = theta if theta.sum() > 0 else -theta
    if t.size <= SWING_SAMPLES:
        return Samples(t, y, noise, noise_known)
    edges = np.searchsorted(t, np.linspace(t[0], t[-1], SWING_SAMPLES + 1))
    edges[-1] = t.size
    count = np.diff(edges)
    first, count = edges[:-1][count > 0], count[count > 0]
    x = t - t[0]
    mean_x, mean_xx, mean_y, variance = (
        np.add.reduceat(each, first) / count for each in (x, x * x, y, noise * noise)
    )
    bend = block.p**2 * np.sin(block.theta_cr - mean_y)
    y = mean_y + bend * (mean_xx - mean_x**2) / 2
    return Samples(t[0] + mean_x, y, np.sqrt(variance / count), noise_known)


def fit_peak(swing: Samples, noise_of_one: float, block: Rigid) -> Peak:
    """Highest point of a swing given as means of |θ|; NaN with too few of them.

    noise_of_one is the standard deviation of one sample [rad].
    """
    found, fit = UNKNOWN, None
    t, y, noise, noise_known = swing
    if t.size < LOW_PEAK_DEGREE + 4:
        return found
    degree = PEAK_DEGREE if y.max() > LOW_PEAK * noise_of_one else LOW_PEAK_DEGREE
    rigid, remainder = Peak(float(y.max()), 0.0, (t[0] + t[-1]) / 2), None
    for window in PEAK_WINDOWS:
        reach = window * (t[-1] - t[0]) / 2
        for _ in range(5):
            if remainder is None:
                remainder = y - rigid_swing(t, rigid, block)
            near = slice(*np.searchsorted(t, (rigid.time_s - reach, rigid.time_s + reach)))
            x = (t[near] - rigid.time_s) / reach
            if x.size < degree + 4:
                return found
            fit = fit_polynomial(x, remainder[near], noise[near], noise_known, degree)
            if fit is None:
                return found
            level, slope, bend = fit.coefficients[:3]
            bend -= (block.p * reach) ** 2 * math.sin(block.theta_cr - rigid.height) / 2
            if abs(slope) > -bend:
                return found  # no top within half the window
            shift = float(-slope / (2 * bend))
            top = float(rigid.height + level + slope * shift / 2)
            unbiased = top + fit.covariance[1, 1] / (4 * bend)  # noise can only raise the top of a curve
            peak = Peak(unbiased, math.sqrt(fit.covariance[0, 0]), rigid.time_s + shift * reach)
            if abs(shift) < 0.02:
                break
            rigid, remainder = Peak(top, 0.0, peak.time_s), None
        found = peak
        if fit and fit.adequate:
            break
    return found


def rigid_swing(t: Floats, peak: Peak, block: Rigid) -> Floats:
    """|θ| of a rigid block about a peak: sin(φ/2) = k'/dn(p (t - t_peak) | 1 - k'²), k' = sin(φ_peak/2)."""
    k = math.sin(max(block.theta_cr - peak.height, 1e-9) / 2)
    dn = ellipj(block.p * (t - peak.time_s), 1 - k * k)[2]
    return np.asarray(block.theta_cr - 2 * np.arcsin(np.minimum(k / dn, 1.0)))


def fit_polynomial(x: Floats, y: Floats, noise: Floats, noise_known: bool, degree: int) -> Polynomial | None:
    """Weighted least squares, None if it is undetermined.

    Unless known noise explains the residual, the residual gives the scale of the covariance.
    """
    powers = np.empty((degree + 1, x.size))
    powers[0] = 1 / noise
    for n in range(degree):
        np.multiply(powers[n], x, out=powers[n + 1])
    _, covariance, singular = dposv(powers @ powers.T, UNIT[degree])
    if singular:
        return None
    y = y * powers[0]
    coefficients = covariance @ (powers @ y)
    residual = y - coefficients @ powers
    freedom = x.size - degree - 1
    scatter = float(residual @ residual) / freedom
    adequate = scatter < 1 + 3 * math.sqrt(2 / freedom)
    return Polynomial(coefficients, covariance * (1.0 if adequate and noise_known else scatter), adequate)


def _fall_time(height: float, level: float, block: Rigid) -> float:
    """Time [s] a rigid block takes from rest at a height to a lower level."""
    phi = max(block.theta_cr - height, 1e-9)
    k = math.sin(phi / 2)
    ratio = k / math.sin(max(block.theta_cr - level, phi) / 2)
    amplitude = math.asin(math.sqrt((1 - ratio**2) / (1 - k * k)))
    return float(ellipkinc(amplitude, 1 - k * k)) / block.p
