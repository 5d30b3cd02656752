"""The peaks of |θ| and the impacts between them, compiled: a long record has thousands.

A peak is that of a rigid swing of Housner's equation plus a smooth remainder: none for rigid motion, small
on a compliant base. Only it is fitted, by a low polynomial, over the widest window whose residual is no more
than noise. So rigid motion is estimated without bias from almost the whole swing, and compliant motion from
as much of it as the data allow. An impact is seen from either side: the instant at which θ passes through
zero.

The whole call tree is here, since numba's cache notices a change in the file of the cached function only.
Products and sums are not fused, so the digits do not depend on the processor.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from freerock.arrays import Floats
from freerock.models.compiled import compiled

PEAK_WINDOWS = (0.9, 0.7, 0.5, 0.35, 0.25)  # of the half swing, on either side of its peak
PEAK_DEGREE, LOW_PEAK_DEGREE, LOW_PEAK = 6, 4, 30.0  # a peak under 30 σ_θ can't carry the higher degree
PEAK_TRIES = 5  # centrings of a window
CENTRED = 0.02  # of a window: a top this near to its middle is in it
SWING_SAMPLES = 200  # suffice
TIME_WINDOWS, TIME_DEGREE = (0.25, 0.15, 0.1, 0.06), 3  # of the time from an impact to a peak
AGREE = 3.0  # standard errors by which the two sides may differ on the instant
EPSILON = float(np.finfo(float).eps)
Index = Any  # of a sample


class Residual(NamedTuple):
    """What noise leaves of a fit: mean square over that of white noise, and its degrees of freedom over those
    of white noise. Unknown, of a computed motion, where the residual itself tells."""

    expected: float
    freedom: float
    known: bool


class NoisySamples(NamedTuple):
    """A motion, or a part of it: time [s], θ or |θ| and the standard deviation of its noise [rad].

    `left` is what a fit leaves of that noise.
    """

    t: Floats
    y: Floats
    noise: Floats
    left: Residual


class Peak(NamedTuple):
    """Height of a swing of |θ| [rad], its standard error, and its instant [s].

    Of its fit: half the window [s], degree, and mean square of the residual over that of the noise, at least
    1 where it is known.
    """

    height: float
    stderr: float
    time_s: float
    reach_s: float
    degree: float
    loud: float


class Rigid(NamedTuple):
    """What of a block its rigid swings depend on: critical angle [rad] and frequency parameter [rad/s]."""

    theta_cr: float
    p: float


class Lowest(NamedTuple):
    """The lowest peak that counts: in standard deviations of the noise, and as an angle [rad]."""

    sigmas: float
    angle: float


class Polynomial(NamedTuple):
    """Polynomial fit: coefficients, their covariance, how loud the residual is, whether that is just noise.

    Not `found` where it is undetermined.
    """

    coefficients: Floats
    covariance: Floats
    loud: float
    adequate: bool
    found: bool


class Shape(NamedTuple):
    """A rigid swing about its peak, as `swing_at` takes it."""

    rate: float
    period: float
    of_cosh: float
    even: tuple[float, float, float, float, float]
    odd: tuple[float, float, float, float]


class Extrapolated(NamedTuple):
    """θ [rad] and its rate [rad/s] at an impact, the variance of θ, whether the fit leaves only noise.

    Not `found` where there are too few samples.
    """

    level: float
    rate: float
    level_variance: float
    adequate: bool
    found: bool


class Side(NamedTuple):
    """The motion between a peak and the impact, through which it rises, less the peak's rigid swing.

    `sign` is -1 before the impact and +1 after it.
    """

    sign: float
    peak: Peak
    shape: Shape
    motion: NoisySamples
    remainder: Floats


UNKNOWN = Peak(math.nan, math.nan, math.nan, math.nan, math.nan, math.nan)
NOT_FOUND = Extrapolated(math.nan, math.nan, math.nan, False, False)


@compiled(fastmath=False)
def impact_rows(
    motion: NoisySamples,
    swings: NDArray[np.int64],
    passages: Floats,
    before: Peak,
    released: bool,
    lowest: Lowest,
    block: Rigid,
) -> Floats:
    """The impacts of a run, one to a row, until a peak is too low.

    Parameters
    ----------
    motion : NoisySamples
        θ since the release; its arrays can't be written to.
    swings : ndarray of int, shape (n_impacts + 1, 2)
        First and last sample of each stretch that stands out of the noise with one sign.
    passages : ndarray, shape (n_impacts,)
        Instants [s] near the impacts between them.
    before : Peak
        The release.
    released : bool
        Whether its angle is known and below the critical one.
    lowest : Lowest
    block : Rigid

    Returns
    -------
    ndarray, shape (n_found, 10)
        Instant of the impact and its standard error [s]; signed peak before it, its standard error, and the
        same of the peak after it [rad]; instant of the peak after it and half the window of its fit [s],
        degree and loudness of that fit. Standard errors are those of white noise.
    """
    rows = np.full((passages.size, 10), np.nan)
    until = np.empty(passages.size + 1, np.int64)
    until[:-1], until[-1] = np.searchsorted(motion.t, passages), swings[-1, 1] + 1
    previous = averaged_swing(part(motion, swings[0, 0], until[0]), block)
    for i in range(passages.size):
        first, last = swings[i + 1]
        if last == motion.t.size - 1:
            return rows[:i]  # the record ends before the swing does
        one = motion.noise[first : last + 1].mean()
        swing = averaged_swing(part(motion, until[i], until[i + 1]), block)
        begin, end = motion.t[first], motion.t[last] + EPSILON
        after = fit_peak(part_between(swing, begin, end), one, block)
        if not (max(lowest.sigmas * one, lowest.angle) <= after.height < block.theta_cr):
            return rows[:i]
        came = side_of(previous, passages[i], before, -1.0, block)
        went = side_of(swing, passages[i], after, 1.0, block)
        instant, instant_stderr = impact_time(came, went, passages[i], block)
        if i == 0 and not released:
            before = UNKNOWN
        sign = 1.0 if motion.y[first] > 0 else -1.0
        rows[i, 0], rows[i, 1] = instant, instant_stderr
        rows[i, 2], rows[i, 3] = -sign * before.height, before.stderr
        rows[i, 4], rows[i, 5] = sign * after.height, after.stderr
        rows[i, 6], rows[i, 7], rows[i, 8], rows[i, 9] = after[2:]
        before, previous = after, swing
    return rows


@compiled(fastmath=False)
def part(motion: NoisySamples, first: Index, last: Index) -> NoisySamples:
    """Some of the samples."""
    return NoisySamples(motion.t[first:last], motion.y[first:last], motion.noise[first:last], motion.left)


@compiled(fastmath=False)
def part_between(motion: NoisySamples, one_s: float, other_s: float) -> NoisySamples:
    """The samples from one instant to another, whichever is earlier."""
    first = np.searchsorted(motion.t, min(one_s, other_s))
    return part(motion, first, np.searchsorted(motion.t, max(one_s, other_s)))


@compiled(fastmath=False)
def averaged_swing(swing: NoisySamples, block: Rigid) -> NoisySamples:
    """|θ| of a swing in no more than `SWING_SAMPLES` means, less what it bends within the time of one."""
    t, n = swing.t, swing.t.size
    side = 1.0 if swing.y.sum() > 0 else -1.0
    if n <= SWING_SAMPLES:
        return NoisySamples(t.copy(), side * swing.y, swing.noise.copy(), swing.left)
    step = (t[-1] - t[0]) / SWING_SAMPLES
    time_s, y, noise = np.empty(SWING_SAMPLES), np.empty(SWING_SAMPLES), np.empty(SWING_SAMPLES)
    first = made = 0
    for i in range(SWING_SAMPLES):
        edge = (i + 1) * step + t[0]
        x = xx = total = variance = 0.0
        j = first
        while j < n and (t[j] < edge or i == SWING_SAMPLES - 1):
            since = t[j] - t[0]
            x += since
            xx += since * since
            total += swing.y[j]
            variance += swing.noise[j] * swing.noise[j]
            j += 1
        count = j - first
        if count > 0:
            x, xx, mean = x / count, xx / count, side * total / count
            bend = block.p**2 * math.sin(block.theta_cr - mean)
            time_s[made], y[made] = t[0] + x, mean + bend * (xx - x * x) / 2
            noise[made] = math.sqrt(variance / count / count)
            made += 1
        first = j
    return NoisySamples(time_s[:made], y[:made], noise[:made], swing.left)


@compiled(fastmath=False)
def fit_peak(swing: NoisySamples, noise_of_one: float, block: Rigid) -> Peak:
    """Highest point of a swing given as means of |θ|; NaN with too few of them.

    noise_of_one is the standard deviation of one sample [rad].
    """
    found, adequate = UNKNOWN, False
    t, y = swing.t, swing.y
    if t.size < LOW_PEAK_DEGREE + 4:
        return found
    degree = PEAK_DEGREE if y.max() > LOW_PEAK * noise_of_one else LOW_PEAK_DEGREE
    rigid = Peak(y.max(), 0.0, (t[0] + t[-1]) / 2, 0.0, 0.0, 1.0)
    remainder = y - rigid_swing(t, rigid, block)
    for window in PEAK_WINDOWS:
        reach = window * (t[-1] - t[0]) / 2
        for _ in range(PEAK_TRIES):
            first = np.searchsorted(t, rigid.time_s - reach)
            last = np.searchsorted(t, rigid.time_s + reach)
            if last - first < degree + 4:
                return found
            x = (t[first:last] - rigid.time_s) / reach
            fit = fit_polynomial(x, remainder[first:last], swing.noise[first:last], swing.left, degree)
            if not fit.found:
                return found
            level, slope, bend = fit.coefficients[:3]
            bend -= (block.p * reach) ** 2 * math.sin(block.theta_cr - rigid.height) / 2
            if abs(slope) > -bend:
                return found  # no top within half the window
            shift = -slope / (2 * bend)
            top = rigid.height + level + slope * shift / 2
            unbiased = top + fit.covariance[1, 1] / (4 * bend)  # noise can only raise the top of a curve
            stderr, at = math.sqrt(fit.covariance[0, 0]), rigid.time_s + shift * reach
            peak = Peak(unbiased, stderr, at, reach, float(degree), fit.loud)
            adequate = fit.adequate
            if abs(shift) < CENTRED:
                break
            rigid = Peak(top, 0.0, peak.time_s, 0.0, 0.0, 1.0)
            remainder = y - rigid_swing(t, rigid, block)
        found = peak
        if adequate:
            break
    return found


@compiled(fastmath=False)
def rigid_swing(t: Floats, peak: Peak, block: Rigid) -> Floats:
    """|θ| of a rigid block about a peak: sin(φ/2) = k'/dn(p (t - t_peak) | 1 - k'²), k' = sin(φ_peak/2)."""
    shape, theta = shape_of(peak, block), np.empty(t.size)
    for i in range(t.size):
        theta[i] = swing_at(t[i], peak, shape, block)
    return theta


@compiled(fastmath=False)
def shape_of(peak: Peak, block: Rigid) -> Shape:
    """dn of a swing as a quotient of theta functions of the complementary nome, as in `models.housner`."""
    k = math.sin(max(block.theta_cr - peak.height, 1e-9) / 2)
    mean, complement = arithmetic_geometric_mean(k), arithmetic_geometric_mean(math.sqrt(1 - k * k))
    q = math.exp(-math.pi * complement / mean)
    q2, q4, q6, q9, q12, q16 = q**2, q**4, q**6, q**9, q**12, q**16
    even = (1 - 2 * q4 + 2 * q16, 2 * q - 6 * q9, 4 * q4 - 16 * q16, 8 * q9, 16 * q16)
    odd = (1 - q2 - q6 + q12, 2 * q2 - 2 * q6 - 4 * q12, 4 * q6 - 4 * q12, 8 * q12)
    of_even = even[0] + even[1] + even[2] + even[3] + even[4]
    of_cosh = k * of_even / (odd[0] + odd[1] + odd[2] + odd[3])
    return Shape(block.p * complement, math.pi / mean / block.p, of_cosh, even, odd)


@compiled(fastmath=False)
def arithmetic_geometric_mean(b: float) -> float:
    """AGM of 1 and b: π/2 over it is the complete elliptic integral of the first kind of 1 - b²."""
    a = 1.0
    while abs(a - b) > EPSILON * a:
        a, b = (a + b) / 2, math.sqrt(a * b)
        if abs(a - b) <= 4 * EPSILON * a:
            break
    return a


@compiled(fastmath=False)
def swing_at(instant: float, peak: Peak, shape: Shape, block: Rigid) -> float:
    """|θ| of a rigid swing at an instant [s]."""
    since = instant - peak.time_s
    if abs(since) > shape.period / 2:
        since -= shape.period * np.rint(since / shape.period)
    e, v, u = math.exp(shape.rate * since), shape.even, shape.odd
    cosh = 0.5 * (e + 1 / e)
    c = 2 * cosh * cosh - 1
    even = v[0] + c * (v[1] + c * (v[2] + c * (v[3] + c * v[4])))
    odd = u[0] + c * (u[1] + c * (u[2] + c * u[3]))
    return block.theta_cr - 2 * math.asin(min(shape.of_cosh * cosh * odd / even, 1.0))


@compiled(fastmath=False)
def fit_polynomial(x: Floats, y: Floats, noise: Floats, left: Residual, degree: int) -> Polynomial:
    """Weighted least squares.

    Unless known noise explains the residual, the residual gives the scale of the covariance.
    """
    n = degree + 1
    moments, on_y = np.zeros(2 * degree + 1), np.zeros(n)
    for i in range(x.size):
        power = 1 / (noise[i] * noise[i])
        for j in range(moments.size):
            moments[j] += power
            if j < n:
                on_y[j] += power * y[i]
            power *= x[i]
    covariance, found = inverse_of(moments, n)
    coefficients = np.zeros(n)
    for i in range(n):
        for j in range(n):
            coefficients[i] += covariance[i, j] * on_y[j]
    squares = 0.0
    for i in range(x.size):
        fitted = 0.0
        for j in range(degree, -1, -1):
            fitted = fitted * x[i] + coefficients[j]
        squares += ((y[i] - fitted) / noise[i]) ** 2
    freedom = x.size - n
    scatter = squares / freedom / left.expected
    adequate = scatter < 1 + 3 * math.sqrt(2 / (freedom * left.freedom))
    scale = 1.0 if adequate and left.known else scatter
    return Polynomial(coefficients, covariance * scale, scale, adequate, found)


@compiled(fastmath=False)
def inverse_of(moments: Floats, n: int) -> tuple[Floats, bool]:
    """Inverse of the positive matrix of moments[i + j], by Cholesky; whether it has one."""
    lower, inverse = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            rest = moments[i + j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            if i > j:
                lower[i, j] = rest / lower[j, j]
            elif rest > 0:
                lower[i, i] = math.sqrt(rest)
            else:
                return inverse, False
    for j in range(n):  # of the lower triangle
        for i in range(j, n):
            rest = 1.0 if i == j else 0.0
            for k in range(j, i):
                rest -= lower[i, k] * inverse[k, j]
            inverse[i, j] = rest / lower[i, i]
    return inverse.T @ inverse, True


@compiled(fastmath=False)
def side_of(swing: NoisySamples, passage: float, peak: Peak, sign: float, block: Rigid) -> Side:
    """The part of a swing between a passage through zero and its peak."""
    near, shape = part_between(swing, passage, peak.time_s), shape_of(peak, block)
    remainder = np.empty(near.t.size)
    for i in range(near.t.size):
        remainder[i] = sign * (near.y[i] - swing_at(near.t[i], peak, shape, block))
    rising = NoisySamples(near.t, sign * near.y, near.noise, near.left)
    return Side(sign, peak, shape, rising, remainder)


@compiled(fastmath=False)
def towards(side: Side, window: float, instant: float, block: Rigid) -> Extrapolated:
    """The motion extrapolated to the impact from a share of the time to the peak."""
    far = instant + window * (side.peak.time_s - instant)
    first = np.searchsorted(side.motion.t, min(instant, far))
    last = np.searchsorted(side.motion.t, max(instant, far))
    if last - first < TIME_DEGREE + 3:
        return NOT_FOUND
    t, noise = side.motion.t[first:last], side.motion.noise[first:last]
    reach = max(abs(t[0] - instant), abs(t[-1] - instant))
    remainder = side.remainder[first:last]
    fit = fit_polynomial((t - instant) / reach, remainder, noise, side.motion.left, TIME_DEGREE)
    if not fit.found:
        return NOT_FOUND
    swing = swing_at(instant, side.peak, side.shape, block)
    energy = math.cos(block.theta_cr - side.peak.height) - math.cos(block.theta_cr - swing)
    rate = fit.coefficients[1] / reach + block.p * math.sqrt(2 * max(energy, 0.0))
    level = fit.coefficients[0] + side.sign * swing
    return Extrapolated(level, rate, fit.covariance[0, 0], fit.adequate, True)


@compiled(fastmath=False)
def impact_time(came: Side, went: Side, instant: float, block: Rigid) -> tuple[float, float]:
    """Zero of θ and its standard error [s], from the widest windows that agree on it from either side."""
    stderr = math.nan
    for window in TIME_WINDOWS:
        one, other = towards(came, window, instant, block), towards(went, window, instant, block)
        if not (one.found and other.found):
            break
        shift, shift_2 = -one.level / one.rate, -other.level / other.rate
        variance = max(one.level_variance / one.rate**2, EPSILON**2)
        variance_2 = max(other.level_variance / other.rate**2, EPSILON**2)
        weight = 1 / variance + 1 / variance_2
        disagreement = (shift_2 - shift) ** 2 / (variance + variance_2)
        instant += (shift / variance + shift_2 / variance_2) / weight
        stderr = math.sqrt(max(1.0, disagreement) / weight)
        if disagreement < AGREE**2 and one.adequate and other.adequate:
            break
    return instant, stderr
