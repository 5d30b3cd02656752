"""The release of a block: its instant, the angle it was held at, and whether it was pushed.

The instant is the start of a motion from rest that matches the data after the finger has left, so it does not
depend on how the finger left.
"""

import math
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.rotation.still import Phase
from freerock.runs.limits import RunLimits
from freerock.runs.signal import Signal

FALL, FALL_MOST = 0.25, 0.8  # of θ0: the early motion is fitted until the block has fallen by this
EARLY_SAMPLES = 300  # of the early motion suffice
SURE = 4.0  # standard errors of a push
BLOCK_S, MIN_BLOCKS = 0.025, 4  # means over this long are taken as independent; fewer are no hold


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
    """

    instant_s: float
    stderr_s: float
    push: float
    watched_s: float
    timed: bool = True


class HeldAngle(NamedTuple):
    """Angle before the release, its standard error, and how far it wanders [rad]."""

    theta0: float
    stderr: float
    wander: float


class _EarlyMotion(NamedTuple):
    """Start of a motion [s] and the angle from which it began [rad], with their standard errors."""

    start_s: float
    start_stderr_s: float
    top: float
    top_stderr: float


def find_release(signal: Signal, hold: Phase, end_s: float, limits: RunLimits) -> Release:
    """The release that ends a hold, of a motion that ends at `end_s` [s] of the record.

    The early motion is fitted twice: from the held angle, which gives the instant, and from any angle, which
    shows a push. Where no fit succeeds, the instant is a guess good to `finger_s`.
    """
    first, last = np.searchsorted(signal.t, (hold.mid_s, end_s))
    fallen = 1 - signal.theta[first:last] / hold.level
    early, late, latest = (
        signal.t[first + int(np.argmax(fallen > share))] for share in (FALL / 4, FALL, FALL_MOST)
    )
    finger_s = limits.finger_s
    release = guess = float(2 * early - late)  # a fall grows as time squared
    late = max(late, min(latest, guess + 3 * finger_s))
    for _ in range(3):
        held = held_angle(signal, hold, release, limits)
        near = signal.during(release + finger_s, late)
        motion = signal.t[near] - release, signal.theta[near], signal.sigma[near]
        found = _early_motion(*motion, held.theta0, held.stderr)
        begun = release + found.start_s
        if not abs(begun - guess) < max(finger_s, late - guess):
            return Release(guess, finger_s, 0.0, min(hold.end_s, guess), timed=False)
        moved, release = abs(begun - release), begun
        if moved < 0.1 * found.start_stderr_s:
            break
    free = _early_motion(*motion, held.theta0, math.inf)
    pushed = abs(free.top - held.theta0) > SURE * free.top_stderr
    push = (free.top - held.theta0) / held.theta0 if pushed else 0.0
    timed = not math.isnan(found.start_stderr_s)
    stderr = found.start_stderr_s if timed else finger_s
    return Release(release, stderr, push, min(hold.end_s, release), timed)


def held_angle(signal: Signal, hold: Phase, release_s: float, limits: RunLimits) -> HeldAngle:
    """Held angle over the last part of a hold; of the whole hold where that is too short."""
    end = release_s - limits.finger_s
    held = held_over(signal, max(hold.start_s, end - limits.held_s), end)
    return held or HeldAngle(hold.level, hold.level_stderr, 0.0)


def held_over(signal: Signal, start_s: float, end_s: float) -> HeldAngle | None:
    """Held angle, its standard error and how far it wanders [rad], from one instant to another [s].

    Where means over `BLOCK_S` scatter clearly more than white noise would, the block moved, and may have
    been released from anywhere within that motion. None of fewer than `MIN_BLOCKS` such means.
    """
    near = signal.during(start_s, end_s)
    held = signal.theta[near][np.isfinite(signal.theta[near])]
    size = max(1, round(BLOCK_S / (signal.t[1] - signal.t[0])))
    n = held.size // size
    if n < MIN_BLOCKS:
        return None
    means = held[held.size - n * size :].reshape(n, size).mean(axis=1)
    variance, white = np.var(means, ddof=1), np.nanmean(signal.sigma[near]) ** 2 / size
    stderr = math.sqrt(variance / n + (variance if variance > 3 * white else 0.0))
    return HeldAngle(float(held.mean()), stderr, float(np.ptp(means)))


def _early_motion(
    t: Floats, theta: Floats, sigma: Floats, theta0: float, theta0_stderr: float
) -> _EarlyMotion:
    """Fit θ = θ_top - a/q² (cosh q(t - t0) - 1): t0 and θ_top.

    That is any conservative motion from rest at θ_top to fourth order in t - t0; a and q stay free, so that
    neither a compliant base nor a width other than nominal matters. NaN where the fit fails.
    """
    from scipy.optimize import leastsq  # a fifth of a second, and most jobs only read what was found

    valid = np.isfinite(theta) & np.isfinite(sigma)
    t, theta, noise = t[valid], theta[valid], np.maximum(sigma[valid], 1e-6 * abs(theta0))
    if t.size < 6:
        return _EarlyMotion(math.nan, math.nan, math.nan, math.nan)
    together = -(-t.size // EARLY_SAMPLES)  # samples in one mean: so short a time is straight
    n = t.size // together * together
    t, theta, noise = (x[:n].reshape(-1, together).mean(axis=1) for x in (t, theta, noise))
    noise = noise / math.sqrt(together)
    held = max(theta0_stderr, 1e-9 * abs(theta0))

    def residual(x: Floats) -> Floats:
        top, pull, q, t0 = x
        left = np.empty(t.size + 1)
        model = theta0 + top - pull / q**2 * (np.cosh(_bounded(q * (t - t0))) - 1)
        np.divide(model - theta, noise, out=left[:-1])
        left[-1] = top / held
        return left

    def slopes(x: Floats) -> Floats:
        _, pull, q, t0 = x
        since = t - t0
        angle = _bounded(q * since)
        fallen, rate = (np.cosh(angle) - 1) / q**2, np.sinh(angle) / q
        by = np.empty((4, t.size + 1))
        by[0, :-1], by[1, :-1] = 1.0, -fallen
        by[2, :-1], by[3, :-1] = pull * (2 * fallen - rate * since) / q, pull * rate
        by[:, :-1] /= noise
        by[:, -1] = 1 / held, 0, 0, 0
        return by

    guess = (0.0, FALL * theta0 / 0.5 / t[-1] ** 2, 1 / t[-1], 0.0)
    x, *_ = leastsq(residual, guess, Dfun=slopes, col_deriv=True, full_output=True)
    scale = max(1.0, float(np.sum(residual(x) ** 2)) / (t.size - len(guess)))
    by = slopes(x)
    stderr = np.sqrt(scale * np.diag(np.linalg.pinv(by @ by.T)))
    return _EarlyMotion(x[3], stderr[3], theta0 + x[0], stderr[0])


def _bounded(angle: Floats) -> Floats:
    """The argument of a cosh, within what a search may try."""
    return np.asarray(np.minimum(np.maximum(angle, -20.0), 20.0))
