"""Effects that no law or input contains: of bed, base, air, beam and record, with their influence on θ(t).

A small force or moment that an effect adds along the motion of a fit is one of a ground that accelerates, so
that the law itself gives the derivative of θ by the amount of the effect. A beam, a sensor and lost samples
change the reading alone; a base that moves sideways changes both. A part of block or table that swings shows
as a line in the residual.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.fft import rfft, rfftfreq
from scipy.signal import lfilter

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.identification.against_noise import noise_of
from freerock.identification.inputs_with_priors import Posterior
from freerock.models.block import Block
from freerock.models.contact import Foundation
from freerock.models.ground import accelerogram
from freerock.models.laws import CANDIDATES, MODELS, Rules, law_of
from freerock.models.simulate import Solver, simulate
from freerock.rotation.as_measured import as_released
from freerock.rotation.beam import displaced, turned

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(48)  # over the base
EITHER = (-math.inf, math.inf)


@dataclass(frozen=True)
class Tries:
    """Which effects are tried, and how; by judgement.

    Parameters
    ----------
    step_s, longest : float, int
        Of the path [s], and its instants at most.
    small : float
        Of the weight's moment, by which an effect acts for its derivative.
    dull_rad_s : float
        Rate over which dry friction turns round [rad/s].
    relaxes_s : tuple of float
        Relaxation times of a bed [s].
    grips : tuple of float
        Friction coefficients of a base that slips.
    hollow_m, hollow_most : float
        Depth of a hollow base, for its derivative [m], and at most, over its half width.
    like_it : (float, float)
        Times itself, within which the amount of an effect lies that has no size of its own.
    inclined_rad, bent : float
        At most, of a beam and of a sensor over its range: more than twice what kinds of laboratories have.
    places : int
        Instants at which samples may be lost.
    line_hz : (float, float)
        Between which a line is sought [Hz].
    own_line : float
        Times the frequency of the block in full contact, up to which a line is its own. Set on ten kinds of
        laboratories without a part that swings, whose lines lie at 0.87 to 1.06 of it.
    line_width, line_least_hz : float
        Half the width of a line over its frequency, and at least [Hz].
    above, sure : float
        Times the power on either side, and standard deviations of the noise, from which it is a line.
    """

    step_s: float = 1e-3
    longest: int = 12000
    small: float = 1e-4
    dull_rad_s: float = 2e-3
    relaxes_s: tuple[float, ...] = (0.005, 0.02, 0.08)
    grips: tuple[float, ...] = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
    hollow_m: float = 1e-5
    hollow_most: float = 0.05
    like_it: tuple[float, float] = (0.3, 3.0)
    inclined_rad: float = 0.2
    bent: float = 0.025
    places: int = 48
    line_hz: tuple[float, float] = (14.0, 120.0)
    own_line: float = 1.25
    line_width: float = 0.06
    line_least_hz: float = 2.0
    above: float = 3.0
    sure: float = 8.0


TRIES = Tries()


class Effect(NamedTuple):
    """An effect, the derivative of the residual by its amount [rad], and what it is in words by its amount.

    Amounts lie within `bounds`, in units of `unit`.
    """

    name: str
    column: Floats
    text: Callable[[float], str]
    bounds: tuple[float, float] = (0.0, math.inf)
    unit: float = 1.0


def effects(best: Posterior) -> Iterator[Effect]:
    """What may be besides law and inputs, where the fit of one run ended."""
    yield from _of_reading(best)
    path = _Path.of(best)
    if path is not None:
        yield from _of_forces(path)
        yield from _of_grip(path)
        yield from _of_base(path)


def forces(best: Posterior) -> list[Effect]:
    """The `effects` that act on the block alike on either side; none where the law can't be followed."""
    path = _Path.of(best)
    return [] if path is None else [*_of_forces(path)]


def line_in(best: Posterior) -> tuple[float, float]:
    """Frequency [Hz] of a line in the residual, and its share of the misfit; (0, 0) without one.

    It lies above the block's own frequency in full contact, with which the last swings of any misfit end.
    """
    motion, left = best.nuisances.problem.motions[0], best.residual
    rate_hz = 1 / float(np.median(np.diff(best.samples.time_s)))
    power = np.abs(rfft(left - left.mean())) ** 2 / len(left)
    share = power / np.maximum(noise_of(motion).density(rfftfreq(len(left))), np.finfo(float).tiny)
    found, frequency = np.cumsum(np.append(0.0, share)), rfftfreq(len(left), 1 / rate_hz)
    lowest, highest = TRIES.line_hz
    lowest, highest = max(lowest, TRIES.own_line * _full_contact_hz(best)), min(highest, rate_hz / 4)
    middle = np.flatnonzero((frequency > lowest) & (frequency < highest))
    half = np.maximum(TRIES.line_width * frequency[middle], TRIES.line_least_hz)
    ends = [np.searchsorted(frequency, frequency[middle] + by * half) for by in (-3, -1, 1, 3)]
    below, inside, above = (found[high] - found[low] for low, high in pairwise(ends))
    count = ends[2] - ends[1]
    is_line = (inside > TRIES.above * np.maximum(below, above)) & (
        inside - count > TRIES.sure * np.sqrt(count)
    )
    if not is_line.any():
        return 0.0, 0.0
    at = int(np.argmax(np.where(is_line, inside, 0.0)))
    band = slice(ends[1][at], ends[2][at])
    center = float(np.sum(frequency[band] * share[band]) / np.sum(share[band]))
    return center, float(inside[at] / found[-1])


def _full_contact_hz(best: Posterior) -> float:
    """Frequency of small rocking on the whole base [Hz], by the moment 2/3 k b³ θ (`models.series`); 0 of a
    rigid law."""
    problem = best.nuisances.problem
    values = problem.named(best.x)
    block = problem.blocks[0].as_found(values)
    stiffness = 2 / 3 * values.get("k", 0.0) * block.b**3 - block.mass_kg * block.g * block.h
    inertia = block.inertia_cm + block.mass_kg * block.h**2
    return math.sqrt(max(stiffness, 0.0) / inertia) / (2 * math.pi)


@dataclass(frozen=True)
class _Path:
    """The motion of a fit at even instants since its release, and what makes it."""

    best: Posterior
    law: str
    block: Block
    values: dict[str, float]
    rules: Rules
    time_s: Floats

    @classmethod
    def of(cls, best: Posterior) -> "_Path | None":
        """None where the law can't be followed."""
        problem = best.problem
        values = problem.named(best.x)
        values = {"theta0": problem.motions[0].theta0, "t0": 0.0, **values}
        block, law = problem.blocks[0], CANDIDATES[problem.model].law
        values = as_released(law, block, values, problem.motions[0].view)
        n = min(int((best.own.time_s[-1] - values["t0"]) / TRIES.step_s) + 2, TRIES.longest)
        time_s = np.arange(n, dtype=float) * TRIES.step_s
        path = cls(best, law, block.as_found(values), values, problem.rules, time_s)
        try:
            return path if np.all(np.isfinite(path.states)) else None
        except FreerockError:
            return None

    @cached_property
    def states(self) -> Floats:
        """θ, its rate, z and its rate, shape (4, n_time)."""
        return self._moved(np.zeros((2, len(self.time_s))))

    def _moved(self, ground: Floats) -> Floats:
        own = {name: self.values[name] for name in MODELS[self.law]}
        found = simulate(
            self.law,
            self.block,
            own,
            self.time_s,
            theta0=self.values["theta0"],
            base_excitation=accelerogram(self.time_s, *ground),
            rules=self.rules,
            solver=Solver(1e-8),
        )
        return np.array([found.theta, found.theta_rate, found.z_cb, found.z_cb_rate])

    def by(self, moment: Floats, force: Floats | float = 0.0) -> Floats | None:
        """Derivative of the residual by the size of a moment on θ [N m] and an upward force [N]."""
        m = self.block.mass_kg
        ground = np.array([moment / (m * self.lever), -force / m + 0 * moment])
        most = np.abs(ground).max()
        if not most > 0:
            return None
        size = TRIES.small * self.block.g * math.tan(self.block.theta_cr) / most
        try:
            change = (self._moved(size * ground)[0] - self.states[0]) / size
        except FreerockError:
            return None
        if not np.all(np.isfinite(change)):
            return None
        since = self.best.own.time_s - self.values["t0"]
        return np.asarray(np.interp(since, self.time_s, change, left=0.0))

    def on_base(self, f: Floats) -> Floats | None:
        """The same of a force per width at the points of the base, shape (n_points, n_time) [N/m]."""
        weights = self.block.b * WEIGHTS
        force = weights @ f
        moment = (weights * self.points) @ f * np.cos(self.states[0])
        return self.by(self.along * force - moment, force)

    @property
    def points(self) -> Floats:
        """Of the base, from its middle [m]."""
        return np.asarray(self.block.b * POINTS)

    @cached_property
    def along(self) -> Floats:
        """How far right of the base's middle the centre of mass lies [m]."""
        return np.asarray(self.block.h * np.sin(self.states[0]) + self.block.e * np.cos(self.states[0]))

    @cached_property
    def arm(self) -> Floats:
        """How far right of the base's middle it is held sideways [m]."""
        pivots = self.rules.kinematics == "pivoting" or not law_of(self.law).is_foundation
        return np.asarray(self.block.b * np.sign(self.states[0]) * pivots)

    @cached_property
    def lever(self) -> Floats:
        """By which the centre of mass moves sideways with θ [m]."""
        sin, cos = np.sin(self.states[0]), np.cos(self.states[0])
        return np.asarray(self.block.h * cos - self.block.e * sin + self.arm * sin)

    @cached_property
    def depths(self) -> Floats:
        """Of the points below the ground, shape (n_points, n_time) [m]; negative above it."""
        theta, _, z, _ = self.states
        return np.asarray(z + np.outer(self.points, np.sin(theta)))

    def derivative(self, values: Floats) -> Floats:
        """Derivative of values over time by it."""
        return np.asarray(np.gradient(values, TRIES.step_s))

    @property
    def presses(self) -> tuple[Floats, Floats]:
        """Force of the bed [N], and its moment about the middle of the base [N m]."""
        pressure, weights = self.pressed(self.points[:, None]), self.block.b * WEIGHTS
        return weights @ pressure, (weights * self.points) @ pressure

    def pressed(self, u: Floats | float, gap: Floats | float = 0.0) -> Floats:
        """Force per width of the law at places of the base [N/m], which lie so far above its corners [m]."""
        theta, rate, z, z_rate = self.states
        depth, deeper = z + u * np.sin(theta) - gap, z_rate + u * rate * np.cos(theta)
        touching = np.maximum(depth, 0.0)
        return np.where(depth > 0, Foundation.of(self.values).pressure(touching, deeper), 0.0)

    @cached_property
    def held(self) -> tuple[Floats, Floats]:
        """Forces that hold the base sideways and carry it [N]."""
        theta, rate, _, z_rate = self.states
        m, fall = self.block.mass_kg, z_rate
        if not law_of(self.law).is_foundation:
            fall = -self.block.b * np.cos(theta) * np.sign(theta) * rate
        sideways, up = self.lever * rate, -fall - self.along * rate
        return m * self.derivative(sideways), np.maximum(m * (self.block.g + self.derivative(up)), 0.0)

    def slid(self, grip: float) -> tuple[Floats, Floats]:
        """Moment on θ [N m] and way to the right [m] of a base that slides where friction is too small."""
        m, dt, inertia = self.block.mass_kg, TRIES.step_s, self.block.inertia_cm
        if not law_of(self.law).is_foundation:  # which falls as it turns
            inertia = inertia + m * (self.arm * np.cos(self.states[0]) - self.along) ** 2
        lighter = 1 / m + self.lever**2 / inertia
        needed, carried = self.held
        rate, rates, lacks = 0.0, [], []
        for holds, most, by in zip(needed.tolist(), (grip * carried).tolist(), lighter.tolist(), strict=True):
            sticks = rate == 0 and abs(holds) <= most
            lack = 0.0 if sticks else -math.copysign(most, rate or -holds) - holds
            faster = rate + lack * by * dt
            rate = 0.0 if faster * rate < 0 else faster
            rates.append(rate)
            lacks.append(lack)
        return -self.lever * lacks * m * lighter, np.cumsum(rates) * dt

    @cached_property
    def across(self) -> tuple[Floats, Floats] | None:
        """As `_across` of the fit."""
        return _across(self.best)

    def aside(self, moment: Floats, way: Floats) -> Floats | None:
        """Derivative of the residual by the size of a moment on θ [N m] and of a way to the right [m], which
        a zero between the rests before and after halves."""
        change = self.by(moment)
        if change is None or self.across is None:
            return change
        since = self.best.own.time_s - self.values["t0"]
        seen = np.interp(since, self.time_s, way, left=0.0) - way[-1] / 2
        return np.asarray(change + np.abs(self.across[1]) * seen)


def _across(best: Posterior) -> tuple[Floats, Floats] | None:
    """What a horizontal beam reads of a fit [m], and rotation by reading [rad/m]; None of other sensors."""
    problem, theta = best.nuisances.problem, best.residual + best.samples.theta
    view, block, small = problem.motions[0].view, problem.blocks[0], 1e-6
    if view is None or view.laser.beam != "horizontal":
        return None
    way = displaced(theta, block, view.laser)
    turns = (turned(way + small, block, view.laser) - turned(way - small, block, view.laser)) / (2 * small)
    return way, turns


def _of_reading(best: Posterior) -> Iterator[Effect]:
    """Beam, sensor, and samples that are lost."""
    samples, view = best.samples, best.nuisances.problem.motions[0].view
    theta, across = best.residual + samples.theta, _across(best)
    if across is not None and view is not None:
        way, slope = across
        turn = np.sign(slope) * theta
        inclined, lies = slope * way * np.tan(turn), (-TRIES.inclined_rad, TRIES.inclined_rad)
        yield Effect("beam", inclined, lambda a: f"inclined by {math.degrees(a):+.2g}°", lies)
        span = view.laser.range_m or 0.1
        bent = 4 * way**2 / span
        lies = (-TRIES.bent, TRIES.bent)
        yield Effect("sensor", slope * bent, "bent by {:+.2%} of its range".format, lies)
    rate = np.gradient(theta, samples.time_s)
    rate_hz = 1 / float(np.median(np.diff(samples.time_s)))
    for at in np.linspace(0.02, 0.8, TRIES.places) * samples.time_s[-1]:

        def text(a: float, at: float = float(at)) -> str:
            return f"{max(1, round(a * rate_hz))} lost at {at:.2f} s"

        yield Effect("samples", np.where(samples.time_s > at, rate, 0.0), text, (0.5 / rate_hz, math.inf))


def _of_forces(path: _Path) -> Iterator[Effect]:
    """Air, friction and what a bed may do that is the same everywhere."""
    rate = path.states[1]
    air = path.by(-rate * np.abs(rate))
    yield from _acting("air", air, "drag of {:.2g} N m s²".format)
    rubs = path.by(-np.tanh(rate / TRIES.dull_rad_s))
    yield from _acting("friction", rubs, "a moment of {:.2g} N m, as of a cable".format)
    if not law_of(path.law).is_foundation:
        return
    k, depth = path.values["k"], np.maximum(path.depths, 0.0)
    for tau in TRIES.relaxes_s:
        keep = math.exp(-TRIES.step_s / tau)
        memory = lfilter([1.0], [1.0, -keep], np.diff(depth, axis=1, prepend=depth[:, :1]), axis=1)
        relaxes = path.on_base(k * np.where(depth > 0, memory, 0.0))
        yield from _acting(
            "relaxation", relaxes, f"of the bed, {{:.1%}} in {1e3 * tau:g} ms".format, (0.0, 1.0)
        )


def _of_grip(path: _Path) -> Iterator[Effect]:
    """A base that friction holds where the bed presses, so that it rolls, and one that slides.

    Source: derived here, from no slip at the centre of the pressure and Coulomb's friction. Test:
    `tests/unit/test_causes.py::test_a_block_that_rolls_or_slides_moves_as_its_derivative_has_it`.
    """
    if law_of(path.law).is_foundation:
        force, moment = path.presses
        least, b = 1e-3 * path.block.weight, path.block.b  # of a force that has a centre
        centre = np.clip(moment / np.maximum(force, least), -b, b)
        less = np.where(force > least, centre - path.arm, 0.0) * np.sin(path.states[0])
        m, rate = path.block.mass_kg, path.states[1]
        pulls = -m * (less * path.derivative(path.lever * rate) + path.lever * path.derivative(less * rate))
        rolls = path.aside(pulls, np.cumsum(less * rate) * TRIES.step_s)
        text = "{:.1f} times that of a base held by friction".format
        yield from _acting("rolling", rolls, text, TRIES.like_it)
    for grip in TRIES.grips:
        slips = path.aside(*path.slid(grip))
        yield from _acting("slip", slips, f"friction coefficient about {grip:g}".format, TRIES.like_it)


def _of_base(path: _Path) -> Iterator[Effect]:
    """A bed or a corner that differs from left to right, and a base that is hollow in its middle."""
    if not law_of(path.law).is_foundation:
        return
    k, depth, b = path.values["k"], np.maximum(path.depths, 0.0), path.block.b
    sides = path.on_base(k * depth * np.sign(path.points)[:, None] / 2)
    yield from _acting("beds", sides, "the right one stiffer by {:+.1%}".format, EITHER)
    hollow = TRIES.hollow_m * (1 - (path.points[:, None] / b) ** 2)
    less = path.pressed(path.points[:, None], hollow) - path.pressed(path.points[:, None])
    gap = path.on_base(less / TRIES.hollow_m)
    yield from _acting("base", gap, lambda a: f"hollow by {1e3 * a:.2g} mm", (0.0, TRIES.hollow_most * b))
    right, left = path.pressed(b), path.pressed(-b)
    moment = b * (right + left) * np.cos(path.states[0]) / 2
    corner = path.by(-path.along * (right - left) / 2 + moment, -(right - left) / 2)
    yield from _acting("corner", corner, lambda a: f"the right one worn by {1e3 * a:+.2g} mm more", EITHER)


def _acting(
    name: str,
    column: Floats | None,
    text: Callable[[float], str],
    bounds: tuple[float, float] = (0.0, math.inf),
) -> Iterator[Effect]:
    """An effect by its derivative; none where the path has none."""
    if column is not None:
        yield Effect(name, column, text, bounds)
