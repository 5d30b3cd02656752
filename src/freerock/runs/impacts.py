"""Impacts in the θ(t) of a run: their instants, the peaks between them, the restitution of each.

Measured and computed motions go the same way.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.runs.limits import OF_IMPACTS, ImpactLimits
from freerock.runs.peaks import UNKNOWN, Rigid, Samples, averaged, fit_peak, release_peak
from freerock.runs.rates_at_impact import impact_time, rate_ratio, side_of
from freerock.runs.uplift import uplift_amplitude
from freerock.runs.verdict import Reason

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
    restitution_rate, restitution_rate_stderr : ndarray
        Cross-check: the angular rate after over that before, both extrapolated to the impact from where the
        base is uplifted. NaN where that leaves a rate uncertain by a third or more.
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
    restitution_rate: Floats
    restitution_rate_stderr: Floats
    theta_uplift: float


COLUMNS = [field.name for field in fields(Impacts) if field.name != "theta_uplift"]


def find_impacts(
    time_s: ArrayLike,
    theta: ArrayLike,
    sigma_theta: ArrayLike,
    block: Block,
    *,
    theta0: float | None = None,
    theta0_stderr: float = 0.0,
    limits: ImpactLimits = OF_IMPACTS,
) -> Impacts:
    """Find the impacts of one run, measured or computed.

    The list ends at the first peak that is too low: less than `min_amplitude_sigmas` times σ_θ, or than
    `min_uplift_ratio` times the amplitude under which the base stays in full contact (`uplift`). On a Winkler
    bed a block turned by θ touches along sqrt(θ_uplift/θ) of its base: at twice the uplift amplitude still
    along 71 %. Lower swings dissipate all the time rather than in impacts, and r is no property of an impact
    (`doubt_about`).

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
        Release angle, of either sign, and its standard error [rad]: the peak before the first impact.
        Without it, or from θ_cr on, that peak and the first restitutions are NaN.
    limits : ImpactLimits, optional

    Returns
    -------
    Impacts
        Empty arrays where no impact stands out.
    """
    motion = _motion(time_s, theta, sigma_theta)
    swings = _swings(motion, limits)
    passages = [_line_zero(motion.t[i : j + 1], motion.y[i : j + 1]) for (_, i), (j, _) in pairwise(swings)]
    uplift = uplift_amplitude(motion.t, motion.y, passages, block)
    rows = _rows(motion, swings, passages, (theta0, theta0_stderr), uplift, block, limits)
    columns = dict(zip(COLUMNS, np.array(rows).reshape(-1, len(COLUMNS)).T, strict=True))
    return Impacts(theta_uplift=uplift, **columns)


def doubt_about(impacts: Impacts, limits: ImpactLimits = OF_IMPACTS) -> list[Reason]:
    """A warning where no restitution per impact is meaningful: no swing clearly leaves full contact."""
    if impacts.time_s.size or not impacts.theta_uplift:
        return []
    text = (
        f"per-impact r is not meaningful here: no swing exceeds {limits.min_uplift_ratio:g} times the "
        f"{math.degrees(impacts.theta_uplift):.2f}° up to which the base stays in full contact"
    )
    return [Reason("warn", "no_restitution", text)]


def restitution_from_peaks(
    before: float, before_stderr: float, after: float, after_stderr: float, block: Block | Rigid
) -> tuple[float, float]:
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


def restitution_covariance(impacts: Impacts, block: Block) -> Floats:
    """Covariance of the restitutions, shape (n_impacts, n_impacts): neighbours share a peak."""

    def by(peaks: Floats, stderrs: Floats) -> Floats:
        energy, slope = np.reshape([_energy(abs(peak), block) for peak in peaks], (-1, 2)).T
        return np.asarray(impacts.restitution / 2 * slope / energy * stderrs)

    before = by(impacts.peak_before_rad, impacts.peak_before_stderr_rad)
    after = by(impacts.peak_after_rad, impacts.peak_after_stderr_rad)
    shared = -after[:-1] * before[1:]
    return np.asarray(np.diag(before**2 + after**2) + np.diag(shared, 1) + np.diag(shared, -1))


def _energy(height: float, block: Block | Rigid) -> tuple[float, float]:
    """cos φ - cos θ_cr of a peak, half the squared impact rate over p², and its derivative by the height."""
    if not 0 < height < block.theta_cr:
        return math.nan, math.nan
    energy = 2 * math.sin(height / 2) * math.sin(block.theta_cr - height / 2)  # without loss of digits
    return energy, math.sin(block.theta_cr - height)


def _motion(time_s: ArrayLike, theta: ArrayLike, sigma_theta: ArrayLike) -> Samples:
    """The samples that are numbers, with their noise."""
    t, y, sigma = (np.asarray(x, float) for x in np.broadcast_arrays(time_s, theta, sigma_theta))
    valid = np.isfinite(y) & np.isfinite(sigma)
    if not valid.all():
        t, y, sigma = t[valid], y[valid], sigma[valid]
    noise = np.maximum(sigma, RELATIVE_NOISE * np.abs(y).max(initial=0.0))
    return Samples(t, y, noise, noise_known=bool(np.all(sigma == noise)))


def _swings(motion: Samples, limits: ImpactLimits) -> list[tuple[int, int]]:
    """First and last index of the stretches in which θ stands out of the noise with one sign."""
    index = np.flatnonzero(np.abs(motion.y) > motion.noise * limits.min_amplitude_sigmas / 2)
    if index.size == 0:
        return []
    positive = motion.y[index] > 0
    first = np.concatenate(([0], np.flatnonzero(positive[1:] != positive[:-1]) + 1))
    last = np.concatenate((first[1:], [index.size])) - 1
    short = np.flatnonzero(last - first + 1 < limits.min_samples)
    n = short[0] if short.size else first.size
    return list(zip(index[first[:n]].tolist(), index[last[:n]].tolist(), strict=True))


def _line_zero(t: Floats, theta: Floats) -> float:
    """Instant at which the straight line through a passage is zero."""
    mean, x = float(t.mean()), t - t.mean()
    slope = float(x @ theta) / float(x @ x)
    return min(max(mean - float(theta.mean()) / slope, t[0]), t[-1]) if slope else mean


def _rows(
    motion: Samples,
    swings: Sequence[tuple[int, int]],
    passages: Sequence[float],
    release: tuple[float | None, float],
    uplift: float,
    block: Block,
    limits: ImpactLimits,
) -> list[tuple[float, ...]]:
    """The impacts one by one, as values of `Impacts`; release holds its angle and standard error."""
    if not passages:
        return []
    rows: list[tuple[float, ...]] = []
    rigid, theta0 = Rigid(block.theta_cr, block.p), release[0]
    before = release_peak(motion, *release, rigid)
    bounds = [swings[0][0], *np.searchsorted(motion.t, passages), swings[-1][1] + 1]
    previous = averaged(motion, slice(*bounds[:2]), rigid)
    for (first, last), passage, until in zip(swings[1:], passages, bounds[2:], strict=True):
        if last == len(motion.t) - 1:
            break  # the record ends before the swing does
        one = motion.noise[first : last + 1].mean()
        swing = averaged(motion, slice(np.searchsorted(motion.t, passage), until), rigid)
        ends = motion.t[first], motion.t[last] + np.finfo(float).eps
        after = fit_peak(swing.part(slice(*np.searchsorted(swing.t, ends))), one, rigid)
        lowest = max(limits.min_amplitude_sigmas * one, limits.min_uplift_ratio * uplift)
        if not lowest <= after.height < rigid.theta_cr:
            break
        sides = side_of(previous, passage, before, -1, rigid), side_of(swing, passage, after, 1, rigid)
        instant = impact_time(sides, passage, rigid)
        rates = rate_ratio(sides, instant[0], uplift, rigid)
        if not rows and (theta0 is None or abs(theta0) >= rigid.theta_cr):
            before, rates = UNKNOWN, (math.nan, math.nan)
        sign = np.sign(motion.y[first])
        peaks = -sign * before.height, before.stderr, sign * after.height, after.stderr
        r = restitution_from_peaks(before.height, before.stderr, after.height, after.stderr, rigid)
        rows.append((*instant, *peaks, *r, *rates))
        before, previous = after, swing
    return rows
