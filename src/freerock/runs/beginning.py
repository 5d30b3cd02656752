"""Where a run begins: at the release from a hold, or at the first clean peak where no hold is seen.

A block that falls freely from rest only gets faster until its first passage through zero. What comes before
its last rest, or before it was slowest, is not free rocking.
"""

import math
from bisect import bisect
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.config.correction_cells import Override
from freerock.config.processing import RunLimits
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.noise.spectrum import covariance_of_sums
from freerock.noise.still_phases import MIN_PEAKS, UNSTEADY, Phase, stationary_phases, stretches, swings_of
from freerock.runs.release import (
    FALL_MOST,
    FAR,
    HOLD_BLOCK_S,
    MIN_BLOCKS,
    HeldAngle,
    Release,
    find_release,
    held_angle,
    held_over,
)
from freerock.runs.signal import Signal, invalid_in, names_of
from freerock.runs.verdict import Reason

MOVES = 0.02  # of the critical angle: a signal that sweeps less is of no release


def find_holds(signal: Signal, steady: Sequence[Phase], window_s: float) -> list[Phase]:
    """Phases that end with a release: the steady ones, and those too unsteady to be among them."""
    loose = stationary_phases(signal.t, signal.theta, window_s=window_s, floor_fraction=UNSTEADY)
    holds: list[Phase] = []  # in the order of time, and apart
    for phase in [*steady, *loose]:
        at = bisect(holds, phase.start_s, key=lambda hold: hold.start_s)
        beside = holds[max(at - 1, 0) : at + 1]
        apart = all(phase.end_s < hold.start_s or phase.start_s > hold.end_s for hold in beside)
        if phase.kind == "held" and phase.level and apart:
            holds.insert(at, phase)
    return holds


def no_release(phases: Sequence[Phase], block: Block | None, signal: Signal) -> FreerockError:
    """The error of a record without a release, with what can be said of it."""
    remedy = "check that the channel, its coupling (DC), the sign and the laser are those of this record"
    if not phases:
        what, remedy = "no release found: the signal never stands still", "record a rest and a held phase"
    else:
        held = max((phase.level for phase in phases), key=abs)
        swept = float(np.nanmax(signal.theta) - np.nanmin(signal.theta))
        what = "no release found: nowhere is the block held, let go and left to rock to rest"
        if block is not None and abs(held) >= block.theta_cr:
            what = (
                f"no release found: held at {math.degrees(held):.2f}°, beyond the block's critical angle "
                f"{math.degrees(block.theta_cr):.2f}°, it overturns"
            )
            remedy = "check the block's height and width and the laser's position"
        elif block is not None and swept < MOVES * block.theta_cr:
            what = f"nothing moves: the signal stays within {math.degrees(swept):.2g}°"
    invalid = invalid_in(signal, 0.02)
    if invalid and "overturns" not in what:
        what += f", {invalid}"
    return FreerockError("record", what, remedy)


# By judgement, between free falls and brakes by half. Of 96 falls on which none was set (60 clean ones, slow
# fingers, pushes, bases off level) none is slower than before by more than 4 % or 1.2 standard errors.
STEP_S = 0.01  # angular rates are differences of means over this long
SURE = 8.0  # standard errors by which a rate falls
SLOWER = 0.3  # of the rate before, likewise
STANDS = 0.1  # of the rate before: so slow a block stands
SHORTEST_S = 0.05  # in which a block that stands shows the angle it is let go from
HAND_S, FEWEST_RATES = 1.0, 10  # of a hold, over so long and from so many rates, a hand's tremor is seen


class Stop(NamedTuple):
    """Where a falling block was stopped or slowed.

    Parameters
    ----------
    start_s, end_s : float
        From when to when it stood, or was slow [s].
    fallen : float
        How far it had fallen [rad].
    hold : Phase or None
        Where it stood, long enough to be let go from there.
    """

    start_s: float
    end_s: float
    fallen: float
    hold: Phase | None


def find_stop(signal: Signal, hold: Phase, end_s: float) -> Stop | None:
    """The last stop between a hold and the first passage through zero; None of a block that falls freely."""
    during = signal.during(hold.end_s, end_s)
    t, theta = signal.t[during], signal.theta[during]
    fallen = 1 - theta / hold.level
    low = np.flatnonzero(fallen > FALL_MOST)
    size = max(1, round(STEP_S / (signal.t[1] - signal.t[0])))
    n = (low[0] if low.size else 0) // size
    if n < 4:
        return None
    means = theta[: n * size].reshape(n, size).mean(axis=1)  # NaN where a sample is invalid: no rate
    whole, spectrum = max(1, round(size / signal.relative_noise.averaged)), signal.relative_noise
    rate = covariance_of_sums(spectrum, np.repeat([[-1.0, 1.0]], whole, axis=1) / whole)[0, 0]
    stderr = float(np.sqrt(rate * whole * spectrum.averaged / size))  # of the difference of two means, over σ
    # a hand that trembles moves the block up and down before it leaves, which is no stop
    hand = signal.theta[signal.during(max(hold.mid_s, hold.end_s - HAND_S), hold.end_s)]
    hand = hand[: hand.size // size * size].reshape(-1, size).mean(axis=1)
    rates, hand = (each[np.isfinite(each)] for each in (np.diff(hand), hand))
    seen = rates.size >= FEWEST_RATES
    shakes, shaken = (float(np.sqrt(np.mean(rates**2))), float(np.std(hand))) if seen else (0.0, 0.0)
    noise = max(float(np.nanmedian(signal.sigma[during][: n * size])) * stderr, shakes)
    falls = -np.sign(hold.level) * np.diff(means)
    fastest = np.fmax.accumulate(np.nan_to_num(falls))
    slower = fastest - falls > np.maximum(SURE * noise, SLOWER * fastest)
    spans = stretches(slower)
    if not spans:
        return None
    first, last = spans[-1]
    stop = _stop(t, means, falls, size, first, last, STANDS * fastest[first] + SURE / 2 * noise)
    fallen_by = abs(stop.fallen - hold.level)
    return stop._replace(fallen=fallen_by) if fallen_by > SURE * shaken else None


def _stop(t: Floats, means: Floats, falls: Floats, size: int, first: int, last: int, slow: float) -> Stop:
    """A stop among means of `size` samples, where they fall by less than `slow` from one to the next; its
    `fallen` is the angle at which it begins."""
    lowest = first + int(np.argmin(falls[first : last + 1]))
    stands = [span for span in stretches(np.abs(falls) < slow) if first <= span[0] and span[0] <= last]
    start, end = stands[-1] if stands else (lowest, lowest)
    start_s, end_s = float(t[start * size]), float(t[(end + 2) * size - 1])
    fallen = float(means[start])
    if not stands or end_s - start_s < SHORTEST_S:
        return Stop(start_s, end_s, fallen, None)
    level = means[start : max(end, start + 2)]  # without those in which it may be free again
    stderr = float(np.std(level, ddof=1) / np.sqrt(level.size))
    return Stop(start_s, end_s, fallen, Phase(start_s, end_s, float(level.mean()), stderr, "held"))


STANDS_OUT = 5.0  # standard deviations of the noise, from which on a swing is one
MIDDLE = 0.2  # of a swing on either side is left out where its top is looked for
TOP_STDERR_S = 2e-3  # of the instant of a top
TOP_STDERR = 2e-3  # of its height, as a share


class Top(NamedTuple):
    """The top of a swing: when [s], how high with its sign [rad], from when to when the swing lasts [s]."""

    time_s: float
    height: float
    start_s: float
    end_s: float


def find_tops(time_s: Floats, theta: Floats, sigma_theta: float, lowest: float) -> list[Top]:
    """The tops of the swings after the first, as long as they are higher than `lowest` [rad].

    Time [s] and rotation [rad] of shape (n_time,), NaN where unknown; sigma_theta is the standard deviation
    of the noise [rad].
    """
    known = np.isfinite(theta)
    t, theta = time_s[known], theta[known]
    begins = [each.start for each in swings_of(theta, STANDS_OUT * sigma_theta)[1:]]
    found = []
    for first, last in pairwise(begins):
        margin = int(MIDDLE * (last - first))
        instants, arc = t[first + margin : last - margin], theta[first + margin : last - margin]
        if instants.size < 6:
            break
        fitted = np.polynomial.Polynomial.fit(instants, arc, 4)(instants)
        top = int(np.argmax(np.abs(fitted)))
        if abs(fitted[top]) < lowest:
            break
        found.append(Top(float(instants[top]), float(fitted[top]), float(t[first]), float(t[last])))
    return found


HOLD_OF = f"give a hold window with {MIN_BLOCKS * HOLD_BLOCK_S:g} s of valid samples or more"
FROM_PEAK = "the run begins at its first clean peak"
LEAVE_OUT = "the motion before is not free rocking; exclude the run, or set its release by hand"
LEAST_PEAK = 0.2  # of the largest angle seen, by judgement: a run that begins lower says little


class Beginning(NamedTuple):
    """How a run begins.

    Parameters
    ----------
    hold_start_s : float
        From here on it is held [s].
    release : Release
    held : HeldAngle
    fit_start_s : float
        First instant that a fit uses [s].
    reasons : tuple of Reason
        What speaks against it.
    """

    hold_start_s: float
    release: Release
    held: HeldAngle
    fit_start_s: float
    reasons: tuple[Reason, ...] = ()


def from_hold(signal: Signal, hold: Phase, end_s: float, limits: RunLimits) -> Beginning:
    """A run that begins with the release from a hold and ends at an instant [s].

    Where the block was stopped on its way, it begins there. Where it was only slowed, or its motion is far
    from one that is let go from the hold, it begins at its first clean peak.
    """
    stop, reasons = find_stop(signal, hold, end_s), list[Reason]()
    if stop:
        fell = f"it fell by {math.degrees(stop.fallen):.2f}° and"
        if stop.hold:
            hold, text = stop.hold, f"{fell} stood still until {stop.end_s:.2f} s: the run begins there"
            reasons.append(Reason.of("let_go_again", text))
        elif peak := from_peak(signal, stop.end_s, end_s, limits):
            text = f"{fell} was braked at {stop.start_s:.2f} s: the run begins at its first clean peak"
            return peak._replace(reasons=(Reason.of("braked", f"{text}, {peak.release.instant_s:.3f} s"),))
        else:
            text = f"{fell} was braked at {stop.start_s:.2f} s, and no clean peak follows: {LEAVE_OUT}"
            reasons.append(Reason.of("braked", text))
    release = find_release(signal, hold, end_s, limits)
    if abs(release.push) > FAR and (peak := from_peak(signal, release.instant_s, end_s, limits)):
        how = "pushed" if release.push > 0 else "held back"
        text = f"it moves as if released from an angle {release.push:+.1%} off θ0: the block was {how}, "
        text += f"or held beyond the range of the sensor; {FROM_PEAK}, {peak.release.instant_s:.3f} s"
        return peak._replace(reasons=(*reasons, Reason.of("hold_unseen", text)))
    held = held_angle(signal, hold, release.instant_s, limits)
    held = held._replace(stderr=math.hypot(held.stderr, release.top_off))
    return Beginning(hold.start_s, release, held, release.instant_s + limits.finger_s, tuple(reasons))


def unseen(signal: Signal, gap: tuple[float, float], limits: RunLimits) -> Beginning | None:
    """A run of a stretch in which the block rocks to rest [s], whose hold the sensor did not see.

    Samples are invalid before its first clean peak, and from there on the swings fall.
    """
    begins = from_peak(signal, *gap, limits)
    if begins is None:
        return None
    before = signal.during(gap[0], begins.release.instant_s)
    during = signal.during(begins.release.instant_s, gap[1])
    noise = float(np.nanmedian(signal.sigma[during]))
    lowest = LEAST_PEAK * abs(begins.held.theta0)
    tops = find_tops(signal.t[during], signal.theta[during], noise, lowest)
    heights = np.abs([begins.held.theta0, *(top.height for top in tops)])
    falls = bool(np.all(heights[2:] <= heights[:-2]))
    if not signal.flags[before].any() or heights.size < MIN_PEAKS or not falls:
        return None
    text = f"no hold is seen{names_of(signal.flags[before])}: {FROM_PEAK}, {begins.release.instant_s:.3f} s"
    return begins._replace(reasons=(Reason.of("hold_unseen", text),))


def from_peak(signal: Signal, after_s: float, end_s: float, limits: RunLimits) -> Beginning | None:
    """A run from its first clean peak: of a swing seen whole, after which hardly a sample is invalid.

    Its height is the release angle, known to `TOP_STDERR`. None where there is no such peak.
    """
    during = signal.during(after_s, end_s)
    t, theta = signal.t[during], signal.theta[during]
    known = np.isfinite(theta)
    if not known.any():
        return None
    noise, highest = float(np.median(signal.sigma[during][known])), float(np.abs(theta[known]).max())
    for top in find_tops(t, theta, noise, LEAST_PEAK * highest):
        swing = theta[slice(*np.searchsorted(t, (top.start_s, top.end_s)))]
        later = theta[np.searchsorted(t, top.time_s) :]
        if np.isfinite(swing).all() and np.mean(np.isnan(later)) <= limits.max_flagged_fraction:
            release = Release(top.time_s, TOP_STDERR_S, 0.0, top.time_s)
            held = HeldAngle(top.height, TOP_STDERR * abs(top.height), 0.0)
            return Beginning(top.time_s, release, held, top.time_s)
    return None


def begun_by_hand(
    signal: Signal, override: Override, found: Beginning | None, end_s: float, limits: RunLimits
) -> Beginning:
    """A run set by hand that ends at an instant [s]; `found` is how the one begins whose place it takes.

    θ0 is read in the hold window that was given, else where the block stands still before the release; where
    neither shows it, the run begins at its first clean peak.
    """
    release_s, end_of_hold_s = override.release_s, override.release_s - limits.finger_s
    release = Release(release_s, limits.finger_s, 0.0, release_s + limits.finger_s)
    if override.hold_s:
        hold_start_s, end_of_hold_s = override.hold_s
        since_s = hold_start_s
    elif found and _is_its_hold(found, release_s, limits):
        hold_start_s = found.hold_start_s
        since_s = max(hold_start_s, end_of_hold_s - limits.held_s)
    else:
        since_s = hold_start_s = _still_since(signal, end_of_hold_s, limits.held_s)
    held = held_over(signal, since_s, end_of_hold_s)
    if held:
        return Beginning(hold_start_s, release, held, release_s + limits.finger_s)
    reasons: tuple[Reason, ...] = ()
    if override.hold_s:
        text = f"no hold is seen from {since_s:g} to {end_of_hold_s:g} s, where it was set by hand"
        reasons = (Reason.of("by_hand", f"{text}: {HOLD_OF}"),)
    peak = from_peak(signal, release_s, end_s, limits)
    if peak:
        text = f"no hold is seen before {release_s:g} s: {FROM_PEAK}, {peak.release.instant_s:.3f} s"
        return peak._replace(reasons=(*reasons, Reason.of("hold_unseen", text)))
    text = f"neither a hold before {release_s:g} s nor a clean peak after it is seen: {HOLD_OF}"
    theta = signal.theta[signal.during(release_s, end_s)]
    angle = float(next(iter(theta[np.isfinite(theta)]), 0.0))
    reasons = (*reasons, Reason.of("by_hand", text))
    return Beginning(
        release_s, release, HeldAngle(angle, abs(angle), 0.0), release_s + limits.finger_s, reasons
    )


def _is_its_hold(found: Beginning, release_s: float, limits: RunLimits) -> bool:
    """Whether a release follows the hold that was found, without free rocking between."""
    shortest = limits.finger_s + MIN_BLOCKS * HOLD_BLOCK_S
    return found.hold_start_s + shortest < release_s < found.release.instant_s + limits.finger_s


def _still_since(signal: Signal, until_s: float, most_s: float) -> float:
    """From when on the block stands still up to an instant [s], looked for over no more than `most_s`."""
    since_s, last = until_s, held_over(signal, until_s - (MIN_BLOCKS + 0.5) * HOLD_BLOCK_S, until_s)
    while last and since_s - HOLD_BLOCK_S >= until_s - most_s:
        theta = signal.theta[signal.during(since_s - HOLD_BLOCK_S, since_s)]
        theta = theta[np.isfinite(theta)]
        if not theta.size or abs(theta.mean() - last.theta0) > UNSTEADY * abs(last.theta0):
            break
        since_s -= HOLD_BLOCK_S
    return since_s
