"""A rigid block in the plane that may leave the ground: flight, sliding, impacts at its two corners.

The centre of mass has x to the right and z upward, θ is positive clockwise. Between impacts the block
flies, turns about one corner that sticks or slides by Coulomb's law, or lies flat. On a base that leans to
the right by a tilt, x and z are along and across it. At an impact all corners on the ground act at once
(Moreau 1988, doi:10.1007/978-3-7091-2624-0_1): of each,

    0 ≤ P_n ⟂ v_n⁺ + e v_n⁻ ≥ 0,    |P_t| ≤ μ P_n,

P the impulse, v the velocity of the corner, e the normal restitution. With one corner it is the impact of
Wang and Mason (1992, doi:10.1115/1.2893771) with Newton's restitution. With two it also holds the corner that
was on the ground already. A slender block leaves it, as Housner's does. A squat one on a slippery base turns
back about it at -e times its rate. Newton's restitution may gain energy where the sliding turns round in an
impact (Wang and Mason 1992): seen at e above 0.8 only.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.compiled import compiled
from freerock.models.refusals import check_corners

FLIGHT, STICK, SLIDE, FLAT = 0, 1, 2, 3
LEFT, RIGHT = 0, 1
QUIET = 1e-4  # of √(g R): a corner that comes back more slowly stays on the ground
STEPS = 150.0  # per 1/p, at most so long is a step; the error per step is then below 1e-11 rad
HALVINGS = 60  # of a step in which something happens: to the last digit of time
OVER = math.pi / 2  # a block turned further lies on its side
SWEEPS = 200  # of the impulses of two corners
ENDS = ("completed", "overturned", "step_limit")
PlaneState = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class Bounces:
    """The motion of a block that may bounce.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Instants [s].
    state : ndarray, shape (n_time, 6)
        x, z of the centre of mass [m], θ [rad], and their rates [m/s, m/s, rad/s]; NaN once it lies on
        a side, and after too many impacts.
    impact_time_s : ndarray, shape (n_impacts,)
        Instants of the impacts [s].
    outcome : str
        "completed", "overturned" (on a side) or "step_limit" (too many impacts).
    """

    time_s: Floats
    state: Floats
    impact_time_s: Floats
    outcome: str

    @property
    def theta(self) -> Floats:
        """Rotation, shape (n_time,) [rad]."""
        return np.asarray(self.state[:, 2])


def bounce(
    block: Block,
    restitution: float,
    friction: float,
    start: PlaneState,
    time_s: ArrayLike,
    tilt: float = 0.0,
    max_impacts: int = 10_000,
) -> Bounces:
    """Motion of a rigid block whose corners bounce and slide.

    Parameters
    ----------
    block : Block
    restitution : float
        Normal restitution e of a corner, from 0 to below 1.
    friction : float
        Coulomb friction μ of a corner, 0 or more.
    start : tuple of 6 float
        x, z [m], θ [rad] and their rates at t = 0; no corner below the ground, z = 0.
    time_s : array_like, shape (n_time,)
        Increasing instants from 0 on [s].
    tilt : float
        Of the base, to the right [rad].
    max_impacts : int
        Impacts after which to give up.

    Raises
    ------
    FreerockError
        A corner below the ground, or e or μ out of range.
    """
    time = np.ascontiguousarray(time_s, float)
    state, impacts = np.empty((time.size, 6)), np.empty(max_impacts)
    shape = _shape(block, tilt)
    lowest = min(_gap(LEFT, start[1], start[2], shape), _gap(RIGHT, start[1], start[2], shape))
    check_corners(restitution, friction, lowest)
    begun = tuple(map(float, start))
    longest = 1 / (STEPS * block.p)
    n, end = _move(shape, float(restitution), float(friction), begun, time, longest, state, impacts)
    return Bounces(time, state, impacts[:n].copy(), ENDS[end])


def standing_on(block: Block, corner: int, theta: float, rate: float, x: float = 0.0) -> PlaneState:
    """PlaneState of a block that turns at a rate [rad/s] about a corner that sticks, at x [m], z = 0."""
    rx, rz = _arm(corner, theta, _shape(block, 0.0))
    return x - rx, -rz, theta, -rate * rz, rate * rx, rate


def _shape(block: Block, tilt: float) -> tuple[float, float, float, float, float, float, float]:
    """What moves: half width, height of the centre of mass, inertia over mass, the rate of a quiet corner,
    offset of the centre of mass, and gravity along the base and across it [SI]."""
    quiet = QUIET * math.sqrt(block.g * block.R)
    pull = block.g * math.sin(tilt), block.g * math.cos(tilt)
    return block.b, block.h, block.inertia_cm / block.mass_kg, quiet, block.e, *pull


@compiled()
def _arm(corner, theta, shape):
    """From the centre of mass to a corner [m]."""
    side = (shape[0] if corner == RIGHT else -shape[0]) - shape[4]
    c, s = math.cos(theta), math.sin(theta)
    return side * c - shape[1] * s, -side * s - shape[1] * c


@compiled()
def _gap(corner, z, theta, shape):
    """Height of a corner [m]."""
    return z + _arm(corner, theta, shape)[1]


@compiled()
def _forces(mode, sense, corner, theta, rate, friction, shape):
    """Friction and push of the ground on a corner over the mass, and the angular acceleration."""
    rx, rz = _arm(corner, theta, shape)
    inertia, fall = shape[2], shape[6] + rate * rate * rz
    if mode == SLIDE:
        share = 1 + rx * (rx + friction * sense * rz) / inertia
        if share > 0:
            push = fall / share
            return -friction * sense * push, push, -push * (rx + friction * sense * rz) / inertia
    turn = -(shape[6] * rx + shape[5] * rz) / (inertia + rx * rx + rz * rz)
    return rate * rate * rx - turn * rz - shape[5], fall + turn * rx, turn


@compiled()
def _on_corner(mode, sense, corner, x, theta, vx, rate, friction, shape, step):
    """x, θ and their rates a step later, by the classical Runge-Kutta rule of fourth order."""
    f1, _, a1 = _forces(mode, sense, corner, theta, rate, friction, shape)
    w2 = rate + 0.5 * step * a1
    f2, _, a2 = _forces(mode, sense, corner, theta + 0.5 * step * rate, w2, friction, shape)
    w3 = rate + 0.5 * step * a2
    f3, _, a3 = _forces(mode, sense, corner, theta + 0.5 * step * w2, w3, friction, shape)
    w4 = rate + step * a3
    f4, _, a4 = _forces(mode, sense, corner, theta + step * w3, w4, friction, shape)
    moved = theta + step / 6 * (rate + 2 * w2 + 2 * w3 + w4)
    turned = rate + step / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    if mode == STICK:
        before, after = _arm(corner, theta, shape), _arm(corner, moved, shape)
        return x + before[0] - after[0], moved, -turned * after[1], turned
    pull = shape[5]
    u2, u3 = vx + 0.5 * step * (f1 + pull), vx + 0.5 * step * (f2 + pull)
    u4 = vx + step * (f3 + pull)
    along = x + step / 6 * (vx + 2 * u2 + 2 * u3 + u4)
    return along, moved, vx + step / 6 * (f1 + 2 * f2 + 2 * f3 + f4 + 6 * pull), turned


@compiled()
def _advanced(mode, sense, corner, y, friction, shape, step):
    """The state a step later, in one mode of motion."""
    x, z, theta, vx, vz, rate = y
    if mode == FLIGHT:
        fallen = z + step * (vz - 0.5 * shape[6] * step)
        along = x + step * (vx + 0.5 * shape[5] * step)
        return along, fallen, theta + step * rate, vx + shape[5] * step, vz - shape[6] * step, rate
    if mode == FLAT:
        way = math.copysign(1.0, vx if vx != 0 else shape[5])
        gains = way * shape[5] - friction * shape[6]  # of the speed, that way
        lasts = min(step, abs(vx) / -gains) if gains < 0 else step
        later = abs(vx) + gains * lasts if lasts == step else 0.0
        return x + way * lasts * 0.5 * (abs(vx) + later), shape[1], 0.0, way * later, 0.0, 0.0
    x, theta, vx, rate = _on_corner(mode, sense, corner, x, theta, vx, rate, friction, shape, step)
    rx, rz = _arm(corner, theta, shape)
    return x, -rz, theta, vx, rate * rx, rate


@compiled()
def _goes_on(mode, sense, corner, y, friction, shape):
    """Whether a mode of motion still holds; smaller than 0 where it does not."""
    _, z, theta, vx, _, rate = y
    if mode == FLAT:
        return 1.0
    if mode == FLIGHT:
        return min(_gap(LEFT, z, theta, shape), _gap(RIGHT, z, theta, shape)) + 1e-15
    along, push, _ = _forces(mode, sense, corner, theta, rate, friction, shape)
    free = min(_gap(1 - corner, z, theta, shape) + 1e-15, push)
    if mode == STICK:
        return min(free, friction * push - abs(along) + 1e-12)
    slips = sense * (vx + rate * _arm(corner, theta, shape)[1])
    return min(free, slips + 1e-15)


@compiled()
def _strike(y, down, restitution, friction, shape):
    """Velocities after an impact of the corners that are down, by sweeps over their impulses."""
    _, _, theta, vx, vz, rate = y
    inertia, quiet = shape[2], shape[3]
    impulse = np.zeros((2, 2))
    before = np.zeros(2)
    for corner in range(2):
        before[corner] = min(vz - rate * _arm(corner, theta, shape)[0], 0.0)
        if before[corner] > -quiet:
            before[corner] = 0.0
    for _ in range(SWEEPS):
        changed = 0.0
        for corner in range(2):
            if not down[corner]:
                continue
            rx, rz = _arm(corner, theta, shape)
            up = vz - rate * rx + restitution * before[corner]
            normal = max(0.0, impulse[corner, 1] - up / (1 + rx * rx / inertia))
            add = normal - impulse[corner, 1]
            impulse[corner, 1] = normal
            vz += add
            rate -= add * rx / inertia
            along = impulse[corner, 0] - (vx + rate * rz) / (1 + rz * rz / inertia)
            along = min(max(along, -friction * normal), friction * normal)
            push = along - impulse[corner, 0]
            impulse[corner, 0] = along
            vx += push
            rate += push * rz / inertia
            changed = max(changed, abs(add), abs(push))
        if changed < 1e-15:
            break
    return vx, vz, rate


@compiled()
def _mode_of(y, friction, shape):
    """Mode of motion, sense of sliding and corner of a state in which no corner goes down."""
    _, z, theta, vx, vz, rate = y
    quiet, near = shape[3], 1e-9
    down = np.zeros(2, np.bool_)
    for corner in range(2):
        up = vz - rate * _arm(corner, theta, shape)[0]
        down[corner] = _gap(corner, z, theta, shape) < near and up < quiet
    if down[LEFT] and down[RIGHT]:
        return FLAT, 1.0, LEFT
    if not (down[LEFT] or down[RIGHT]):
        return FLIGHT, 1.0, LEFT
    corner = LEFT if down[LEFT] else RIGHT
    rz = _arm(corner, theta, shape)[1]
    if shape[6] + rate * rate * rz <= 0:  # it turns so fast that it lifts itself
        return FLIGHT, 1.0, corner
    slips = vx + rate * rz
    if abs(slips) < quiet:
        along, push, _ = _forces(STICK, 1.0, corner, theta, rate, friction, shape)
        if abs(along) <= friction * push:
            return STICK, 1.0, corner
        slips = -along  # it begins to slide against the friction that it lacks
    return SLIDE, 1.0 if slips > 0 else -1.0, corner


@compiled()
def _first_step(mode, corner, y, shape, longest):
    """A step after which a corner that has just left the ground is still above it."""
    step = longest
    for each in range(2):
        up = y[4] - y[5] * _arm(each, y[2], shape)[0]
        rises = up >= shape[3] and (mode == FLIGHT or each != corner)
        if rises and _gap(each, y[1], y[2], shape) < 1e-9:
            step = min(step, 0.25 * up / (shape[6] + y[5] * y[5] * (shape[0] + shape[1])))
    return step


@compiled()
def _begin(y, restitution, friction, shape):
    """State, mode, sense and corner after an event, and the corner that came down, -1 for none."""
    down = np.zeros(2, np.bool_)
    struck = -1
    for corner in range(2):
        down[corner] = _gap(corner, y[1], y[2], shape) < 1e-9
        up = y[4] - y[5] * _arm(corner, y[2], shape)[0]
        if down[corner] and up < -shape[3]:
            struck = corner
    if down[LEFT] or down[RIGHT]:
        vx, vz, rate = _strike(y, down, restitution, friction, shape)
        y = (y[0], y[1], y[2], vx, vz, rate)
    mode, sense, corner = _mode_of(y, friction, shape)
    if mode == FLIGHT:
        below = min(_gap(LEFT, y[1], y[2], shape), _gap(RIGHT, y[1], y[2], shape), 0.0)
        y = (y[0], y[1] - below, y[2], y[3], y[4], y[5])
    elif mode == FLAT:
        y = (y[0], shape[1], 0.0, y[3], 0.0, 0.0)
    else:
        theta = 0.0 if _gap(1 - corner, y[1], y[2], shape) < 1e-12 else y[2]
        rx, rz = _arm(corner, theta, shape)
        sticks = mode == STICK or abs(y[3] + y[5] * rz) < shape[3]
        vx = -y[5] * rz if sticks else y[3]
        y = (y[0], -rz, theta, vx, y[5] * rx, y[5])
    return y, mode, sense, corner, struck


@compiled()
def _move(shape, restitution, friction, start, time, longest, out, impacts):
    """Fill the states at some instants and the instants of the impacts; return the number of impacts, and
    which of `ENDS` it is."""
    y, t, n = start, 0.0, 0
    y, mode, sense, corner, struck = _begin(y, restitution, friction, shape)
    first, still = True, 0
    for i in range(time.size):
        while t < time[i]:
            step = _first_step(mode, corner, y, shape, longest) if first else longest
            step = min(step, time[i] - t)
            after = _advanced(mode, sense, corner, y, friction, shape, step)
            if _goes_on(mode, sense, corner, after, friction, shape) >= 0:
                y, t, first, still = after, t + step, False, 0
                if abs(y[2]) > OVER:
                    out[i:] = math.nan
                    return n, 1
                continue
            low, high = 0.0, step
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                after = _advanced(mode, sense, corner, y, friction, shape, middle)
                if _goes_on(mode, sense, corner, after, friction, shape) >= 0:
                    low = middle
                else:
                    high = middle
            y, t = _advanced(mode, sense, corner, y, friction, shape, high), t + high
            y, mode, sense, corner, struck = _begin(y, restitution, friction, shape)
            first, still = True, still + 1
            if struck >= 0:
                if n == len(impacts):
                    out[i:] = math.nan
                    return n, 2
                impacts[n] = t
                n += 1
            if still > 1000:
                out[i:] = math.nan
                return n, 2
        out[i] = y
    return n, 0
