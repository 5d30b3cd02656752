"""The golden solutions again: SciPy's DOP853 in double precision, restarted at every change of regime.

It shares nothing with `freerock.models`: the force and its moment are sums over Gauss's two places of the
contact, and eq. (1) is solved as the two linear equations that it is.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from numpy.polynomial.legendre import leggauss
from scipy.integrate import DOP853

from freerock_bench.golden.scenes import PULSE_PERIOD_S, PULSE_START_S, Scene, instants

RTOL = 3e-14
ATOL = 1e-17
LONGEST_S = 0.004
CHATTER_S = 0.02  # swings of Housner's block shorter than this end the solution
PARTS = 6  # of a step, at whose ends the regime is asked for
State = Sequence[float]
Regime = tuple[Any, ...]
GRAVITY = 9.81


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


class Block:
    """A scene's block on its foundation and its equations of motion."""

    def __init__(self, scene: Scene) -> None:
        """The scene's constants."""
        shape, law = scene.block, scene.parameters
        self.m, self.b, self.h = shape.mass_kg, shape.width_m / 2, shape.com_height_m or shape.height_m / 2
        self.e = shape.com_offset_m or 0.0
        uniform = self.m * (shape.width_m**2 + shape.height_m**2) / 12
        self.inertia = shape.inertia_kg_m2 or uniform
        self.k, self.c, self.lam = law.get("k", 0.0), law.get("c", 0.0), law.get("lambda", 0.0)
        nodes, weights = leggauss(2)
        self.places = list(zip(nodes.tolist(), weights.tolist(), strict=True))
        self.rigid, self.pivots = scene.law == "housner", scene.kinematics == "pivoting"
        self.tensionless = scene.debonding == "tensionless"
        self.pulse, self.moving, self.drop = scene.pulse, False, scene.drop_m

    def ground(self, t: float) -> tuple[float, float]:
        """ẍ_g and g + z̈_g."""
        wave = math.sin(2 * math.pi * (t - PULSE_START_S) / PULSE_PERIOD_S) if self.moving else 0.0
        return self.pulse[0] * wave, GRAVITY + self.pulse[1] * wave

    def released(self, theta0: float) -> list[float]:
        """z_cb, ż_cb, θ, θ̇ at the release, the weight carried by the springs."""
        s = math.sin(abs(theta0))
        if self.rigid:
            return [0.0, 0.0, theta0, 0.0]
        if self.drop:
            return [-self.b * s - self.drop, 0.0, theta0, 0.0]
        weight = self.m * GRAVITY
        edge = math.sqrt(2 * weight * s / self.k)  # depth of the edge where the base is partly in contact
        depth = edge - self.b * s if edge < 2 * self.b * s else weight / (2 * self.b * self.k)
        return [depth, 0.0, theta0, 0.0]

    def ends(self, y: State) -> tuple[tuple[str, str], float, float]:
        """The contact at a state: what makes its left and its right end, and where they are."""
        z, _, theta, _ = y
        lines = {"z": (z, math.sin(theta))}
        if self.tensionless:
            lines["f"] = self.pull(y)
        left = [("b", -self.b)] + [(n, -a / d) for n, (a, d) in lines.items() if d > 0]
        right = [("b", self.b)] + [(n, -a / d) for n, (a, d) in lines.items() if d < 0]
        (name0, u0), (name1, u1) = max(left, key=lambda e: e[1]), min(right, key=lambda e: e[1])
        nowhere = any(d == 0 and a <= 0 for a, d in lines.values())
        return (("", ""), 0.0, 0.0) if nowhere or u0 >= u1 else ((name0, name1), u0, u1)

    def pull(self, y: State) -> tuple[float, float]:
        """Value at the centre and slope of what must be positive for the foundation to push."""
        z, v, theta, w = y
        q = w * math.cos(theta)
        if self.c:
            return self.k * z + self.c * v, self.k * math.sin(theta) + self.c * q
        return self.k + self.lam * v, self.lam * q

    def regime(self, y: State) -> Regime:
        """What must not change within a step."""
        side = (1 if y[2] >= 0 else -1) if self.pivots else 0
        return (side,) if self.rigid else (*self.ends(y)[0], side)

    def rates(self, regime: Regime) -> Callable[[float, State], list[float]]:
        """The right-hand side, by the formulas of a regime."""
        return self._rigid(regime[0]) if self.rigid else self._on_bed(*regime)

    def _rigid(self, side: int) -> Callable[[float, State], list[float]]:
        arm = side * self.b - self.e
        about = self.inertia + self.m * (arm**2 + self.h**2)

        def call(t: float, y: State) -> list[float]:
            s, c = math.sin(y[2]), math.cos(y[2])
            x, gravity = self.ground(t)
            overturning = x * (self.h * c + arm * s)
            righting = gravity * (arm * c - self.h * s)
            return [0.0, 0.0, y[3], self.m * (overturning - righting) / about]

        return call

    def _on_bed(self, left: str, right: str, side: int) -> Callable[[float, State], list[float]]:
        def end(name: str, corner: float, y: State, s: float) -> float:
            if name == "b":
                return corner
            value, slope = (y[0], s) if name == "z" else self.pull(y)
            return -value / slope

        def call(t: float, y: State) -> list[float]:
            z, v, theta, w = y
            s, c = math.sin(theta), math.cos(theta)
            force = moment = 0.0
            if left:
                u0, u1 = end(left, -self.b, y, s), end(right, self.b, y, s)
                for place, weight in self.places:
                    u = 0.5 * (u0 + u1) + 0.5 * (u1 - u0) * place
                    depth, rate = z + u * s, v + u * w * c
                    pressed = self.k * depth + (self.c + self.lam * depth) * rate
                    f = weight * pressed * (u1 - u0) / 2
                    force, moment = force + f, moment + f * u * c
            x, gravity = self.ground(t)
            m, lift, high = self.m, self.h * s + self.e * c, self.h * c - self.e * s
            slide = high + side * self.b * s
            bend = side * self.b * c - lift
            # [m, m lift; m lift, I + m (slide² + lift²)] [z̈, θ̈] = right side
            a12, a22 = m * lift, self.inertia + m * (slide * slide + lift * lift)
            centripetal = m * high * w * w
            r1 = m * gravity - force - centripetal
            r2 = m * gravity * lift - moment + m * slide * (x - bend * w * w) - lift * centripetal
            det = m * a22 - a12 * a12
            return [v, (r1 * a22 - a12 * r2) / det, w, (m * r2 - a12 * r1) / det]

        return call


def solve(scene: Scene, span_s: float) -> Solution:
    """A scene up to an instant [s], or up to where Housner's block chatters."""
    block, found = Block(scene), Solution()
    wanted = instants(span_s)
    t, size = 0.0, 1e-4
    y: State = block.released(scene.theta0)
    regime: Regime = block.regime(y)
    resting = block.rigid and scene.theta0 == 0.0
    for stop in sorted({*wanted, *scene.breaks}):
        if stop > wanted[-1]:
            break
        while t < stop and not resting:
            solver = DOP853(
                block.rates(regime),
                t,
                y,
                stop,
                rtol=RTOL,
                atol=ATOL,
                max_step=LONGEST_S,
                first_step=min(size, stop - t),
            )
            t, y, after = _advance(block, regime, solver, found)
            size = solver.step_size or size
            if block.rigid and after != regime:
                y = [0.0, 0.0, 0.0, scene.parameters["r"] * y[3]]
                if len(found.impacts) > 1 and t - found.impacts[-2][0] < CHATTER_S:
                    return found
            regime = after
        if stop in scene.breaks[:1]:
            block.moving = True
            if resting:
                t, resting = _lift(block, stop), False
        elif stop in scene.breaks[1:]:
            block.moving = False
        if any(abs(stop - each) < 1e-12 for each in wanted):
            found.time_s.append(stop)
            found.theta_rad.append(float(y[2]))
            found.theta_rate_rad_s.append(float(y[3]))
        if not resting and t < stop:
            t = stop
    return found


def _lift(block: Block, start: float) -> float:
    """The instant at which the shaken ground lifts Housner's block, in the first quarter of the pulse."""

    def rests(t: float) -> bool:
        x, gravity = block.ground(t)
        return x * block.h <= gravity * (block.b - block.e)

    return _end_of(rests, start, start + PULSE_PERIOD_S / 4, 60)


def _advance(block: Block, regime: Regime, solver: DOP853, found: Solution) -> tuple[float, State, Regime]:
    """Steps to the end of a stretch or of the regime: instant, state and regime there."""
    while solver.status == "running":
        start, before = solver.t, solver.y.copy()
        if message := solver.step():
            raise ArithmeticError(message)
        dense = solver.dense_output()
        end, after = _until_change(block, regime, start, solver.t, dense)
        _extremes(start, end, before, dense, found)
        if after != regime:
            state = _again(block, regime, start, before, end)
            if after[-1] != regime[-1]:
                state[2] = 0.0  # the corner changes where θ does its sign
            return end, state, after
    return solver.t, solver.y.tolist(), regime


def _again(block: Block, regime: Regime, start: float, before: State, end: float) -> list[float]:
    """The step taken again to end where the regime does: more digits than the dense output has."""
    if end - start < 1e-12:
        return [float(each) for each in before]
    solver = DOP853(block.rates(regime), start, before, end, rtol=RTOL, atol=ATOL, first_step=end - start)
    while solver.status == "running":
        if message := solver.step():
            raise ArithmeticError(message)
    state: list[float] = solver.y.tolist()
    return state


def _until_change(
    block: Block, regime: Regime, start: float, end: float, dense: Callable[[float], State]
) -> tuple[float, Regime]:
    """The end of a step or of the regime in it, and the regime there."""

    def same(t: float) -> bool:
        return block.regime(dense(t)) == regime

    for left, right in _parts(start, end):
        if not same(right):
            found = _end_of(same, left, right)
            return found, block.regime(dense(found))
    return end, regime


def _extremes(
    start: float, end: float, before: State, dense: Callable[[float], State], found: Solution
) -> None:
    """Changes of sign of θ and of θ̇ within a step."""
    for component, into in ((2, found.impacts), (3, found.peaks)):
        value = before[component]
        for left, right in _parts(start, end):
            reached = dense(right)[component]
            if value * reached <= 0 and value != 0:
                at = _end_of(_has_sign(dense, component, value), left, right)
                state = dense(at)
                if max(abs(state[2]), abs(state[3])) > 1e-12:
                    into.append((at, float(state[2]), float(state[3])))
            value = reached


def _has_sign(dense: Callable[[float], State], component: int, sign: float) -> Callable[[float], bool]:
    return lambda t: dense(t)[component] * sign > 0


def _parts(start: float, end: float) -> Iterator[tuple[float, float]]:
    """A step in parts."""
    places = [*(start + (end - start) * part / PARTS for part in range(PARTS)), end]
    yield from pairwise(places)


def _end_of(holds: Callable[[float], bool], low: float, high: float, halvings: int = 52) -> float:
    """The first instant, to the last digit, at which something does not hold that did at the lower one."""
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return high
