"""Impacts in the θ(t) of a run: their instants, the peaks between them, the restitution of each.

Measured and computed motions go the same way.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.fft import next_fast_len
from scipy.special import ellipkinc

from freerock.arrays import Floats, sampled
from freerock.config.processing import IMPACT_LIMITS, ImpactLimits
from freerock.errors import of_kind
from freerock.models.block import Block
from freerock.noise.rotation_noise import in_motion
from freerock.noise.spectrum import Noise, covariance_of_means, covariance_of_sums
from freerock.noise.still_phases import swings_of
from freerock.runs.impact_kernel import (
    PEAK_DEGREE,
    SWING_SAMPLES,
    Lowest,
    NoisySamples,
    Peak,
    Residual,
    Rigid,
    impact_rows,
)

RELATIVE_NOISE = 1e-6  # of the largest |θ|: what counts as noise in a computed motion


@dataclass(frozen=True)
class Impacts:
    """Impacts of one run in the order of time; every array has one value per impact.

    Parameters
    ----------
    time_s, time_stderr_s : ndarray
        Instant θ passes through zero [s].
    peak_before_rad, peak_before_stderr_rad, peak_after_rad, peak_after_stderr_rad : ndarray
        Signed peak rotation on either side [rad]; before the first impact, the release angle.
    restitution, restitution_stderr : ndarray
        From the two peaks (`restitution_from_peaks`).
    theta_uplift : float
        Amplitude [rad] under which the base stays in full contact, from the period of the run's own tail;
        0 where the tail shows no swinging in full contact.
    """

    time_s: Floats
    time_stderr_s: Floats
    peak_before_rad: Floats
    peak_before_stderr_rad: Floats
    peak_after_rad: Floats
    peak_after_stderr_rad: Floats
    restitution: Floats
    restitution_stderr: Floats
    theta_uplift: float


IMPACT_COLUMNS = [field.name for field in fields(Impacts) if field.name != "theta_uplift"]


def find_impacts(
    time_s: ArrayLike,
    theta: ArrayLike,
    sigma_theta: ArrayLike,
    block: Block,
    *,
    theta0: float | None = None,
    theta0_stderr: float = 0.0,
    limits: ImpactLimits = IMPACT_LIMITS,
    noise: Noise | None = None,
    zero_stderr: float = 0.0,
) -> Impacts:
    """Find the impacts of one run, measured or computed.

    The list ends at the first peak below `min_amplitude_sigmas` times σ_θ, or below `min_uplift_ratio` times
    the amplitude up to which the whole base touches. On a Winkler bed a block turned by θ touches along
    sqrt(θ_uplift/θ) of its base. Lower swings dissipate all the time, and r is no property of an impact.

    Parameters
    ----------
    time_s, theta : array_like, shape (n_time,)
        Increasing time from release, or a little later, to rest [s]; rotation [rad], NaN of what is left out.
    sigma_theta : float or array_like, shape (n_time,)
        Standard deviation of the white noise of θ [rad]; 0 for a computed motion.
    block : Block
    theta0, theta0_stderr : float
        Release angle, of either sign, and its standard error [rad]: the peak before the first impact.
        Without it, or from θ_cr on, that peak and the first restitutions are NaN.
    limits : ImpactLimits, optional
    noise : Noise, optional
        Of the sensor over sigma_theta (`rotation_noise.AtRest.relative`); else it is taken to be white.
    zero_stderr : float
        Standard error of the zero of θ, a part of that of theta0 [rad]: it raises the peaks on one side and
        lowers those on the other.

    Returns
    -------
    Impacts
        Empty arrays where no impact stands out.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> time = [0.001 * i for i in range(2000)]
    >>> theta = freerock.simulate("housner", block, {"r": 0.93}, time, theta0=0.17).theta
    >>> impacts = freerock.find_impacts(time, theta, 0.0, block, theta0=0.17)
    >>> impacts.restitution[:3].round(4).tolist()
    [0.93, 0.93, 0.93]
    """
    of_kind("block", block, Block, "give freerock.Block(...)")
    motion = _motion(time_s, theta, sigma_theta)
    t, y, least = motion.t, motion.y, motion.noise * limits.min_amplitude_sigmas / 2
    swings = swings_of(y, least)
    short = [np.count_nonzero(np.abs(y[each]) > least[each]) < limits.min_samples for each in swings]
    swings = swings[: [*short, True].index(True)]  # up to the first of too few samples
    known = noise if motion.left.known and len(swings) > 1 else None
    if known:
        known = in_motion(known, y, motion.noise, swings[1:])
        motion = motion._replace(left=left_of(known, swings))
    between = [slice(one.stop - 1, other.start + 1) for one, other in pairwise(swings)]
    passages = [_line_zero(t[each], y[each]) for each in between]
    uplift, rows = uplift_amplitude(t, y, passages, block), np.empty((0, len(IMPACT_COLUMNS)))
    if passages:
        rigid = Rigid(block.theta_cr, block.p)
        start = _release_peak(motion, theta0, theta0_stderr, rigid)
        released = theta0 is not None and abs(theta0) < rigid.theta_cr
        lowest = Lowest(limits.min_amplitude_sigmas, limits.min_uplift_ratio * uplift)
        ends = np.array([(each.start, each.stop - 1) for each in swings])
        rows = impact_rows(motion, ends, np.array(passages), start, released, lowest, rigid)
        rows, fits = rows[:, :6], rows[:, 6:]
        shared = under_noise(rows, fits, motion, known) if known and len(rows) else np.zeros(len(rows))
        rows[:, 5] = np.hypot(rows[:, 5], zero_stderr)
        rows[1:, 3] = rows[:-1, 5]
        shared -= zero_stderr**2  # the peaks are on either side
        before, before_stderr, after, after_stderr = rows[:, 2:6].T
        found = restitution_from_peaks(before, before_stderr, after, after_stderr, block, shared)
        rows = np.column_stack([rows, *found])
    columns = dict(zip(IMPACT_COLUMNS, rows.T.copy(), strict=True))
    return Impacts(theta_uplift=uplift, **columns)


def restitution_from_peaks(
    before: Floats,
    before_stderr: Floats,
    after: Floats,
    after_stderr: Floats,
    block: Block,
    shared: Floats | float = 0.0,
) -> tuple[Floats, Floats]:
    """Restitutions that take one peak of a rigid block to the next, of arrays of one shape.

    r² = (cos φ_after - cos θ_cr)/(cos φ_before - cos θ_cr) with φ = θ_cr - |θ_peak|: the energy integral of
    φ'' = p² sin φ (Housner 1963, doi:10.1785/BSSA0530020403) on either side of the impact, with p and θ_cr of
    that side. Standard error to first order.

    Parameters
    ----------
    before, before_stderr, after, after_stderr : ndarray
        Peak rotations of either sign and their standard errors [rad].
    block : Block
    shared : ndarray or float
        Covariance of the two heights [rad²].

    Returns
    -------
    r, r_stderr : ndarray
        NaN where a peak is zero or beyond θ_cr.
    """
    (energy_0, slope_0), (energy_1, slope_1) = (energy_of_peaks(peaks, block) for peaks in (before, after))
    r = np.sqrt(energy_1 / energy_0)
    by_0, by_1 = slope_0 / energy_0, slope_1 / energy_1
    variance = (by_0 * before_stderr) ** 2 + (by_1 * after_stderr) ** 2 - 2 * by_0 * by_1 * shared
    return r, r / 2 * np.sqrt(np.maximum(variance, 0.0))


def restitution_covariance(impacts: Impacts, block: Block, least: float = 0.0) -> Floats:
    """Covariance of the restitutions, shape (n_impacts, n_impacts): neighbours share a peak.

    The standard error of a peak is taken to be no less than `least` [rad].
    """
    effects = list[Floats]()  # of the peaks before and after
    peaks = (impacts.peak_before_rad, impacts.peak_before_stderr_rad)
    for height, stderr in (peaks, (impacts.peak_after_rad, impacts.peak_after_stderr_rad)):
        energy, slope = energy_of_peaks(height, block)
        effects.append(impacts.restitution / 2 * slope / energy * np.maximum(stderr, least))
    before, after = effects
    shared = -after[:-1] * before[1:]
    covariance = np.diag(before**2 + after**2) + np.diag(shared, 1) + np.diag(shared, -1)
    scale = impacts.restitution_stderr / np.sqrt(np.diag(covariance))  # neighbouring peaks share slow noise
    return np.asarray(covariance * np.outer(scale, scale))


def energy_of_peaks(peaks: Floats, block: Block, tilt: float = 0.0) -> tuple[Floats, Floats]:
    """cos φ - cos θ_cr of peaks, half the squared impact rate over p² of the block, and its derivative.

    They are NaN of a peak that is zero or beyond θ_cr. The base leans by `tilt` to the right [rad].
    """
    theta_cr, p = np.where(peaks > 0, *np.reshape([block.corner(1), block.corner(-1)], (2, 2, 1)))
    height, balance, share = np.abs(peaks), theta_cr - np.sign(peaks) * tilt, (p / block.p) ** 2
    share = np.where((height > 0) & (height < balance), share, np.nan)
    energy = 2 * np.sin(height / 2) * np.sin(balance - height / 2)  # without loss of digits
    return share * energy, share * np.sin(balance - height)


def _motion(time_s: ArrayLike, theta: ArrayLike, sigma_theta: ArrayLike) -> NoisySamples:
    """The samples that are numbers, with their noise; arrays that can't be written to, for compiled loops."""
    t, y = sampled(time_s, theta)
    sigma = np.broadcast_to(np.asarray(sigma_theta, float), y.shape)
    valid = np.isfinite(y) & np.isfinite(sigma)
    if not valid.all():
        t, y, sigma = t[valid], y[valid], sigma[valid]
    noise = np.maximum(sigma, RELATIVE_NOISE * np.abs(y).max(initial=0.0))
    known = bool(np.all(sigma == noise))
    t, y, noise = (np.ascontiguousarray(each).view() for each in (t, y, noise))
    for each in (t, y, noise):
        each.flags.writeable = False
    return NoisySamples(t, y, noise, Residual(1.0, 1.0, known))


def _line_zero(t: Floats, theta: Floats) -> float:
    """Instant at which the straight line through a passage is zero."""
    mean, x = float(t.mean()), t - t.mean()
    slope = float(x @ theta) / float(x @ x)
    return min(max(mean - float(theta.mean()) / slope, t[0]), t[-1]) if slope else mean


def _release_peak(motion: NoisySamples, theta0: float | None, theta0_stderr: float, block: Rigid) -> Peak:
    """The release angle as a peak: its rigid swing meets the data at half its height.

    theta0 and its standard error are in rad, of either sign; None stands for the largest |θ|.
    """
    size = np.abs(motion.y)
    height = min(abs(theta0) if theta0 is not None else float(size.max()), 0.99 * block.theta_cr)
    i = int(np.argmax(size <= height / 2))
    phi = max(block.theta_cr - height, 1e-9)
    k = math.sin(phi / 2)
    ratio = k / math.sin(max(block.theta_cr - float(size[i]), phi) / 2)
    amplitude = math.asin(math.sqrt((1 - ratio**2) / (1 - k * k)))
    fall_s = float(ellipkinc(amplitude, 1 - k * k)) / block.p  # from rest at that height
    return Peak(float(height), float(theta0_stderr), float(motion.t[i] - fall_s), 0.0, 0.0, 1.0)


TAIL_SWINGS = 2  # full contact is believed when this many swings stay in it


def uplift_amplitude(t: Floats, theta: Floats, passages: Sequence[float], block: Block) -> float:
    """Amplitude [rad] under which the base stays in full contact, 0 if no swing is that low.

    The half period T of the tail, which does not depend on amplitude, gives it:
    (2/3) b³ k - m g h = I₀ (π/T)² gives k, hence the static sink m g/(2 b k) and asin(sink/b) (linearised
    no-uplift equations (1)-(2) of Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024).

    Each swing between two passages through zero is tried. Its half period, taken as that of full contact,
    gives an uplift amplitude, and the swing is in full contact if it is lower than that. Any other
    swing gives too small a value (on a rigid base about a quarter of its height), so it excludes itself.
    """
    weight = block.weight
    found = []
    for start, end in pairwise(passages):
        stiffness = block.inertia_base * (math.pi / (end - start)) ** 2 + weight * block.h  # (2/3) b³ k
        sink = weight * block.b**2 / (3 * stiffness)
        uplift = math.asin(min(1.0, sink / block.b))
        swing = slice(*np.searchsorted(t, (start, end)))
        if math.pi / 2 * abs(theta[swing].mean()) < uplift:  # the height of half a sine
            found.append(uplift)
    return float(np.median(found)) if len(found) >= TAIL_SWINGS else 0.0


TYPICAL = 0.5  # of a swing, the window in which a residual is looked at
COARSE = 2  # steps in a factor of two: white noise is white, however its spectrum was drawn


def left_of(noise: Noise, swings: Sequence[slice]) -> Residual:
    """What the fit of a peak leaves of the noise, over what it would if that were white and of variance 1.

    Parameters
    ----------
    noise : Noise
        Over σ.
    swings : sequence of slice
    """
    samples = float(np.median([each.stop - each.start - 1 for each in swings[1:]]))
    together = max(samples / SWING_SAMPLES, 1.0)  # samples in a mean
    n = max(int(min(samples / together, SWING_SAMPLES) * TYPICAL), PEAK_DEGREE + 4)
    covariance = covariance_of_means(noise, together, n) * together
    basis = np.linalg.qr(np.vander(np.linspace(-1, 1, n), PEAK_DEGREE + 1))[0]
    left = covariance - basis @ (basis.T @ covariance)
    left -= (left @ basis) @ basis.T
    freedom = n - PEAK_DEGREE - 1
    trace = float(np.trace(left))
    found = trace / freedom, trace**2 / float(np.sum(left * left)) / freedom
    expected, share = np.exp2(np.rint(COARSE * np.log2(found)) / COARSE).tolist()
    return Residual(expected, share, True)


def under_noise(rows: Floats, fits: Floats, motion: NoisySamples, noise: Noise) -> Floats:
    """Put the standard errors of a run's impacts under its noise; return what neighbouring peaks share.

    A peak is linear in the samples of its window: its error is a weighted sum of their noise.

    Parameters
    ----------
    rows : ndarray, shape (n_impacts, 6)
        As `impact_kernel.impact_rows` gives them; written to.
    fits : ndarray, shape (n_impacts, 4)
        Of the peak after each: instant, half its window [s], degree, loudness.
    motion : NoisySamples
    noise : Noise
        Over σ.

    Returns
    -------
    ndarray, shape (n_impacts,)
        Covariance of the heights of the peaks before and after each impact [rad²].
    """
    first_s, span_s = float(motion.t[0]), 1 / noise.rate_hz
    weights, starts, white = list[Floats](), list[int](), np.empty(len(fits))
    for i, (at, reach, degree, _) in enumerate(fits.tolist()):
        low, high = (round((at + side * reach - first_s) / span_s) for side in (-1, 1))
        high = max(high, low + int(degree) + 4)
        x = np.linspace(-1, 1, high - low)
        sigma = np.interp(first_s + (np.arange(low, high) + 0.5) * span_s, motion.t, motion.noise)
        design = np.vander(x, int(degree) + 1, increasing=True) / sigma[:, None]
        weights.append(np.linalg.solve(design.T @ design, design.T)[0])
        white[i] = float(weights[-1] @ weights[-1]) / noise.averaged
        starts.append(low)
    n = max(len(each) for each in weights)
    n = next_fast_len(n + max([b - a for a, b in pairwise(starts)], default=0))
    pairs = np.zeros((len(weights), 2, n))
    for i, own in enumerate(weights):
        pairs[i, 0, : len(own)] = own
        if i + 1 < len(weights):
            later = starts[i + 1] - starts[i]
            pairs[i, 1, later : later + len(weights[i + 1])] = weights[i + 1]
    covariance = covariance_of_sums(noise, pairs)
    loud = fits[:, 3]
    variance = covariance[:, 0, 0] * loud
    wider = np.sqrt(covariance[:, 0, 0] / white)
    rows[:, 5] = np.sqrt(variance)
    rows[1:, 3] = rows[:-1, 5]
    rows[:, 1] *= wider
    shared = np.zeros(len(rows))
    shared[1:] = -covariance[:-1, 0, 1] * np.sqrt(loud[:-1] * loud[1:])  # the peaks are on either side
    return shared
