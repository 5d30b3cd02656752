"""The first method: Taylor series of order 30 in fixed point, with 48 decimal places.

Steps end where an end of the contact changes its kind or the block its corner: the instant is bisected to 100
binary places of the step.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from freerock_bench.golden.fixed_point import ONE, PLACES, UNIT, Series, at, fixed, number
from freerock_bench.golden.motion import ORDER, REST, Motion, Regime
from freerock_bench.golden.scenes import PULSE_START_S, Scene, instants

SMALLEST = 1 << (PLACES - 88)  # last coefficients that a step leaves, about 3e-27
PARTS = 8  # of a step, at whose ends the regime is asked for
HALVINGS = 100
CHATTER_S = 0.02  # swings of Housner's block shorter than this end the solution
NOTHING = 1e-15  # rounding of a block at rest [rad, rad/s]


@dataclass
class Solution:
    """What a method makes of a scene.

    Parameters
    ----------
    time_s, theta_rad, theta_rate_rad_s : list of float
        At the instants quoted.
    impacts, peaks : list of (float, float, float)
        Instant [s], θ [rad], θ̇ [rad/s] where θ changes its sign (θ̇ before the impact of Housner's block) and
        where θ̇ does.
    """

    time_s: list[float] = field(default_factory=list)
    theta_rad: list[float] = field(default_factory=list)
    theta_rate_rad_s: list[float] = field(default_factory=list)
    impacts: list[tuple[float, float, float]] = field(default_factory=list)
    peaks: list[tuple[float, float, float]] = field(default_factory=list)


def solve(scene: Scene, span_s: float) -> Solution:
    """A scene up to an instant [s], or up to where Housner's block chatters."""
    motion, found = Motion(scene), Solution()
    wanted = instants(span_s)
    # instants in units of the series' time
    stops = sorted({Fraction(str(t)) for t in (*scene.breaks, wanted[-1]) if t > 0})
    samples = [fixed(Fraction(str(t)) * 2**UNIT) for t in wanted]
    now, regime, idle = 0, motion.regime(motion.state), 0
    if motion.rigid and scene.theta0 == 0:
        regime = (REST,)
    for stop in stops:
        goal = fixed(stop * 2**UNIT)
        while now < goal:
            series = motion.series(regime)
            step = min(_step(series), goal - now)
            last, after = _until_change(motion, series, regime, step)
            idle = idle + 1 if last << 60 < ONE else 0
            if idle > 20:
                raise ArithmeticError(f"{scene.name}: no regime holds at {number(now) / 2**UNIT} s")
            while samples and samples[0] <= now + last:
                x = samples.pop(0) - now
                found.time_s.append(wanted[len(found.time_s)])
                found.theta_rad.append(number(at(series[2], x)))
                found.theta_rate_rad_s.append(number(at(series[3], x)))
            _extremes(series, now, last, found)
            motion.state = [at(each, last) for each in series]
            now += last
            if after != regime and motion.rigid and regime != (REST,):
                motion.state[2], motion.state[3] = 0, motion.r * motion.state[3] >> PLACES
                motion.state[4], motion.state[5] = 0, ONE
                if len(found.impacts) > 1 and number(now) / 2**UNIT - found.impacts[-2][0] < CHATTER_S:
                    return found
            regime = after
        motion.shaken = goal == fixed(Fraction(str(PULSE_START_S)) * 2**UNIT)
        motion.state[6:] = [0, ONE]
    return found


def _step(series: list[Series]) -> int:
    """The step whose last terms are small, at most two units of time."""
    longest = 2.0
    for each in series[:4]:
        for n in (ORDER, ORDER - 1):
            if each[n]:
                longest = min(longest, float(Fraction(SMALLEST, abs(each[n]))) ** (1 / n))
    return fixed(longest)


def _until_change(motion: Motion, series: list[Series], regime: Regime, step: int) -> tuple[int, Regime]:
    """The part of a step in which a regime holds, and the regime after it."""

    def there(x: int) -> Regime:
        state = [at(each, x) for each in series]
        if regime == (REST,):
            return motion.lifted(state)
        return motion.regime(state)

    for left, right in _parts(step):
        if there(right) != regime:
            last = _end_of(lambda x: there(x) == regime, left, right)
            return last, there(last)
    return step, regime


def _extremes(series: list[Series], now: int, step: int, found: Solution) -> None:
    """Changes of sign of θ and of θ̇ within a step."""
    for component, into in ((2, found.impacts), (3, found.peaks)):
        own, value = series[component], series[component][0]
        for left, right in _parts(step):
            reached = at(own, right)
            if value * reached <= 0 and value != 0:
                x = _end_of(_has_sign(own, value), left, right)
                state = number(at(series[2], x)), number(at(series[3], x))
                if max(map(abs, state)) > NOTHING:
                    into.append((number(now + x) / 2**UNIT, *state))
            value = reached


def _has_sign(series: Series, sign: int) -> Callable[[int], bool]:
    return lambda x: at(series, x) * sign > 0


def _parts(step: int) -> Iterator[tuple[int, int]]:
    """A step in parts."""
    yield from pairwise(step * part // PARTS for part in range(PARTS + 1))


def _end_of(holds: Callable[[int], bool], low: int, high: int) -> int:
    """Where something does not hold any more that did at the lower end."""
    for _ in range(HALVINGS):
        middle = (low + high) // 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return high
