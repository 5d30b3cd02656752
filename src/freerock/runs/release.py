"""The release of a block: its instant, the angle it was held at, and whether it was pushed.

The instant is the start of a motion from rest that matches the data after the finger has left, so it does not
depend on how the finger left.
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from freerock.arrays import Floats, Indices, Mask
from freerock.config.processing import RunLimits
from freerock.noise.rotation_noise import HIGH_SWING, in_motion
from freerock.noise.spectrum import Noise, covariance_of_sums, stderr_of_mean, unsure_of_sum
from freerock.noise.still_phases import BLOCKS_PER_WINDOW, Phase, swings_of
from freerock.runs.signal import Signal

FALL, FALL_MOST = 0.25, 0.8  # of θ0: the early motion is fitted until the block has fallen by this
PASSES = 2  # from the guess: the windows of the second are those of the release within a few of its errors
FEWEST = 6  # means of the early motion that give an instant
SEARCH_S = 0.005  # medians over this long show when the block falls, whatever stands out of the noise
SWINGS = 8  # so many tell the noise in motion
SURE = 4.0  # standard errors of a push
FAR = 0.1  # of θ0, off the hold: how far a fit looks for the release
FLED = 2.0  # of θ0, off the hold: a fit that ends further has not found it
HOLD_BLOCK_S = 0.025  # a hold shows in means over this long whether it moves
MIN_BLOCKS = 4  # fewer of them are no hold
QUICK = 0.3  # of the noise's variance at least must be within such means, to tell how loud a hold is
MOVES = 3.0  # times the variance of such means by noise alone, from which the block moves
SAG, FADES = (0.25 - 2 / math.pi**2) / 2, 3.0  # of `lowered`; its T is such a part of finger_s
EXACT = 1e-6  # relative accuracy of the fit
HUBER = 4.0  # standard deviations beyond which a mean counts less (Huber 1964, doi:10.1214/aoms/1177703732)


class Release(NamedTuple):
    """A release.

    Parameters
    ----------
    instant_s, stderr_s : float
        Instant at which the motion began, and its standard error [s].
    push : float
        Share of θ0 by which the motion began higher; 0 where that is not significant.
    watched_s : float
        From here on invalid samples count [s].
    timed : bool
        Whether the early motion gave the instant.
    top_off : float
        By how much the motion began off the held angle, as a standard uncertainty [rad]: a hand that
        trembles leaves slowly, and lets go elsewhere. 0 after a steady hold.
    """

    instant_s: float
    stderr_s: float
    push: float
    watched_s: float
    timed: bool = True
    top_off: float = 0.0


class HeldAngle(NamedTuple):
    """Angle before the release, its standard error, how far it wanders, and by what it moves [rad].

    The last is a standard deviation. Both are 0 where the noise explains what is seen.
    """

    theta0: float
    stderr: float
    wander: float
    moved: float = 0.0


class _EarlyMotion(NamedTuple):
    """Start of a motion [s] and by how much it began above the held angle [rad], with standard errors."""

    start_s: float
    start_stderr_s: float
    above: float
    above_stderr: float
    numbers: Floats | None = None


class _Means(NamedTuple):
    """Means of samples: time since the release [s], θ and its σ [rad], number, whether early."""

    t: Floats
    theta: Floats
    sigma: Floats
    place: Indices
    early: Mask


def lowered(acceleration: float, finger_s: float) -> float:
    """By what a finger, of which only so much is known, may lower θ_top [rad]; acceleration in rad/s².

    A support that fades as (1 + cos)/2 over T takes as much energy as (1/4 - 2/π²)/2 a T² of height.
    """
    return SAG * abs(acceleration) * (finger_s / FADES) ** 2


def find_release(signal: Signal, hold: Phase, end_s: float, limits: RunLimits) -> Release:
    """The release that ends a hold, of a motion that ends at `end_s` [s] of the record.

    The early motion is fitted twice: from the held angle, which gives the instant, and from any angle, which
    shows a push. Where no fit succeeds, the instant is a guess good to `finger_s`.
    """
    early, late, latest = _falls(signal, hold, end_s)
    noise, during = signal.relative_noise, signal.during(hold.end_s, end_s)
    theta, sigma = signal.theta[during], signal.sigma[during]
    known = sigma[np.isfinite(sigma)]
    lowest = HIGH_SWING * math.sqrt(noise.variance) * float(np.median(known)) if known.size else 0.0
    if lowest:  # as loud as it is while the block swings
        noise = in_motion(noise, theta, sigma, swings_of(theta, lowest)[1 : SWINGS + 1])
    finger_s = limits.finger_s
    release = guess = float(2 * early - late)  # a fall grows as time squared
    late, start = max(late, min(latest, guess + 3 * finger_s)), None
    for last in range(1 - PASSES, 1):
        held = held_angle(signal, hold, release, limits)
        since_s = max(hold.start_s + limits.window_s / BLOCKS_PER_WINDOW, release - finger_s - limits.held_s)
        means = _means(signal, (since_s, release - finger_s), (release + finger_s, late), release)
        leaves = lowered(FALL * held.theta0 / 0.5 / max(late - release, finger_s) ** 2, finger_s)
        found = _early_motion(means, noise, held, math.hypot(held.moved, leaves), start, errors=not last)
        start = found.numbers
        begun = release + found.start_s
        if not abs(begun - guess) < max(finger_s, late - guess):
            return Release(guess, finger_s, 0.0, min(hold.end_s, guess), timed=False)
        release = begun
    free = _early_motion(means, noise, held, math.inf)
    trembles = held.moved > 0 and abs(free.above) < FAR * abs(held.theta0)
    top_off = math.hypot(free.above, free.above_stderr) if trembles else 0.0
    if top_off > math.hypot(held.moved, leaves):
        found = _early_motion(means, noise, held, top_off, start)
        release += found.start_s
    pushed = SURE * free.above_stderr < abs(free.above) < FLED * abs(held.theta0)
    push = free.above / held.theta0 if pushed else 0.0
    timed = not math.isnan(found.start_stderr_s)
    stderr = found.start_stderr_s if timed else finger_s
    return Release(release, stderr, push, min(hold.end_s, release), timed, top_off)


def _falls(signal: Signal, hold: Phase, end_s: float) -> tuple[float, float, float]:
    """When a block has fallen by a quarter of `FALL`, by `FALL` and by `FALL_MOST` of its held angle [s].

    Medians of some samples tell: of heavy-tailed noise a single one may seem one long before the release.
    """
    first, last = np.searchsorted(signal.t, (hold.mid_s, end_s)).tolist()
    size = max(1, min(round(SEARCH_S / signal.step_s), (last - first) // 8))
    theta = signal.theta[first : first + (last - first) // size * size].reshape(-1, size)
    fallen = 1 - np.median(theta, axis=1) / hold.level  # not a number where a sample is invalid
    found = []
    for share in (FALL / 4, FALL, FALL_MOST):
        i = int(np.argmax(fallen > share))
        near = slice(first + max(i - 1, 0) * size, first + (i + 1) * size)
        samples = 1 - signal.theta[near] / hold.level
        # from which sample on most are above: where fewest are below it after and above it before
        above = np.concatenate([[0], np.cumsum(samples > share)])
        below = np.concatenate([[0], np.cumsum(~(samples > share))])
        found.append(float(signal.t[near][np.argmin(above[:-1] + below[-1] - below[:-1])]))
    early, late, latest = found
    return early, late, latest


def held_angle(signal: Signal, hold: Phase, release_s: float, limits: RunLimits) -> HeldAngle:
    """Held angle over the last part of a hold; of the whole hold where that is too short."""
    end, since = release_s - limits.finger_s, hold.start_s + limits.window_s / BLOCKS_PER_WINDOW
    held = held_over(signal, max(since, end - limits.held_s), end)
    return held or HeldAngle(hold.level, hold.level_stderr, 0.0)


def held_over(signal: Signal, start_s: float, end_s: float) -> HeldAngle | None:
    """Held angle, its standard error and how far it wanders [rad], from one instant to another [s].

    The standard error is that of the mean under the noise. Where means over `HOLD_BLOCK_S` scatter clearly
    more than that would, the block moved, and may have been released from anywhere within that motion. None
    of fewer than `MIN_BLOCKS` such means.
    """
    near = signal.during(start_s, end_s)
    held = signal.theta[near][np.isfinite(signal.theta[near])]
    size = max(1, round(HOLD_BLOCK_S / signal.step_s))
    n = held.size // size
    if n < MIN_BLOCKS:
        return None
    blocks = held[held.size - n * size :].reshape(n, size)
    means, noise, sigma = blocks.mean(axis=1), signal.relative_noise, float(np.nanmean(signal.sigma[near]))
    together = max(1, round(size / noise.averaged))
    of_mean, of_all = (stderr_of_mean(noise, k) ** 2 for k in (together, max(1, held.size // noise.averaged)))
    within = max(noise.variance - of_mean, QUICK * noise.variance)  # of such a mean
    seen = float(np.mean(blocks.var(axis=1)))
    loud = max(seen / within if within > 0 else 0.0, sigma**2)  # a hold may be louder than a rest
    variance = float(np.var(means, ddof=1))
    moves = variance > MOVES * loud * (of_mean - of_all)
    whole, moved = math.sqrt(loud * of_all + sigma**2 * noise.stuck), math.sqrt(variance) if moves else 0.0
    stderr = max(whole, math.sqrt(variance / n)) if moves else whole
    wander = float(np.ptp(means)) if moves else 0.0
    return HeldAngle(float(held.mean()), math.hypot(stderr, moved), wander, moved)


def _means(
    signal: Signal, held_s: tuple[float, float], early_s: tuple[float, float], release_s: float
) -> _Means:
    """Means of samples of the hold and of the early motion, as many together as its noise takes."""
    size = signal.relative_noise.averaged
    first, last = np.searchsorted(signal.t, (held_s[0], early_s[1])).tolist()
    n = (last - first) // size
    part = slice(first, first + n * size)
    t, theta, sigma = (x[part].reshape(n, size).mean(axis=1) for x in (signal.t, signal.theta, signal.sigma))
    half = signal.step_s * size / 2
    held, early = t < held_s[1] - half, t > early_s[0] + half
    known = np.isfinite(theta) & np.isfinite(sigma) & (held | early)
    found = _Means(t - release_s, theta, sigma, np.arange(n), early)
    return _Means(*(x[known] for x in found))


class _Fall(NamedTuple):
    """Means of a hold and of the early motion after it, with what is known of both.

    Of θ_top less the level `moved` is the standard deviation [rad]. `factor` is Cholesky's, of the covariance
    of the means over σ.
    """

    means: _Means
    factor: Floats
    theta0: float
    moved: float

    def residual(self, x: Floats, weight: Floats, slopes: bool = False) -> Floats:
        """Residual by five numbers, shape (n_means + 1,), or its derivatives, shape (n_means + 1, 5).

        A level holds before the release, and θ = θ_top - a/q² (cosh q(t - t0) - 1) after it. That is any
        conservative motion from rest at θ_top to fourth order in t - t0; a and q stay free, so that neither a
        compliant base nor a width other than nominal matters. The numbers are the level less θ0, θ_top less
        the level, a, q and t0. Residuals are in standard deviations of what the noise brings that is new,
        times the weight of each mean; the last is the distance of θ_top from the level.
        """
        (t, theta, sigma, _, early), (level, above, pull, q, t0) = self.means, x
        since = np.where(early, t - t0, 0.0)
        angle = np.minimum(np.maximum(q * since, -20.0), 20.0)  # within what a search may try
        fallen = (np.cosh(angle) - 1) / q**2
        columns = (self.theta0 + level + early * above - pull * fallen - theta)[:, None]
        if slopes:
            rate = np.sinh(angle) / q
            by_q = pull * (2 * fallen - rate * since) / q
            columns = np.column_stack([np.ones(t.size), early, -fallen, by_q, pull * rate])
        seen = solve_triangular(self.factor, columns / sigma[:, None], lower=True) * weight[:, None]
        if slopes:
            return np.vstack([seen, [0, 1 / self.moved, 0, 0, 0]])
        return np.append(seen, above / self.moved)


def _early_motion(
    means: _Means,
    noise: Noise,
    held: HeldAngle,
    moved: float,
    start: Floats | None = None,
    errors: bool = True,
) -> _EarlyMotion:
    """Start and height of the early motion by generalised least squares; NaN where the fit fails.

    Weights are those of the noise's law. Standard errors are by all that is known of the noise, and larger
    where the early motion is louder. A mean far off counts less.

    Parameters
    ----------
    means : _Means
    noise : Noise
        Over σ.
    held : HeldAngle
    moved : float
        Standard deviation of θ_top about the held angle [rad]; infinite where it may be any.
    start : ndarray, optional
        Numbers of `_Fall` to begin with.
    errors : bool
        Whether standard errors are computed; else they are not numbers.
    """
    from scipy.optimize import leastsq  # a fifth of a second, and most jobs only read what was found

    t, _, sigma, place, early = means
    if np.count_nonzero(early) < FEWEST:
        return _EarlyMotion(math.nan, math.nan, math.nan, math.nan)
    size = abs(held.theta0)
    means = means._replace(sigma=np.maximum(sigma, 1e-6 * size))
    factor = np.asarray(np.linalg.cholesky(noise.by_law(place)), float)
    fall = _Fall(means, factor, held.theta0, max(moved, 1e-9 * size))
    pull, weight = FALL * held.theta0 / 0.5 / t[-1] ** 2, np.ones(t.size)
    x = np.array([0.0, 0.0, pull, 1 / t[-1], 0.0]) if start is None else start
    slopes = partial(fall.residual, slopes=True)
    for _ in range(2):
        x, *_ = leastsq(fall.residual, x, (weight,), Dfun=slopes, full_output=True, ftol=EXACT, xtol=EXACT)
        left = fall.residual(x, weight)[:-1]
        off = np.abs(left / weight) / max(1.0, float(1.4826 * np.median(np.abs(left[early]))))
        if off.max() < HUBER:
            break
        weight = np.minimum(1.0, np.sqrt(HUBER / np.maximum(off, HUBER)))
    numbers = np.array([*x[:3], max(abs(x[3]), 1 / t[-1]), 0.0])
    if not errors:
        return _EarlyMotion(x[4], math.nan, x[1], math.nan, numbers)
    by = slopes(x, weight)
    scale = np.linalg.norm(by, axis=0)
    inverse = np.linalg.pinv((by / scale).T @ (by / scale)) / np.outer(scale, scale)
    influence = np.zeros((5, int(place[-1]) + 1))
    influence[:, place] = solve_triangular(factor, by[:-1] * weight[:, None] @ inverse, trans=1, lower=True).T
    variance = np.diag(covariance_of_sums(noise, influence)) + (inverse[:, 1] / fall.moved) ** 2
    variance += noise.stuck * influence[:, place[~early]].sum(axis=1) ** 2
    loud = max(1.0, float(np.sum(left[early] ** 2)) / (np.count_nonzero(early) - 3))
    stderr = np.sqrt(loud * variance) * unsure_of_sum(noise, influence[4])
    return _EarlyMotion(x[4], stderr[4], x[1], stderr[1], numbers)
