"""A run's θ(t) -> impacts: when they happen, the peaks between them, what each restitutes.

|θ| between two impacts is a rigid lobe of Housner's equation plus a smooth remainder: none for rigid motion,
small on a compliant base. Only the remainder is fitted, by a low polynomial, over the widest window whose
residual is no more than noise. So rigid motion is estimated without bias from almost the whole lobe, and
compliant motion from as much of it as the data allow. Measured and computed motions go the same way.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv
from scipy.special import ellipj, ellipkinc

from freerock.models.block import GRAVITY, Block
from freerock.runs.verdict import Reason

RELATIVE_NOISE = 1e-6  # of the largest |θ|: what counts as noise in a computed motion
PEAK_WINDOWS = (0.9, 0.7, 0.5, 0.35, 0.25)  # of the half lobe, on either side of its peak
PEAK_DEGREE, LOW_PEAK_DEGREE, LOW_PEAK = 6, 4, 30.0  # a peak under 30 σ_θ can't carry the higher degree
LOBE_SAMPLES = 200  # suffice
TIME_WINDOWS, TIME_DEGREE = (0.25, 0.15, 0.1, 0.06), 3  # of the time from an impact to a peak
RATE_BELOW, RATE_DEGREE = (
    0.7,
    2,
)  # of the lower peak: the rates are read between the uplift amplitude and this
UNIT = [np.eye(degree + 1) for degree in range(PEAK_DEGREE + 1)]
SMALLEST = np.finfo(float).eps ** 2
TAIL_LOBES = 2  # full contact is believed when this many lobes swing in it


@dataclass(frozen=True)
class Impacts:
    """Impacts of one run in the order of time; every array has one value per impact.

    Parameters
    ----------
    time_s, time_stderr_s : ndarray
        Instant θ passes through zero [s].
    peak_before_rad, peak_before_stderr_rad, peak_after_rad, peak_after_stderr_rad : ndarray
        Signed peak rotation on either side [rad]; before the first impact, the angle of release.
    restitution, restitution_stderr : ndarray
        From the two peaks (`restitution_from_peaks`).
    restitution_rate, restitution_rate_stderr : ndarray
        Cross-check: the angular rate after over that before, both extrapolated to the impact from where the
        base is uplifted. NaN where that leaves a rate uncertain by a third or more.
    theta_uplift : float
        Amplitude [rad] under which the base stays in full contact, from the period of the run's own tail;
        0 where the tail shows no swinging in full contact.
    """

    time_s: np.ndarray
    time_stderr_s: np.ndarray
    peak_before_rad: np.ndarray
    peak_before_stderr_rad: np.ndarray
    peak_after_rad: np.ndarray
    peak_after_stderr_rad: np.ndarray
    restitution: np.ndarray
    restitution_stderr: np.ndarray
    restitution_rate: np.ndarray
    restitution_rate_stderr: np.ndarray
    theta_uplift: float


class Peak(NamedTuple):
    """Height of a lobe of |θ| [rad], its standard error, and its instant [s]."""

    height: float
    stderr: float
    time_s: float


class _Fit(NamedTuple):
    """Polynomial fit: coefficients, their covariance, whether the residual is no more than noise."""

    coefficients: np.ndarray
    covariance: np.ndarray
    adequate: bool


class _Rigid(NamedTuple):
    """What of a block its rigid lobes hang on."""

    theta_cr: float
    p: float


def restitution_from_peaks(before, before_stderr, after, after_stderr, block: Block):
    """Restitution that takes one peak of a rigid block to the next.

    r² = (cos φ_after - cos θ_cr)/(cos φ_before - cos θ_cr) with φ = θ_cr - |θ_peak|: the energy integral of
    φ'' = p² sin φ (Housner 1963, doi:10.1785/BSSA0530020403) on either side of the impact. Standard error to
    first order.

    Parameters
    ----------
    before, before_stderr, after, after_stderr : float
        Peak rotations of either sign and their standard errors [rad].
    block : Block

    Returns
    -------
    r, r_stderr : float
        NaN where a peak is zero or beyond θ_cr.
    """
    (energy_0, slope_0), (energy_1, slope_1) = (_energy(abs(peak), block) for peak in (before, after))
    r = math.sqrt(energy_1 / energy_0)
    return r, r / 2 * math.hypot(slope_0 / energy_0 * before_stderr, slope_1 / energy_1 * after_stderr)


def find_impacts(
    time_s,
    theta,
    sigma_theta,
    block: Block,
    *,
    theta0: float | None = None,
    theta0_stderr: float = 0.0,
    min_amplitude_sigmas: float = 10.0,
    min_uplift_ratio: float = 2.0,
    min_samples: int = 12,
) -> Impacts:
    """Find the impacts of one run, measured or computed.

    The list ends at the first peak that is too low: less than `min_amplitude_sigmas` times σ_θ, or than
    `min_uplift_ratio` times the amplitude under which the base stays in full contact. On a Winkler bed a
    block turned by θ touches along sqrt(θ_uplift/θ) of its base: at twice the uplift amplitude still along
    71 %. Lower swings dissipate all the time rather than in impacts, and r is no property of an impact
    (`doubt_about`). The uplift amplitude comes from the half
    period T of the tail, which then does not depend on amplitude: (2/3) b³ k - m g h = I₀ (π/T)² gives k,
    hence the static sink m g/(2 b k) and asin(sink/b) (linearised no-uplift equations (1)-(2) of Spanos et
    al. 2017, doi:10.1016/j.proeng.2017.09.024).

    Parameters
    ----------
    time_s : array_like, shape (n_time,)
        Increasing time [s], from release (or a little later) to rest.
    theta : array_like, shape (n_time,)
        Rotation [rad]; NaN samples are left out.
    sigma_theta : float or array_like, shape (n_time,)
        Standard deviation of the white noise of θ [rad]; 0 for a computed motion.
    block : Block
    theta0, theta0_stderr : float
        Angle of release, of either sign, and its standard error [rad]: the peak before the first impact.
        Without it, or from θ_cr on, that peak and the first restitutions are NaN.
    min_amplitude_sigmas : float
        Peaks lower than this many σ_θ end the list.
    min_uplift_ratio : float
        Peaks lower than this many times the uplift amplitude end the list.
    min_samples : int
        Lobes with fewer samples end the list.

    Returns
    -------
    Impacts
        Empty arrays where no impact stands out.
    """
    t, theta, sigma = (np.asarray(x, float) for x in np.broadcast_arrays(time_s, theta, sigma_theta))
    valid = np.isfinite(theta) & np.isfinite(sigma)
    if not valid.all():
        t, theta, sigma = t[valid], theta[valid], sigma[valid]
    noise = np.maximum(sigma, RELATIVE_NOISE * np.abs(theta).max(initial=0.0))
    noise_known = bool(np.all(sigma == noise))

    lobes = _lobes(theta, noise * min_amplitude_sigmas / 2, min_samples)
    passages = [_line_zero(t[i : j + 1], theta[i : j + 1]) for (_, i), (j, _) in pairwise(lobes)]
    uplift = _uplift_amplitude(t, theta, passages, block)

    columns, rigid = [], _Rigid(block.theta_cr, block.p)
    if passages:
        before = _release(t, theta, theta0, theta0_stderr, rigid)
        bounds = [lobes[0][0], *np.searchsorted(t, passages), lobes[-1][1] + 1]
        previous = _averaged(t, theta, noise, slice(*bounds[:2]), rigid)
    for (first, last), passage, until in zip(
        lobes[1:], passages, bounds[2:] if passages else (), strict=True
    ):
        if last == len(t) - 1:
            break  # the record ends before the lobe does
        one = noise[first : last + 1].mean()
        lobe = _averaged(t, theta, noise, slice(np.searchsorted(t, passage), until), rigid)
        inside = slice(*np.searchsorted(lobe.t, (t[first], t[last] + np.finfo(float).eps)))
        after = _fit_peak(*(each[inside] for each in lobe), noise_known, one, rigid)
        if not max(min_amplitude_sigmas * one, min_uplift_ratio * uplift) <= after.height < rigid.theta_cr:
            break
        sign, sides = np.sign(theta[first]), []
        for part, peak, way in ((previous, before, -1), (lobe, after, 1)):
            sides.append(_side(part, passage, peak, way, noise_known, rigid))
        instant = _impact_time(sides, passage, rigid)
        rates = _rate_ratio(sides, instant[0], uplift, rigid)
        if not columns and (theta0 is None or abs(theta0) >= rigid.theta_cr):
            before, rates = Peak(math.nan, math.nan, math.nan), (math.nan, math.nan)
        r = restitution_from_peaks(before.height, before.stderr, after.height, after.stderr, rigid)
        peaks = -sign * before.height, before.stderr, sign * after.height, after.stderr
        columns.append((*instant, *peaks, *r, *rates))
        before, previous = after, lobe
    return Impacts(*np.array(columns).reshape(-1, 10).T, theta_uplift=uplift)


def doubt_about(impacts: Impacts, *, min_uplift_ratio: float = 2.0) -> list[Reason]:
    """A warning of a run without a restitution to speak of: no swing clearly leaves full contact."""
    if impacts.time_s.size or not impacts.theta_uplift:
        return []
    text = (
        f"per-impact r is not meaningful here: no swing exceeds {min_uplift_ratio:g} times the "
        f"{math.degrees(impacts.theta_uplift):.2f}° up to which the base stays in full contact"
    )
    return [Reason("warn", "no_restitution", text)]


def _lobes(theta, threshold, min_samples):
    """First and last index of the stretches in which θ exceeds the threshold with one sign."""
    index = np.flatnonzero(np.abs(theta) > threshold)
    if index.size == 0:
        return []
    positive = theta[index] > 0
    first = np.concatenate(([0], np.flatnonzero(positive[1:] != positive[:-1]) + 1))
    last = np.concatenate((first[1:], [index.size])) - 1
    short = np.flatnonzero(last - first + 1 < min_samples)
    n = short[0] if short.size else first.size
    return list(zip(index[first[:n]].tolist(), index[last[:n]].tolist(), strict=True))


def _line_zero(t, theta):
    """Instant at which the straight line through a passage is zero."""
    mean, x = float(t.mean()), t - t.mean()
    slope = float(x @ theta) / float(x @ x)
    return min(max(mean - float(theta.mean()) / slope, t[0]), t[-1]) if slope else mean


def _uplift_amplitude(t, theta, passages, block):
    """Amplitude under which the base stays in full contact, 0 if no lobe is that low.

    A lobe's half period, taken as that of full contact, gives an uplift amplitude, and the lobe is in full
    contact if it is lower than that. A lobe that is not gives too small a value, so it excludes itself:
    about a quarter of its own height on a rigid base.
    """
    weight = block.mass_kg * GRAVITY
    found = []
    for start, end in pairwise(passages):
        stiffness = block.inertia_base * (math.pi / (end - start)) ** 2 + weight * block.h  # (2/3) b³ k
        sink = weight * block.b**2 / (3 * stiffness)
        uplift = math.asin(min(1.0, sink / block.b))
        lobe = slice(*np.searchsorted(t, (start, end)))
        if math.pi / 2 * abs(theta[lobe].mean()) < uplift:  # the height of half a sine
            found.append(uplift)
    return float(np.median(found)) if len(found) >= TAIL_LOBES else 0.0


def _energy(height, block):
    """cos φ - cos θ_cr of a peak, half the squared impact rate over p², and its derivative by the height."""
    if not 0 < height < block.theta_cr:
        return math.nan, math.nan
    energy = 2 * math.sin(height / 2) * math.sin(block.theta_cr - height / 2)  # without loss of digits
    return energy, math.sin(block.theta_cr - height)


def _fall_time(height, level, block):
    """Time [s] a rigid block takes from rest at a height to a lower level."""
    phi = max(block.theta_cr - height, 1e-9)
    k = math.sin(phi / 2)
    ratio = k / math.sin(max(block.theta_cr - level, phi) / 2)
    amplitude = math.asin(math.sqrt((1 - ratio**2) / (1 - k * k)))
    return float(ellipkinc(amplitude, 1 - k * k)) / block.p


def _rigid_lobe(t, peak, block):
    """|θ| of a rigid block about a peak: sin(φ/2) = k'/dn(p (t - t_peak) | 1 - k'²), k' = sin(φ_peak/2)."""
    k = math.sin(max(block.theta_cr - peak.height, 1e-9) / 2)
    dn = ellipj(block.p * (t - peak.time_s), 1 - k * k)[2]
    return block.theta_cr - 2 * np.arcsin(np.minimum(k / dn, 1.0))


def _release(t, theta, theta0, theta0_stderr, block):
    """The angle of release as a peak: its rigid lobe meets the data at half its height."""
    height = min(abs(theta0) if theta0 is not None else float(np.abs(theta).max()), 0.99 * block.theta_cr)
    i = int(np.argmax(np.abs(theta) <= height / 2))
    return Peak(height, theta0_stderr, t[i] - _fall_time(height, abs(theta[i]), block))


def _polynomial(x, y, noise, noise_known, degree):
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
    return _Fit(coefficients, covariance * (1.0 if adequate and noise_known else scatter), adequate)


class _Lobe(NamedTuple):
    """|θ| between two passages, and the standard deviation of its noise."""

    t: np.ndarray
    y: np.ndarray
    noise: np.ndarray


def _averaged(t, theta, noise, part, block):
    """A lobe in no more than `LOBE_SAMPLES` means, less what its rigid part bends within the time of one."""
    t, theta, noise = t[part], theta[part], noise[part]
    y = theta if theta.sum() > 0 else -theta
    if t.size <= LOBE_SAMPLES:
        return _Lobe(t, y, noise)
    edges = np.searchsorted(t, np.linspace(t[0], t[-1], LOBE_SAMPLES + 1))
    edges[-1] = t.size
    count = np.diff(edges)
    first, count = edges[:-1][count > 0], count[count > 0]
    x = t - t[0]
    mean_x, mean_xx, mean_y, variance = (
        np.add.reduceat(each, first) / count for each in (x, x * x, y, noise * noise)
    )
    bend = block.p**2 * np.sin(block.theta_cr - mean_y)
    return _Lobe(t[0] + mean_x, mean_y + bend * (mean_xx - mean_x**2) / 2, np.sqrt(variance / count))


def _fit_peak(t, y, noise, noise_known, noise_of_one, block):
    """Highest point of a lobe y = |θ|, noise of means and of one sample; NaN with too few samples."""
    found = Peak(math.nan, math.nan, math.nan)
    if t.size < LOW_PEAK_DEGREE + 4:
        return found
    degree = PEAK_DEGREE if y.max() > LOW_PEAK * noise_of_one else LOW_PEAK_DEGREE
    rigid, remainder = Peak(float(y.max()), 0.0, (t[0] + t[-1]) / 2), None
    for window in PEAK_WINDOWS:
        reach = window * (t[-1] - t[0]) / 2
        for _ in range(5):
            if remainder is None:
                remainder = y - _rigid_lobe(t, rigid, block)
            near = slice(*np.searchsorted(t, (rigid.time_s - reach, rigid.time_s + reach)))
            x = (t[near] - rigid.time_s) / reach
            if x.size < degree + 4:
                return found
            fit = _polynomial(x, remainder[near], noise[near], noise_known, degree)
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
        if fit.adequate:
            break
    return found


class _Side(NamedTuple):
    """The motion y between a peak and the impact, through which it rises, less the peak's rigid lobe."""

    sign: int  # -1 before the impact, +1 after it
    peak: Peak
    t: np.ndarray
    y: np.ndarray
    remainder: np.ndarray
    noise: np.ndarray
    noise_known: bool

    def fit(self, instant, samples, degree, block):
        """Level and slope of y at the impact, their variances, adequacy; None with too few samples."""
        t = self.t[samples]
        if t.size < degree + 3:
            return None
        reach = max(abs(t[0] - instant), abs(t[-1] - instant))
        fit = _polynomial(
            (t - instant) / reach, self.remainder[samples], self.noise[samples], self.noise_known, degree
        )
        if fit is None:
            return None
        lobe = float(_rigid_lobe(instant, self.peak, block))
        energy = math.cos(block.theta_cr - self.peak.height) - math.cos(block.theta_cr - lobe)
        rate = fit.coefficients[1] / reach + block.p * math.sqrt(2 * max(energy, 0.0))
        variance = fit.covariance[0, 0], fit.covariance[1, 1] / reach**2
        return fit.coefficients[0] + self.sign * lobe, rate, *variance, fit.adequate


def _side(lobe, passage, peak, sign, noise_known, block):
    """The part of a lobe between a passage and its peak."""
    near = slice(*np.searchsorted(lobe.t, sorted((passage, peak.time_s))))
    t, y, noise = (each[near] for each in lobe)
    remainder = y - _rigid_lobe(t, peak, block)
    return _Side(sign, peak, t, sign * y, sign * remainder, noise, noise_known)


def _impact_time(sides, instant, block):
    """Zero of θ and its standard error, from the widest windows that agree on it from either side."""
    found = instant, math.nan
    for window in TIME_WINDOWS:
        fits = []
        for side in sides:
            far = instant + window * (side.peak.time_s - instant)
            samples = slice(*np.searchsorted(side.t, sorted((instant, far))))
            fits.append(side.fit(instant, samples, TIME_DEGREE, block))
        if None in fits:
            break
        shift = [-level / rate for level, rate, *_ in fits]
        variance = [max(v / rate**2, SMALLEST) for _, rate, v, *_ in fits]
        weight = 1 / variance[0] + 1 / variance[1]
        disagreement = (shift[1] - shift[0]) ** 2 / (variance[0] + variance[1])
        instant += (shift[0] / variance[0] + shift[1] / variance[1]) / weight
        found = instant, math.sqrt(max(1.0, disagreement) / weight)
        if disagreement < 3**2 and all(fit[-1] for fit in fits):
            break
    return found


def _rate_ratio(sides, instant, uplift, block):
    """Angular rate after over before the impact, each extrapolated to it from where the base is uplifted."""
    fits = []
    for side in sides:
        below = RATE_BELOW * min(side.peak.height for side in sides)
        count = [np.count_nonzero(side.sign * side.y < level) for level in (uplift, below)]  # y is monotonic
        samples = slice(*count) if side.sign > 0 else slice(side.t.size - count[1], side.t.size - count[0])
        fits.append(side.fit(instant, samples, RATE_DEGREE, block))
    if None in fits or any(rate < 3 * math.sqrt(variance) for _, rate, _, variance, _ in fits):
        return math.nan, math.nan
    (_, rate_0, _, variance_0, _), (_, rate_1, _, variance_1, _) = fits
    ratio = rate_1 / rate_0
    return ratio, ratio * math.sqrt(variance_0 / rate_0**2 + variance_1 / rate_1**2)
