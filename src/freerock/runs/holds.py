"""Where a record is held before a release, and whether the block was stopped, or slowed, on its way from it.

A block that falls freely from rest only gets faster until its first passage through zero. What comes before
its last rest, or before it was slowest, is not free rocking.
"""

import math
from bisect import bisect
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.noise.still import UNSTEADY, Phase, stationary_phases, stretches
from freerock.noise.sums import covariance_of_sums
from freerock.runs.release import FALL_MOST
from freerock.runs.signal import Signal, invalid_in

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
    noise = float(np.nanmedian(signal.sigma[during][: n * size])) * _stderr_of_rate(signal, size)
    shakes, shaken = _tremor(signal, hold, size)
    noise = max(noise, shakes)
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


def _tremor(signal: Signal, hold: Phase, size: int) -> tuple[float, float]:
    """How a hand trembles: root mean square of the difference of neighbouring means of so many samples [rad],
    and standard deviation of these means [rad].

    A hand that trembles moves the block up and down before it leaves, which is no stop.
    """
    theta = signal.theta[signal.during(max(hold.mid_s, hold.end_s - HAND_S), hold.end_s)]
    means = theta[: theta.size // size * size].reshape(-1, size).mean(axis=1)
    rates, means = (each[np.isfinite(each)] for each in (np.diff(means), means))
    if rates.size < FEWEST_RATES:
        return 0.0, 0.0
    return float(np.sqrt(np.mean(rates**2))), float(np.std(means))


def _stderr_of_rate(signal: Signal, size: int) -> float:
    """Standard error of the difference of neighbouring means of so many samples, over σ."""
    noise = signal.relative_noise
    n = max(1, round(size / noise.averaged))
    difference = np.repeat([[-1.0, 1.0]], n, axis=1) / n
    return float(np.sqrt(covariance_of_sums(noise, difference)[0, 0] * n * noise.averaged / size))


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
