"""Mishaps of the virtual laboratory: what happens to base, block and hand while the block should rock freely.

Each function gives a motion for `record.Release.moves`; what cables and sensors do stands in `faults`.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock.models.contact import Foundation, State, lean, sideways, static_depth
from freerock.models.ground import tilted
from freerock.models.laws import LAWS
from freerock.models.simulate import Response
from freerock.virtual_lab.record import Moves, Scene, free_rocking

STOP_S = 0.03  # a hand stops a block within this time
KNOTS, WEIGHTS = np.polynomial.legendre.leggauss(24)  # over the part of the base that touches


def off_level(tilt_rad: float) -> Moves:
    """The base is off level, positive where it leans to the right.

    Angles count from where the block stands at rest. The finger fades as on a level base.
    """

    def moves(scene: Scene, since: Floats, start: State) -> Response:
        ground, stands = tilted(tilt_rad, since[-1]), 0.0
        if LAWS[scene.model].is_foundation:
            stands = lean(scene.block, Foundation.of(scene.parameters), tilt_rad)
        motion = free_rocking(scene, since, start._replace(theta=start.theta + stands), ground)
        return replace(motion, theta=motion.theta - stands)

    return moves


def pushed(rate_rad_s: float) -> Moves:
    """The finger leaves the block with a rate, positive away from rest."""

    def moves(scene: Scene, since: Floats, start: State) -> Response:
        rate = start.theta_rate + math.copysign(rate_rad_s, rate_rad_s * start.theta)
        return free_rocking(scene, since, start._replace(theta_rate=rate))

    return moves


def hit(at_s: float, rate_rad_s: float) -> Moves:
    """A blow changes the rate of the block by so much, at an instant after it is free."""
    return _interrupted(at_s, lambda state: state._replace(theta_rate=state.theta_rate + rate_rad_s))


def braked(at_s: float, share: float) -> Moves:
    """A hand takes a share of the rate of the block, at an instant after it is free."""
    return _interrupted(at_s, lambda state: state._replace(theta_rate=(1 - share) * state.theta_rate))


def caught(at_s: float, lasts_s: float) -> Moves:
    """A hand stops the block at an instant after it is free, holds it and lets it go again at once."""

    def moves(scene: Scene, since: Floats, start: State) -> Response:
        before, state = _until(scene, since, start, at_s)
        held = (since >= at_s) & (since < at_s + STOP_S + lasts_s)
        stopping = np.minimum((since[held] - at_s) / STOP_S, 1.0)
        stopped = state.theta + state.theta_rate * STOP_S / 2  # slowed down evenly
        theta = stopped - (stopped - state.theta) * (1 - stopping) ** 2
        depth, still = np.full(theta.size, state.z), np.zeros(theta.size)
        side = np.full(theta.size, np.sign(stopped), np.int8)
        hand = Response(since[held], theta, still, depth, still, side, np.empty(0), "completed", {})
        later = since[since >= at_s + STOP_S + lasts_s]
        free = free_rocking(scene, later - later[0], _at_rest(scene, stopped))
        return _joined(since, [before, hand, free], [0.0, at_s, later[0]])

    return moves


def rounded(radius_m: float) -> Moves:
    """The edges of the base are rounded: the law acts on what of the rounded base is below the ground."""

    def moves(scene: Scene, since: Floats, start: State) -> Response:
        from scipy.integrate import solve_ivp

        block, soil, rules = scene.block, Foundation.of(scene.parameters), scene.rules

        def rates(_: float, y: Floats) -> list[float]:
            theta, w, z, z_rate = y.tolist()
            force, moment = _on_rounded(block, soil, State(z, z_rate, theta, w), radius_m)
            m, s = block.mass_kg, math.sin(theta)
            lever, slope = sideways(block, theta, rules)
            turning = block.h * s * force - moment - m * lever * slope * w**2
            theta_rate2 = turning / (block.inertia_cm + m * lever**2)
            return [
                w,
                theta_rate2,
                z_rate,
                GRAVITY - force / m - block.h * (math.cos(theta) * w**2 + s * theta_rate2),
            ]

        begin = [start.theta, start.theta_rate, start.z, start.z_rate]
        found = solve_ivp(rates, (0, since[-1]), begin, "DOP853", t_eval=since, rtol=1e-7, atol=1e-10)
        theta, theta_rate, z, z_rate = found.y
        side = np.sign(theta).astype(np.int8)
        passed = since[1:][side[1:] != side[:-1]]
        return Response(since, theta, theta_rate, z, z_rate, side, passed, "completed", {})

    return moves


def _interrupted(at_s: float, change: Callable[[State], State]) -> Moves:
    """Free rocking whose state is changed at an instant."""

    def moves(scene: Scene, since: Floats, start: State) -> Response:
        before, state = _until(scene, since, start, at_s)
        after = free_rocking(scene, np.append(0.0, since[since >= at_s] - at_s), change(state))
        return _joined(since, [before, _samples(after, slice(1, None))], [0.0, at_s])

    return moves


def _until(scene: Scene, since: Floats, start: State, at_s: float) -> tuple[Response, State]:
    """Free rocking before an instant [s], and the state at that instant."""
    motion = free_rocking(scene, np.append(since[since < at_s], at_s), start)
    last = motion.z_cb, motion.z_cb_rate, motion.theta, motion.theta_rate
    state = State(*(float(each[-1]) for each in last))
    return _samples(motion, slice(-1)), state


def _samples(motion: Response, which: slice) -> Response:
    """Some of the samples of a motion."""
    names = ("time", "theta", "theta_rate", "z_cb", "z_cb_rate", "contact")
    columns: dict[str, Any] = {name: getattr(motion, name)[which] for name in names}
    return replace(motion, **columns)


def _joined(since: Floats, parts: Sequence[Response], starts_s: Sequence[float]) -> Response:
    """Motions one after the other; each one's impacts count from its start [s]."""
    names = ("theta", "theta_rate", "z_cb", "z_cb_rate", "contact")
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in names
    }
    ends = [*starts_s[1:], math.inf]
    impacts = [
        part.impacts[part.impacts < end - start] + start
        for part, start, end in zip(parts, starts_s, ends, strict=True)
    ]
    return replace(parts[-1], time=since, impacts=np.concatenate(impacts), **columns)


def _at_rest(scene: Scene, theta: float) -> State:
    """At rest at an angle [rad], as deep as the foundation carries the block there."""
    if not LAWS[scene.model].is_foundation:
        return State(0.0, 0.0, theta, 0.0)
    return State(static_depth(scene.block, Foundation.of(scene.parameters), theta), 0.0, theta, 0.0)


def _on_rounded(block: Block, soil: Foundation, state: State, radius_m: float) -> tuple[float, float]:
    """Force [N] and moment [N·m] of the contact law on a base with rounded edges, as `contact_force`.

    At u from the base's centre the base lies w(u) = ρ - sqrt(ρ² - v²) higher, with v = |u| - (b - ρ) > 0 on
    an edge of radius ρ. It touches where z + u sinθ > w(u), which is one interval, for w is convex.
    """
    flat, s = block.b - radius_m, abs(math.sin(state.theta))
    right = _end(state.z + flat * s, s, radius_m)
    if right is None:
        return 0.0, 0.0
    high = flat + right[1]
    low = -state.z / s if s > 0 else -math.inf
    if low > flat:
        low = flat + right[0]
    elif low < -flat:
        left = _end(state.z - flat * s, -s, radius_m)
        low = -flat - left[1] if left else -flat
    cuts = [low, *(cut for cut in (-flat, flat) if low < cut < high), high]
    force = moment = 0.0
    turns = math.copysign(1.0, state.theta)
    for u0, u1 in pairwise(cuts):
        u = turns * ((u0 + u1) / 2 + (u1 - u0) / 2 * KNOTS)
        v = np.maximum(np.abs(u) - flat, 0.0)
        depth = state.z + u * math.sin(state.theta) - (radius_m - np.sqrt(radius_m**2 - v**2))
        rate = state.z_rate + u * state.theta_rate * math.cos(state.theta)
        law = (u1 - u0) / 2 * WEIGHTS * (soil.k * depth + soil.c * rate + soil.lam * depth * rate)
        force += float(law.sum())
        moment += float(law @ u)
    return force, moment * math.cos(state.theta)


def _end(depth: float, slope: float, radius_m: float) -> tuple[float, float] | None:
    """Where v on an edge, which begins so deep [m], comes out: depth + v slope = ρ - sqrt(ρ² - v²)."""
    free = radius_m - depth
    root = radius_m**2 * (1 + slope**2) - free**2
    if radius_m * slope >= free:  # the whole edge touches
        return -math.inf, radius_m
    if root < 0:
        return None
    middle, half = free * slope, math.sqrt(root)
    return (middle - half) / (1 + slope**2), (middle + half) / (1 + slope**2)
