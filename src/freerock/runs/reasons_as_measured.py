"""Reasons why a run is `warn` or `fail` as measured, before any fit: a function for each part of a run.

A new check belongs to one of `CHECKS`. Reasons stand in the order of that list. `verdict` says where other
reasons are made.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import stdtr

from freerock.arrays import Floats
from freerock.config.processing import IMPACT_LIMITS, ImpactLimits, RunLimits
from freerock.models.block import SQUAT, Block
from freerock.noise.still_phases import Phase, swings_of
from freerock.rotation.flags import BY_HAND, Fault
from freerock.runs.beginning import Beginning
from freerock.runs.impacts import Impacts, restitution_covariance
from freerock.runs.signal import SMOOTH_S, Signal, invalid_in, names_of
from freerock.runs.verdict import KNOWN_REASONS, Level, Reason, Verdict

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


Check = Callable[[Facts], Iterator[Reason]]


def verdict_on(run: Facts) -> Verdict:
    """The verdict of all checks, between what was set by hand and whether the run was left out by hand."""
    by_hand = [each for each in run.by_hand if each.name != "excluded"]
    found = [reason for check in CHECKS for reason in check(run)]
    left_out = [each for each in run.by_hand if each.name == "excluded"]
    return Verdict((*by_hand, *run.beginning.reasons, *found, *left_out))


def let_go(run: Facts) -> Iterator[Reason]:
    """The early motion gives the instant of release; it begins at the held angle, below the critical one."""
    if not run.beginning.release.timed:
        yield Reason.of("release_not_timed", "the release can't be timed from the early motion")
    push = run.beginning.release.push
    if abs(push) > run.limits.max_push_fraction:
        how = "pushed" if push > 0 else "held back"
        text = f"{how}: it moves as if released from an angle {push:+.1%} off θ0"
        yield Reason.beyond(run.limits, how.replace(" ", "_"), text, push)
    if run.block is not None and abs(run.beginning.held.theta0) >= run.block.theta_cr:
        held, critical = math.degrees(run.beginning.held.theta0), math.degrees(run.block.theta_cr)
        remedy = "check the settings of the laser and the block's size"
        text = f"θ0 = {held:.2f}° is beyond θ_cr = {critical:.2f}°: {remedy}"
        yield Reason.of("beyond_critical_angle", text, None, held, critical, "degree")


def recorded(run: Facts) -> Iterator[Reason]:
    """There are enough zero crossings, and the samples are valid."""
    fewest = run.limits.min_impacts
    if run.n_impacts < fewest:
        lost = invalid_in(run.signal, run.limits.max_flagged_fraction)
        longer = "record longer, or " * (run.rest is None)
        told = f"; in its record, {lost}" if lost else f": {longer}release at a larger angle"
        text = f"{run.n_impacts} zero crossings, fewer than {fewest}{told}"
        yield Reason.beyond(run.limits, "few_impacts", text, run.n_impacts)
    watched = run.signal.during(run.beginning.release.watched_s, run.end_s)
    theta, flags = run.signal.theta[watched], run.signal.flags[watched]
    left_out = flags.astype(np.uint8) & BY_HAND["left_out"] > 0
    share = float(np.mean(np.isnan(theta) & ~left_out)) if theta.size else 1.0
    if share > 0:
        text = f"{share:.2%} of its samples are invalid{names_of(flags)}"
        level: Level = "fail" if share > run.limits.max_flagged_fraction else "warn"
        yield Reason.beyond(run.limits, "invalid_samples", text, share, level)


def rocks_freely(run: Facts) -> Iterator[Reason]:
    """After an impact the block rocks over the other corner, and its swings get lower and shorter."""
    peak = peak_on_the_same_side(run)
    if peak:
        before, after = (f"{math.degrees(height):.2f}°" for height in peak)
        text = f"after {before} its next peak is {after}, on the same side: it bounces"
        yield Reason.of("bounced", text)
    found, more, limit = _not_free(run)
    if found and not peak:
        bounces = run.block is not None and run.block.theta_cr > SQUAT
        text = f"swing {found} than before: the block was touched" + ", or it bounces" * bounces
        key = "processing.runs.max_growth_fraction" * (limit == run.limits.max_growth_fraction)
        yield Reason("warn" if bounces else "fail", "touched", text, more, limit, "1", key)


def stands_still(run: Facts) -> Iterator[Reason]:
    """The held angle stands still, and the motion ends at rest, where it was at rest before."""
    wander = math.degrees(run.beginning.held.wander)
    if wander > run.limits.max_hold_drift_deg:
        text = f"the held angle wanders by {wander:.3f}°"
        yield Reason.beyond(run.limits, "hold_wanders", text, wander)
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
        elif fault.name in KNOWN_REASONS and fault.name not in ("rest_shift", "drift"):
            text = f"{fault.name.replace('_', ' ')}: {fault.note}"
            yield Reason.of(fault.name, text)


CHECKS: tuple[Check, ...] = (let_go, recorded, rocks_freely, stands_still, faults_met)


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
    turns, extreme, rising = [float(theta[0])], float(theta[0]), 0
    for value in theta.tolist():
        if rising * (value - extreme) > 0 or (not rising and abs(value - turns[0]) > least):
            rising = rising or int(math.copysign(1, value - turns[0]))
            extreme = value
        elif rising and rising * (extreme - value) > least:
            turns.append(extreme)
            extreme, rising = value, -rising
    turns.append(extreme)
    for one, between, other in zip(turns, turns[1:], turns[2:], strict=False):
        side = math.copysign(1.0, one)
        back = side * other > max(least, REBOUND * highest) and abs(between) < NEAR_ZERO * abs(one)
        if back and side * between > -0.5 * side * other:
            return one, other
    return None


def _not_free(run: Facts) -> tuple[str, float, float]:
    """Which swing is not free, and why; "" if none. By how much more than the one before, and its limit.

    Swings are seen in means over `SMOOTH_S`, which no outlier makes rise above the noise. Where heights or
    times are uneven all along, as those of a hardly damped block that still bounces, one alone shows no hand.
    """
    t, sigma = run.signal.t, run.sigma_theta
    during = run.signal.during(run.beginning.fit_start_s, run.end_s)
    theta = run.signal.smoothed(during, SMOOTH_S)[: during.stop - during.start]
    swings, instants = swings_of(theta, SWING * sigma), t[during]
    passages = [(instants[one.stop - 1] + instants[other.start]) / 2 for one, other in pairwise(swings)]
    tops = [float(np.nanmax(np.abs(theta[swing]))) for swing in swings[1:-1]]
    times = np.diff(passages)
    theta0 = abs(run.beginning.held.theta0)
    height, longest = theta0, (math.inf, math.inf)  # a moved zero makes one side's longer
    lost = np.append(0, np.cumsum(np.isnan(run.signal.theta[during])))
    for number, (top, time) in enumerate(zip(tops, times.tolist(), strict=True), 1):
        first, end = swings[number - 1].start, swings[number].stop
        if lost[end] - lost[first] > run.limits.max_flagged_fraction * (end - first):
            height, longest = top, (longest[1], math.inf)  # what is not seen shows no touch
            continue
        higher = top > (1 + run.limits.max_growth_fraction) * height + 2 * SWING * sigma
        if higher and _stands_out(np.log([theta0, *tops]), number):
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


FIRST = 10  # impacts that are looked at: the restitution of low swings is uncertain
SURE_UNEVEN = 5.0  # standard errors, of which the scatter of clean runs is a part
CHANCE = 1e-3  # of so uneven a run whose impacts scatter at random, by Student's distribution
BENT = 0.05  # of how far the restitution goes from the second impact to the last: more scatter where it bends
ALTERNATES = "level the base, and check the laser: its sign, the level of its beam, its linearity"
FALLS_OUT = "the block may have been touched, hit or caught, or it slid: look there, and exclude the run"


class Evenness(NamedTuple):
    """What is taken for even in a run of so many impacts.

    Parameters
    ----------
    fewest : int
        Impacts from which this holds.
    degree : int
        Of the polynomial in the number of the impact.
    scatter : float
        By how much, as a standard deviation, the restitutions of clean runs differ from it.
    """

    fewest: int
    degree: int
    scatter: float


EVEN = (Evenness(8, 3, 1.5e-3), Evenness(6, 2, 2.5e-3))


class Unevenness(NamedTuple):
    """One number more than even: by how much one impact, or every other one, is off.

    Parameters
    ----------
    impact : int
        Which one, counted from 1; 0 for every other one.
    size, stderr : float
        Of the restitution; of every other one half the difference.
    left : float
        Sum of squares that it leaves, in standard deviations.
    """

    impact: int
    size: float
    stderr: float
    left: float

    def is_sure(self, spare: int, tried: int) -> bool:
        """Whether it is more than the scatter of the other impacts, seen by so many degrees of freedom.

        That of a hardly damped block, or of a laboratory, is larger than of clean runs.
        """
        scatter, times = math.sqrt(self.left / spare), abs(self.size) / self.stderr
        chance = 2 * float(stdtr(spare, -times / scatter)) if scatter > 0 else 0.0
        return times >= SURE_UNEVEN * max(1.0, scatter) and tried * chance < CHANCE


def reasons_of_impacts(
    impacts: Impacts, block: Block, limits: ImpactLimits = IMPACT_LIMITS, peak_stderr: float = 0.0
) -> list[Reason]:
    """A warning where no swing clearly leaves full contact, or the restitutions follow no smooth curve.

    Without such a swing no restitution per impact is meaningful.

    The scatter was set on 1500 clean runs of the three laws, on foundations of any stiffness and damping, of
    worn corners and of pivoting blocks; docs/validation.md counts the false alarms of others. With fewer than
    eight impacts the two kinds can't be told apart; of fewer than six nothing is said.
    No peak is known better than to `peak_stderr` [rad], by the noise as it is at rest.

    The restitution of a free block changes smoothly as its swings get lower, on any foundation. Where every
    other impact has more of it, or one impact falls out, something else acted on the block or on the reading.
    """
    if not impacts.time_s.size and impacts.theta_uplift:
        contact = f"the {math.degrees(impacts.theta_uplift):.2f}° up to which the base stays in full contact"
        times = f"no swing exceeds {limits.min_uplift_ratio:g} times {contact}"
        text = f"per-impact r is not meaningful here: {times}"
        return [Reason.beyond(limits, "no_restitution", text, None)]
    n = min(impacts.restitution.size, FIRST)
    r, covariance = impacts.restitution[:n], restitution_covariance(impacts, block, peak_stderr)[:n, :n]
    known = np.flatnonzero(np.isfinite(r) & np.isfinite(covariance.diagonal()))
    even = next((each for each in EVEN if known.size >= each.fewest), None)
    if even is None:
        return []
    found = unevennesses(known.astype(float), r[known], covariance[np.ix_(known, known)], even)
    worst = found[0] if even is EVEN[-1] else min(found, key=lambda each: each.left)
    spare = known.size - even.degree - 2
    if not (found[0].is_sure(spare, 1) or worst.is_sure(spare, known.size)):
        return []
    if even is not EVEN[0]:
        text = f"restitution does not change smoothly from impact to impact, by {abs(found[0].size):.2g}"
        remedy = f"{ALTERNATES}; or {FALLS_OUT}"
        return [Reason.of("uneven_restitution", f"{text}: {remedy}")]
    if worst.impact:
        side = "above" if worst.size > 0 else "below"
        text = (
            f"restitution of impact {worst.impact} is {abs(worst.size):.2g} {side} the value that "
            f"its neighbours predict"
        )
        return [Reason.of("outlying_restitution", f"{text}: {FALLS_OUT}")]
    text = f"restitution alternates by ±{abs(worst.size):.2g} from impact to impact"
    return [Reason.of("alternating_restitution", f"{text}: {ALTERNATES}")]


def unevennesses(number: Floats, r: Floats, covariance: Floats, even: Evenness) -> list[Unevenness]:
    """Every other impact, then each one alone, as what is off a smooth curve; by generalised least squares.

    Parameters
    ----------
    number : ndarray, shape (n,)
        Number of each impact, in which the curve is a polynomial.
    r, covariance : ndarray, shapes (n,) and (n, n)
        Restitutions, and how uncertain they are.
    even : Evenness
    """
    scatter = math.hypot(even.scatter, BENT * (r[-1] - r[1]))
    scale = np.linalg.cholesky(covariance + scatter**2 * np.eye(r.size))
    smooth = np.vander(number - np.mean(number), even.degree + 1)
    every_other = (-1.0) ** number
    found = []
    for i, column in enumerate([every_other, *np.eye(r.size)]):
        design = np.linalg.solve(scale, np.column_stack([column, smooth]))
        seen = np.linalg.solve(scale, r)
        inverse = np.linalg.pinv(design)
        size, stderr = float(inverse[0] @ seen), float(np.linalg.norm(inverse[0]))
        left = float(np.sum((seen - design @ (inverse @ seen)) ** 2))
        found.append(Unevenness(int(number[i - 1]) + 1 if i else 0, size, stderr, left))
    return found
