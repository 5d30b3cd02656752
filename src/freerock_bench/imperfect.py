"""Blocks and beds that are not what any law says: motions for studies, by integrations of their own.

The base is cut into cells; each bears on two points of Gauss's rule in the part of it that touches. Explicit
midpoint rule in steps of 50 µs. A rigid block is integrated from impact to impact.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock.models.compiled import compiled
from freerock.models.contact import Foundation, static_depth

STEP_S = 5e-5
CELLS = 160
GAUSS = 3**-0.5
DULL_RAD_S = 0.002  # rate over which dry friction turns round
LEAST_RAD = 2e-5  # a rigid block lies still below
NOTHING = {
    "power": 0.0,  # of the depth, by which the force is more than linear
    "damping_power": 0.0,  # the same of the damping
    "middle_m": 1.0,  # depth at which these powers change nothing
    "tensionless": 0.0,  # 1 where the bed can't pull
    "by_amplitude": 0.0,  # share by which the damping is more in the highest swings and less in the lowest
    "hardens_per_s": 0.0,  # share of k
    "friction_nm": 0.0,  # against turning
    "air_nms2": 0.0,  # the same, by the square of the rate
    "off_m": 0.0,  # of the centre of mass, to the right
    "grip": 0.0,  # coefficient of friction of a base that may slip; 0 of one that is guided
    "side_k": 1e7,  # [N/m], what holds that base below the limit
    "side_c": 1e3,  # [N s/m]
}


def base_of(
    block: Block,
    *,
    radius_m: float = 0.0,
    hollow_m: float = 0.0,
    feet: float = 0.0,
) -> Floats:
    """Cells of a base, shape (n_cells, 5): middles and half lengths [m], heights above its plane [m], slopes,
    1 where they touch. They are finer towards the edges.

    Parameters
    ----------
    block : Block
    radius_m, hollow_m : float
        Radius of the edges; depth of a hollow in the middle.
    feet : float
        Share of the width, in the middle, that does not touch.
    """
    b = block.b
    ends = -b * np.cos(np.pi * np.arange(CELLS + 1) / CELLS)
    u, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    beyond = np.maximum(np.abs(u) - (b - radius_m), 0.0)
    arc = np.sqrt(np.maximum(radius_m**2 - beyond**2, 1e-30))
    round_off = (radius_m - arc, np.sign(u) * beyond / arc) if radius_m else (0.0 * u, 0.0 * u)
    height = round_off[0] + hollow_m * (1 - (u / b) ** 2)
    slope = round_off[1] - 2 * hollow_m * u / b**2
    touches = np.abs(u) >= feet * b
    return np.column_stack([u, half, height, slope, touches])


@compiled()
def _on_base(y, t, soil, base, extra, peak):  # type: ignore[no-untyped-def]
    """Force [N] and moment [N m] of the bed about the base's centre."""
    k, lam = soil
    power, damping_power, middle, tensionless, by_amplitude, hardens = extra[:6]
    z, theta, _, z_rate, w, _ = y
    sin, cos = math.sin(theta), math.cos(theta)
    stiffness = k * (1 + hardens * t)
    damping = lam * (1 + by_amplitude * (2 * peak - 1))
    force = moment = 0.0
    for i in range(base.shape[0]):
        u, half_cell, height, slope, touches = base[i]
        depth, deeper = z + u * sin - height, half_cell * (sin - slope)
        if touches == 0.0 or depth <= -abs(deeper):
            continue
        low, high = -1.0, 1.0  # what touches of the cell, in half lengths from its middle
        if depth < abs(deeper):
            if deeper > 0.0:
                low = -depth / deeper
            else:
                high = -depth / deeper
        for node in (-GAUSS, GAUSS):
            at = 0.5 * (low + high) + 0.5 * (high - low) * node
            place, below = u + half_cell * at, depth + deeper * at
            rate = z_rate + place * w * cos
            elastic, viscous = stiffness * below, damping * below * rate
            if power != 0.0:
                elastic *= (below / middle) ** power
            if damping_power != 0.0:
                viscous *= (below / middle) ** damping_power
            f = elastic + viscous
            if tensionless > 0.0:
                f = max(f, 0.0)
            part = 0.5 * half_cell * (high - low) * f
            force += part
            moment += part * place
    return force, moment * cos


@compiled()
def _rates(y, t, body, soil, base, extra, slid, peak):  # type: ignore[no-untyped-def]
    """Rates of z, θ, x of the base's centre and of their rates; the force that holds the base sideways."""
    m, inertia, h = body
    friction, air, off, grip, side_k, side_c = extra[6:]
    _, theta, x, z_rate, w, x_rate = y
    sin, cos = math.sin(theta), math.cos(theta)
    force, moment = _on_base(y, t, soil, base, extra, peak)
    ahead, up = h * sin + off * cos, h * cos - off * sin  # of the centre of mass, from the base's
    turning = ahead * force - moment - friction * math.tanh(w / DULL_RAD_S) - air * w * abs(w)
    side = 0.0
    if grip > 0.0:
        most = grip * max(force, 0.0)
        side = min(max(-side_k * (x - slid) - side_c * x_rate, -most), most)
        turn = (turning - side * up) / inertia
        x_turn = side / m - up * turn + ahead * w * w
    else:
        turn = (turning + m * up * ahead * w * w) / (inertia + m * up * up)
        x_turn = 0.0
    fall = GRAVITY - force / m - ahead * turn - up * w * w
    return np.array([z_rate, w, x_rate, fall, turn, x_turn]), side


@compiled()
def _march(start, n, every, dt, body, soil, base, extra):  # type: ignore[no-untyped-def]
    """Depth and rotation of the base's centre and their rates at each sample, shape (n, 4)."""
    y, slid, peak, found = start.copy(), 0.0, 1.0, np.zeros((n, 4))
    found[0] = y[0], y[1], y[3], y[4]
    grip, side_k, side_c = extra[9:]
    for i in range(1, (n - 1) * every + 1):
        t = (i - 1) * dt
        first, _ = _rates(y, t, body, soil, base, extra, slid, peak)
        middle = y + 0.5 * dt * first
        second, side = _rates(middle, t + 0.5 * dt, body, soil, base, extra, slid, peak)
        if y[4] * (y[4] + dt * second[4]) < 0.0 and y[4] * y[1] > 0.0:
            peak = abs(y[1] / start[1])
        y = y + dt * second
        held = -side_k * (y[2] - slid) - side_c * y[5]
        if grip > 0.0 and abs(held) > abs(side) and held * side > 0.0:
            slid = y[2] + (side + side_c * y[5]) / side_k
        if i % every == 0:
            found[i // every] = y[0], y[1], y[3], y[4]
    return found


def on_bed(
    block: Block,
    soil: Mapping[str, float],
    theta0: float,
    time_s: Floats,
    *,
    base: Mapping[str, float] | None = None,
    **extra: float,
) -> Floats:
    """θ(t) of a block on a bed of Hunt and Crossley's law with something besides, shape (n_time,) [rad].

    Parameters
    ----------
    block : Block
    soil : mapping of str to float
        k and lambda [SI].
    theta0 : float
        Release, from rest [rad].
    time_s : ndarray, shape (n_time,)
        Evenly spaced, from 0 [s].
    base : mapping of str to float, optional
        Of `base_of`.
    **extra : float
        What differs from `NOTHING`.
    """
    bed = _Bed(block, soil, base_of(block, **(base or {})), NOTHING | extra)
    return np.asarray(bed.states(theta0, time_s)[:, 1])


def tops_on_bed(
    block: Block,
    soil: Mapping[str, float],
    theta0: float,
    time_s: Floats,
    *,
    base: Mapping[str, float] | None = None,
    **extra: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """The motion of `on_bed` and what is left of its energy at the release and at the top after each impact.

    Arguments as those of `on_bed`; the base does not slip.

    Returns
    -------
    theta, impacts_s, heights, energies : ndarray
        θ(t), shape (n_time,) [rad]; instants of the impacts, shape (n_impacts,) [s]; |θ| [rad] and energy [J]
        of the tops above rest, upright, shape (n_impacts + 1,).
    """
    bed = _Bed(block, soil, base_of(block, **(base or {})), NOTHING | extra)
    states = bed.states(theta0, time_s)
    theta, passes = states[:, 1], np.flatnonzero(states[1:, 1] * states[:-1, 1] < 0)
    tops = [0, *(i + int(np.argmax(np.abs(theta[i:j]))) for i, j in pairwise([*passes + 1, len(theta)]))]
    heights, energies = np.abs(theta[tops]), [bed.energy(states[i], time_s[i]) for i in tops]
    at_rest = bed.energy(np.array([bed.depth(0.0), 0.0, 0.0, 0.0]), 0.0)
    return theta, time_s[passes], heights, np.array(energies) - at_rest


@dataclass(frozen=True)
class _Bed:
    """A block, k and lambda of the bed, cells of the base, and what differs."""

    block: Block
    soil: Mapping[str, float]
    cells: Floats
    extra: Mapping[str, float]

    @cached_property
    def _law(self) -> tuple[Floats, Floats]:
        """Soil and extra as compiled functions take them."""
        return np.array([self.soil["k"], self.soil["lambda"]]), np.array([*self.extra.values()], float)

    def depth(self, theta: float) -> float:
        """Of the base's centre, of a block held at an angle [m]."""
        law, values = self._law

        def excess(z: float) -> float:
            held = np.array([z, theta, 0.0, 0.0, 0.0, 0.0])
            weight = self.block.mass_kg * GRAVITY
            return float(_on_base(held, 0.0, law, self.cells, values, 1.0)[0]) - weight

        deepest = static_depth(self.block, Foundation(self.soil["k"]), theta) + self.block.b / 2
        return float(brentq(excess, -self.block.b, deepest, xtol=1e-12))

    def states(self, theta0: float, time_s: Floats) -> Floats:
        """Depth, rotation and their rates over time, shape (n_time, 4) [m, rad, m/s, rad/s]."""
        assert {*self.extra} == {*NOTHING}, self.extra
        step, block = time_s[1] - time_s[0], self.block
        every = round(step / STEP_S)
        body = np.array([block.mass_kg, block.inertia_cm, block.h])
        start = np.array([self.depth(theta0), theta0, 0.0, 0.0, 0.0, 0.0])
        return np.asarray(
            _march(start, len(time_s), every, step / every, body, self._law[0], self.cells, self._law[1])
        )

    def energy(self, state: Floats, time_s: float) -> float:
        """Of a block that does not turn [J]: of sinking, weight and what the bed has stored."""
        z, theta, z_rate, _ = state
        m, power = self.block.mass_kg, self.extra["power"]
        sin, cos = math.sin(theta), math.cos(theta)
        u, half, height, slope, touches = self.cells.T
        depth, deeper = z + u * sin - height, half * (sin - slope)
        with np.errstate(divide="ignore", invalid="ignore"):
            edge = np.where(np.abs(depth) < np.abs(deeper), -depth / deeper, np.nan)
        low = np.where(np.isfinite(edge) & (deeper > 0), edge, -1.0)
        high = np.where(np.isfinite(edge) & (deeper < 0), edge, 1.0)
        stored = 0.0
        for node in (-GAUSS, GAUSS):
            below = np.maximum(depth + deeper * (0.5 * (low + high) + 0.5 * (high - low) * node), 0.0)
            each = 0.5 * half * (high - low) * below ** (2 + power)
            stored += float(np.sum(np.where(touches > 0, each, 0.0)))
        stiffness = self.soil["k"] * (1 + self.extra["hardens_per_s"] * time_s)
        stored *= stiffness / (2 + power) / self.extra["middle_m"] ** power
        rise = self.block.h * cos - self.extra["off_m"] * sin - z
        return float(stored + m * z_rate**2 / 2 + m * GRAVITY * rise)


def rigid(
    block: Block,
    restitution: Callable[[float], float],
    theta0: float,
    time_s: Floats,
    *,
    radius_m: float = 0.0,
    friction_nm: float = 0.0,
    air_nms2: float = 0.0,
) -> tuple[Floats, Floats]:
    """θ(t) of a rigid block, shape (n_time,) [rad], and of each impact the rate before it [rad/s] and its
    restitution, shape (n_impacts, 2).

    Parameters
    ----------
    block : Block
    restitution : callable
        Of the rate before an impact [rad/s], positive from left to right.
    theta0 : float
        Release, from rest [rad].
    time_s : ndarray, shape (n_time,)
        From 0 [s].
    radius_m : float
        Of the edges over which it rolls.
    friction_nm, air_nms2 : float
        As for `on_bed`.
    """
    from scipy.integrate import solve_ivp

    m, b, h = block.mass_kg, block.b, block.h

    def rates(_: float, y: Any) -> list[float]:
        side = 1.0 if y[0] > 0 or (y[0] == 0 and y[1] > 0) else -1.0
        t, w = abs(y[0]), side * y[1]
        sin, cos = math.sin(t), math.cos(t)
        across, up = b - radius_m, h - radius_m
        x1, z1 = radius_m + across * sin + up * cos, across * cos - up * sin
        x2, z2 = z1, -across * sin - up * cos
        inertia = block.inertia_cm + m * (x1 * x1 + z1 * z1)
        turning = -m * GRAVITY * z1 - m * (x1 * x2 + z1 * z2) * w**2
        turning -= friction_nm * math.tanh(w / DULL_RAD_S) + air_nms2 * w * abs(w)
        return [y[1], side * turning / inertia]

    theta, impacts, t, y = np.zeros(len(time_s)), list[tuple[float, float]](), 0.0, [theta0, 0.0]
    while t < time_s[-1]:
        side = math.copysign(1.0, y[0] or y[1])

        def flat(_: float, y: Any) -> float:
            return float(y[0])

        flat.terminal, flat.direction = True, -side  # type: ignore[attr-defined]
        begin = [y[0] or side * 1e-15, y[1]]
        step = solve_ivp(
            rates,
            (t, time_s[-1] + 1e-3),
            begin,
            "DOP853",
            events=flat,
            dense_output=True,
            rtol=1e-9,
            atol=1e-12,
        )
        inside = (time_s >= t) & (time_s < step.t[-1])
        theta[inside] = step.sol(time_s[inside])[0]
        if not step.t_events[0].size:
            break
        t, rate = step.t[-1], float(step.y[1, -1])
        share = restitution(rate)
        impacts.append((rate, share))
        y = [0.0, rate * share]
        if block.inertia_base * y[1] ** 2 / (2 * m * GRAVITY * b) < LEAST_RAD:
            break
    return theta, np.array(impacts)
