"""Reasons why a run is `warn` or `fail` as measured, before any fit: each check a small function.

A new check is one function, and its line in `CHECKS`; the reasons stand in the order of that list. `verdict`
says where other reasons are made.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats
from freerock.config.processing import RunLimits
from freerock.models.block import SQUAT, Block
from freerock.noise.still import Phase, one_sided
from freerock.rotation.flags import BY_HAND, Fault
from freerock.runs.beginning import Beginning
from freerock.runs.release import HeldAngle, Release
from freerock.runs.signal import SMOOTH_S, Signal, invalid_in, names_of
from freerock.runs.verdict import Level, Reason, Verdict, known_reasons

SWING = 10.0  # standard deviations a swing rises above zero
SLOWER = 1.1  # by this factor may a swing last longer than the one before: soft bases even swings out
AROUND = 6  # swings on either side show how evenly heights fall
FEWEST = 4  # of them at least, to show it
SURE = 5.0  # times their scatter, from which on a rise is none of them: of hardly damped blocks at most 4.3
TURN = 0.01  # of the highest peak: a turn of less is none
REBOUND = 0.03  # of it at least is a peak after a bounce: 0.05 to 0.13 of a square that falls on a face
NEAR_ZERO = 0.1  # of a peak: a block that turns back further from zero was not at an impact


@dataclass(frozen=True)
class Facts:
    """What is known of a run when it is judged.

    Parameters
    ----------
    signal : Signal
        θ(t) of the whole record.
    faults : sequence of Fault
        What is wrong with it.
    block : Block or None
    limits : RunLimits
    beginning : Beginning
    rest : Phase or None
        The phase of stillness that follows, None where the record ends before, or a run set by hand.
    level_before : float or None
        Level of the last rest before the hold [rad], None where there is none.
    end_s : float
        End of the motion [s].
    sigma_theta : float
        Standard deviation of the noise of θ [rad].
    n_impacts : int
    by_hand : sequence of Reason
        That release and end were set by hand, or the run left out, and what can't be as it was set.
    """

    signal: Signal
    faults: Sequence[Fault]
    block: Block | None
    limits: RunLimits
    beginning: Beginning
    rest: Phase | None
    level_before: float | None
    end_s: float
    sigma_theta: float
    n_impacts: int
    by_hand: Sequence[Reason] = ()

    @property
    def release(self) -> Release:
        """The release."""
        return self.beginning.release

    @property
    def held(self) -> HeldAngle:
        """The held angle."""
        return self.beginning.held


Check = Callable[[Facts], Iterator[Reason]]


def verdict_on(run: Facts) -> Verdict:
    """The verdict of all checks."""
    return Verdict(tuple(reason for check in CHECKS for reason in check(run)))


def overridden(run: Facts) -> Iterator[Reason]:
    """Release and end set by hand: noted, and what of it can't be."""
    yield from (each for each in run.by_hand if each.name != "excluded")


def begun(run: Facts) -> Iterator[Reason]:
    """A run begins with the release from a hold."""
    yield from run.beginning.reasons


def release_timed(run: Facts) -> Iterator[Reason]:
    """The early motion gives the instant of release."""
    if not run.release.timed:
        yield Reason.of("release_not_timed", "the release can't be timed from the early motion")


def pushed(run: Facts) -> Iterator[Reason]:
    """The motion begins at the held angle."""
    push = run.release.push
    if abs(push) > run.limits.max_push_fraction:
        how = "pushed" if push > 0 else "held back"
        text = f"{how}: it moves as if released from an angle {push:+.1%} off θ0"
        yield Reason.beyond(run.limits, how.replace(" ", "_"), text, push)


def critical_angle(run: Facts) -> Iterator[Reason]:
    """The block is held below its critical angle."""
    if run.block is not None and abs(run.held.theta0) >= run.block.theta_cr:
        held, critical = math.degrees(run.held.theta0), math.degrees(run.block.theta_cr)
        remedy = "check the settings of the laser and the block's size"
        text = f"θ0 = {held:.2f}° is beyond θ_cr = {critical:.2f}°: {remedy}"
        yield Reason.of("beyond_critical_angle", text, None, held, critical, "degree")


def few_impacts(run: Facts) -> Iterator[Reason]:
    """There are enough impacts."""
    fewest = run.limits.min_impacts
    if run.n_impacts < fewest:
        lost = invalid_in(run.signal, run.limits.max_flagged_fraction)
        longer = "record longer, or " * (run.rest is None)
        told = f"; in its record, {lost}" if lost else f": {longer}release at a larger angle"
        text = f"{run.n_impacts} impacts, fewer than {fewest}{told}"
        yield Reason.beyond(run.limits, "few_impacts", text, run.n_impacts)


def invalid_samples(run: Facts) -> Iterator[Reason]:
    """The samples are valid."""
    watched = run.signal.during(run.release.watched_s, run.end_s)
    theta, flags = run.signal.theta[watched], run.signal.flags[watched]
    left_out = flags.astype(np.uint8) & BY_HAND["left_out"] > 0
    share = float(np.mean(np.isnan(theta) & ~left_out)) if theta.size else 1.0
    if share > 0:
        text = f"{share:.2%} of its samples are invalid{names_of(flags)}"
        level: Level = "fail" if share > run.limits.max_flagged_fraction else "warn"
        yield Reason.beyond(run.limits, "invalid_samples", text, share, level)


def bounced(run: Facts) -> Iterator[Reason]:
    """After an impact the block rocks over the other corner; one that bounces comes back over the same."""
    if peak := peak_on_the_same_side(run):
        before, after = (f"{math.degrees(height):.2f}°" for height in peak)
        text = f"after {before} its next peak is {after}, on the same side: it bounces"
        yield Reason.of("bounced", text)


def touched(run: Facts) -> Iterator[Reason]:
    """Swings of a free block get lower and shorter."""
    found, more, limit = _not_free(run)
    if found and not peak_on_the_same_side(run):
        bounces = run.block is not None and run.block.theta_cr > SQUAT
        text = f"swing {found} than before: the block was touched" + ", or it bounces" * bounces
        key = "processing.runs.max_growth_fraction" * (limit == run.limits.max_growth_fraction)
        yield Reason("warn" if bounces else "fail", "touched", text, more, limit, "1", key)


def hold_wanders(run: Facts) -> Iterator[Reason]:
    """The held angle stands still."""
    wander = math.degrees(run.held.wander)
    if wander > run.limits.max_hold_drift_deg:
        text = f"the held angle wanders by {wander:.3f}°"
        yield Reason.beyond(run.limits, "hold_wanders", text, wander)


def ends_at_rest(run: Facts) -> Iterator[Reason]:
    """The motion ends at rest, where it was at rest before."""
    if run.rest is None and any(each.name == "overridden" for each in run.by_hand):
        return
    if run.rest is None:
        yield Reason.of("cut_short", "the record ends before the block is at rest: record longer")
    elif run.rest.kind != "rest":
        over = run.block is not None and abs(run.rest.level) >= run.block.theta_cr
        name, what = ("overturned", "it overturns and lies") if over else ("stopped", "it stops")
        yield Reason.of(name, f"{what} at {math.degrees(run.rest.level):.2f}° instead of at rest")
    elif run.level_before is not None:
        shift = math.degrees(run.rest.level - run.level_before)
        if abs(shift) > run.limits.max_rest_shift_deg:
            text = f"the rest position has moved by {shift:+.3f}°"
            yield Reason.beyond(run.limits, "rest_shift", text, shift)


def faults_met(run: Facts) -> Iterator[Reason]:
    """No fault of the signal meets the run."""
    for fault in run.faults:
        if not (fault.start_s < run.end_s and fault.end_s > run.beginning.hold_start_s):
            continue
        angle = math.degrees(fault.angle)
        moved = abs(angle) > run.limits.max_rest_shift_deg
        laser, of_two, _ = fault.note.partition(": ")
        seen = f" (by the {laser})" if of_two else ""
        if fault.name == "rest_shift" and moved:
            text = f"the rest position has moved by {angle:+.3f}°{seen}: the block may have slid or twisted"
            yield Reason.beyond(run.limits, "rest_shift", text, angle)
        elif fault.name == "drift" and moved:
            text = f"the zero drifts by {angle:+.3f}°{seen}"
            yield Reason.beyond(run.limits, "drift", text, angle)
        elif fault.name in known_reasons() and fault.name not in ("rest_shift", "drift"):
            text = f"{fault.name.replace('_', ' ')}: {fault.note}"
            yield Reason.of(fault.name, text)


def excluded(run: Facts) -> Iterator[Reason]:
    """Left out by hand: noted."""
    yield from (each for each in run.by_hand if each.name == "excluded")


CHECKS: tuple[Check, ...] = (
    overridden,
    begun,
    release_timed,
    pushed,
    critical_angle,
    few_impacts,
    invalid_samples,
    bounced,
    touched,
    hold_wanders,
    ends_at_rest,
    faults_met,
    excluded,
)


def peak_on_the_same_side(run: Facts) -> tuple[float, float] | None:
    """The first two peaks on one side between which θ came to zero and did not pass it [rad]; None if none.

    Turning points are those of `SWING` standard deviations and `TURN` of the highest peak. Between two peaks
    on one side lies one on the other, unless the block turned back at zero. Peaks lower than `REBOUND` may be
    about a rest that has moved. Medians of three samples keep a single outlier from being a turning point.
    """
    during = run.signal.during(run.beginning.fit_start_s, run.end_s)
    theta = run.signal.theta[during]
    theta = theta[np.isfinite(theta)]
    if theta.size < FEWEST:
        return None
    low, high = np.minimum(theta[:-2], theta[1:-1]), np.maximum(theta[:-2], theta[1:-1])
    theta = np.maximum(low, np.minimum(high, theta[2:]))
    highest = float(np.abs(theta).max())
    least = max(SWING * run.sigma_theta, TURN * highest)
    turns = turning_points(theta, least)
    for one, between, other in zip(turns, turns[1:], turns[2:], strict=False):
        side = math.copysign(1.0, one)
        back = side * other > max(least, REBOUND * highest) and abs(between) < NEAR_ZERO * abs(one)
        if back and side * between > -0.5 * side * other:
            return one, other
    return None


def turning_points(theta: Floats, least: float) -> list[float]:
    """The first value and those at which θ turns back by more than `least`, in the order of time [rad]."""
    turns, extreme, rising = [float(theta[0])], float(theta[0]), 0
    for value in theta.tolist():
        if rising * (value - extreme) > 0 or (not rising and abs(value - turns[0]) > least):
            rising = rising or int(math.copysign(1, value - turns[0]))
            extreme = value
        elif rising and rising * (extreme - value) > least:
            turns.append(extreme)
            extreme, rising = value, -rising
    return [*turns, extreme]


def _not_free(run: Facts) -> tuple[str, float, float]:
    """Which swing is not free, and why; "" if none. By how much more than the one before, and its limit.

    Swings are seen in means over `SMOOTH_S`, which no outlier makes rise above the noise. Where heights or
    times are uneven all along, as those of a hardly damped block that still bounces, one alone shows no hand.
    """
    t, sigma = run.signal.t, run.sigma_theta
    during = run.signal.during(run.beginning.fit_start_s, run.end_s)
    theta = run.signal.smoothed(during, SMOOTH_S)[: during.stop - during.start]
    starts, ends = one_sided(theta, SWING * sigma)
    instants = t[during]
    passages = (instants[ends[:-1]] + instants[starts[1:]]) / 2
    swings = zip(starts[1:-1], ends[1:-1], strict=True)
    tops = [float(np.nanmax(np.abs(theta[i : j + 1]))) for i, j in swings]
    times = np.diff(passages)
    height, longest = abs(run.held.theta0), (math.inf, math.inf)  # a moved zero makes one side's longer
    lost = np.append(0, np.cumsum(np.isnan(run.signal.theta[during])))
    for number, (top, time) in enumerate(zip(tops, times.tolist(), strict=True), 1):
        first, last = starts[number - 1], ends[number]
        if lost[last + 1] - lost[first] > run.limits.max_flagged_fraction * (last + 1 - first):
            height, longest = top, (longest[1], math.inf)  # what is not seen shows no touch
            continue
        higher = top > (1 + run.limits.max_growth_fraction) * height + 2 * SWING * sigma
        if higher and _stands_out(np.log([abs(run.held.theta0), *tops]), number):
            more = top / height - 1
            return f"{number} is {more:.0%} higher", more, run.limits.max_growth_fraction
        slower = top > 3 * SWING * sigma and time > SLOWER * max(longest) + 2 * (t[1] - t[0])
        if slower and _stands_out(np.log(times), number - 1):
            more = time / max(longest) - 1
            return f"{number} lasts {more:.0%} longer", more, SLOWER - 1
        height, longest = top, (longest[1], time)
    return "", 0.0, 0.0


def _stands_out(heights: Floats, number: int) -> bool:
    """Whether the logarithm of a height, or a time, exceeds the one before by more than those around it do.

    Their scatter is that of neighbouring differences: it is the same where they grow or fall steadily. The
    next difference is left out, for it belongs to the same height.
    """
    falls = np.diff(heights)
    at = np.arange(falls.size)
    around = falls[(np.abs(at - number + 1) <= AROUND) & (at != number - 1) & (at != number)]
    if around.size < FEWEST:
        return True
    scatter = math.sqrt(float(np.mean(np.diff(around) ** 2)) / 2)
    return bool(falls[number - 1] - np.median(around) > SURE * scatter)
