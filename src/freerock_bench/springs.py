"""A block on springs by Newton and Euler, with what real laboratories have besides: a second simulator.

Coordinates are those of the centre of mass (x, y, θ clockwise), of a part of the mass that moves along a
track near the top (q) and of a table (X, Y). Cells of the base press on the bed by two points of Gauss's rule
in the part of each that touches. What holds the base sideways is a multiplier, or friction. SciPy's DOP853
integrates; a rigid block goes from event to event. Of freerock it takes the constants of a block alone.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock.models.compiled import compiled

CELLS, GAUSS = 128, 3**-0.5
DULL_RAD_S = 2e-3  # rate over which dry friction turns round
LEAST_RAD = 1e-5  # a rigid block lies still below
AT_REST = 2e-5  # [rad]
RTOL, ATOL, LONGEST_S = 1e-8, 1e-11, 60.0
USUAL_S, STILL_S = 15.0, 1.0  # after which most blocks have been at rest for so long
TILT_S = 1.2  # of a record, before its hold
AWAY_M = 0.5  # sensor from the face
N = 12  # coordinates and rates, without what friction and bed remember
BASE = {  # what a base may be besides flat
    "left_m": 0.0,  # by how much the left corner is worn
    "right_m": 0.0,
    "radius_m": 0.0,  # of the edges
    "hollow_m": 0.0,  # depth in the middle
}
BESIDES = {  # what may be besides a law; 0 is none
    "thickness_m": 0.0,  # of a mat that hardens: p = k z / (1 - z/H)
    "two_beds": 0.0,  # share by which the right half is stiffer and the left one softer
    "relaxing": 0.0,  # stiffness that relaxes over that which stays: a standard linear solid
    "relaxes_s": 0.01,
    "tensionless": 0.0,  # 1 where the bed can't pull
    "hardens_per_s": 0.0,  # share of k
    "top": 0.0,  # share of the mass that moves near the top
    "top_hz": 50.0,
    "table_kg": 0.0,
    "table_x_hz": 0.0,
    "table_y_hz": 0.0,
    "lost": 0.02,  # damping ratio of top and table
    "grip": 0.0,  # coefficient of friction of a base that may slip; 0 of one that is held
    "air_nms2": 0.0,  # against turning, by the square of the rate
    "rub_nm": 0.0,  # dry friction against turning
    "tilt": 0.0,  # of the base, lower on the right [rad]
}
KEYS = list(BESIDES)
BRISTLE_N_M, BRISTLE_NS_M = 2e7, 2e3  # what friction holds by before it slips


@dataclass(frozen=True)
class Scene:
    """A block and how it is let go.

    Parameters
    ----------
    block : Block
        As it truly is.
    law : dict of str to float
        k, c, lambda of a bed, those it lacks are zero; or r of a rigid base [SI].
    pivoting : bool
    theta0 : float
        Angle of the hold [rad].
    fade_s : float
        Time over which the finger leaves.
    base, besides : dict of str to float
        What differs from `BASE` and `BESIDES`.
    rate : float
        By which the finger pushes, positive away from rest [rad/s].
    blow : (float, float, float)
        A blow so long after the release [s]: share of the rate that is left, and rate added [rad/s].
    """

    block: Block
    law: dict[str, float]
    pivoting: bool
    theta0: float
    fade_s: float = 0.01
    base: dict[str, float] = field(default_factory=dict)
    besides: dict[str, float] = field(default_factory=dict)
    rate: float = 0.0
    blow: tuple[float, float, float] = (math.inf, 1.0, 0.0)

    @cached_property
    def known(self) -> dict[str, float]:
        """`BASE` and `BESIDES` as they are."""
        assert {*self.base} <= {*BASE} and {*self.besides} <= {*BESIDES}
        return BASE | BESIDES | self.base | self.besides

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Left and right corner, from the middle [m]."""
        return -self.block.b + self.known["left_m"], self.block.b - self.known["right_m"]

    @cached_property
    def cells(self) -> Floats:
        """Middles and half lengths [m], heights [m], slopes; shape (CELLS, 4)."""
        left, right = self.ends
        middle, b, radius = (left + right) / 2, (right - left) / 2, self.known["radius_m"]
        at = middle - b * np.cos(np.pi * np.arange(CELLS + 1) / CELLS)
        u, half = (at[1:] + at[:-1]) / 2, np.diff(at) / 2
        v = np.maximum(np.abs(u - middle) - (b - radius), 0.0)
        arc = np.sqrt(np.maximum(radius**2 - v**2, 1e-30))
        hollow = self.known["hollow_m"]
        height = (radius - arc if radius else 0 * u) + hollow * (1 - ((u - middle) / b) ** 2)
        slope = (np.sign(u - middle) * v / arc if radius else 0 * u) - 2 * hollow * (u - middle) / b**2
        return np.column_stack([u, half, height, slope])

    @cached_property
    def numbers(self) -> tuple[Floats, Floats, Floats]:
        """Body, law and besides as compiled functions take them."""
        block, known = self.block, self.known
        m, top, up = block.mass_kg, known["top"] * block.mass_kg, 0.75 * block.height_m
        rest = m - top
        h = (m * block.h - top * up) / rest
        e = m * block.e / rest
        inertia = block.inertia_cm - rest * ((h - block.h) ** 2 + (e - block.e) ** 2)
        inertia -= top * ((up - block.h) ** 2 + block.e**2)
        body = np.array([rest, inertia, e, h, top, up, *self.ends, float(self.pivoting)])
        law = np.array([self.law.get(name, 0.0) for name in ("k", "c", "lambda")])
        return body, law, np.array([known[name] for name in KEYS], float)


class Motion:
    """States of a scene over time since the finger begins to leave, at even steps, and at rest.

    `states` has the shape (12, n): x, y, θ, q, X, Y and their rates, which are zero of a rigid block.
    """

    def __init__(self, scene: Scene, rate_hz: float, longest_s: float = LONGEST_S) -> None:
        self.scene, self.rate_hz = scene, rate_hz
        self.stands = standing(scene)
        self.held = _held(scene)
        for ends_s in dict.fromkeys((min(USUAL_S, longest_s), longest_s)):
            states = self._until(ends_s)
            moves = int(np.flatnonzero(np.abs(states[2] - self.stands[2]) > AT_REST)[-1])
            if moves < (ends_s - STILL_S) * rate_hz:
                break
        self.states = states[:, : moves + 2]

    def _until(self, ends_s: float) -> Floats:
        if "r" in self.scene.law:
            return _rigid(self.scene, self.rate_hz, ends_s)
        return _on_springs(self.scene, self.held, self.rate_hz, ends_s)

    @property
    def theta(self) -> Floats:
        """Rotation [rad]."""
        return np.asarray(self.states[2])

    @property
    def slid_m(self) -> float:
        """How far right of where it was the base of a block that friction holds comes to rest [m]."""
        if not self.scene.known["grip"]:
            return 0.0
        x, _, theta = self.states[:3, -1].tolist()
        return float(x - _state(self.scene, 0.0, theta)[0])

    def record(self, rest: int, hold: int, after: int) -> tuple[Floats, int]:
        """States over so many samples at rest, a tilt, a hold, the run and a rest; where the run begins."""
        stands, held = self.stands[:N, None], self.held[:N, None]
        share = np.clip(np.arange(0, TILT_S, 1 / self.rate_hz) / TILT_S, 0, 1)
        tilt = stands + (held - stands) * (share**3 * (10 - 15 * share + 6 * share**2))
        lies = stands.copy()
        lies[0] += self.slid_m
        still = [np.repeat(each, n, axis=1) for each, n in ((stands, rest), (held, hold), (lies, after))]
        states = np.hstack([still[0], tilt, still[1], self.states, still[2]])
        return states, rest + share.size + hold


def read(states: Floats, scene: Scene, height_m: float, incline: float = 0.0) -> Floats:
    """Way of a beam to the left face [m] from a sensor `AWAY_M` off, by states.

    The block turns about its lower corner, as the sensor's equations have it (docs/equations.md, section 8).

    Parameters
    ----------
    states : ndarray
    scene : Scene
    height_m : float
        Of the beam where it meets the face at rest.
    incline : float
        Of the beam, upwards [rad].
    """
    x, y, theta, q = states[:4]
    block, (left, right) = scene.block, scene.ends
    body = scene.numbers[0]
    sin, cos = np.sin(theta), np.cos(theta)
    low = y + body[2] * sin - body[3] * cos  # of the base's middle
    across = x - body[2] * cos - body[3] * sin
    if not scene.pivoting and not scene.known["grip"]:
        across = across + np.where(theta > 0, right * (1 - cos), left * (1 - cos))
    face = block.width_m / 2
    bent = q * min(height_m / body[5], 1.0)
    # the face's points are middle + (-face + bent, Z) turned; the beam's (-face - AWAY_M + s cos, Y + s sin)
    start = height_m - AWAY_M * math.tan(incline)
    px, py = across + (bent - face) * cos, low - (bent - face) * sin
    ahead, up = math.cos(incline), math.sin(incline)
    s = ((px + face + AWAY_M) * cos - (py - start) * sin) / (ahead * cos - up * sin)
    return np.asarray(s)


def energy(states: Floats, scene: Scene) -> Floats:
    """Kinetic, of the weight and of the springs of a flat and level bed [J], by states, shape (n,)."""
    (m, inertia, e, h), (left, right) = scene.numbers[0][:4], scene.ends
    y, sin, cos = states[1], np.sin(states[2]), np.cos(states[2])
    depths = np.maximum(np.outer((left, right), sin) - (y + e * sin - h * cos), 0.0)
    length = np.minimum(right - left, depths.max(axis=0) / np.maximum(np.abs(sin), 1e-300))
    stored = scene.law["k"] * length * (depths[0] ** 2 + depths[0] * depths[1] + depths[1] ** 2) / 6
    x_rate, y_rate, w = states[6:9]
    return np.asarray(m * ((x_rate**2 + y_rate**2) / 2 + GRAVITY * y) + inertia * w**2 / 2 + stored)


@compiled()
def _bed(t, y, law, cells, besides, pulls):  # type: ignore[no-untyped-def]
    """Upward force [N], its moment about the base's middle by u, and rates of what the bed remembers."""
    thick, two, relaxing, relaxes, loose, hardens = besides[:6]
    k, c, lam = law[0] * (1.0 + hardens * t), law[1], law[2]
    sin, cos = math.sin(y[2]), math.cos(y[2])
    force = moment = 0.0
    e, h = pulls
    low = y[1] + e * sin - h * cos
    low_rate = y[7] + (e * cos + h * sin) * y[8]
    n = cells.shape[0]
    forgets = np.zeros(n if relaxing > 0.0 else 0)
    for i in range(n):
        u, half, height, slope = cells[i]
        depth, deeper = y[5] - low + u * sin - height * cos, half * (sin - slope * cos)
        bent = 0.0
        if relaxing > 0.0:
            rate = y[11] - low_rate + (u * cos + height * sin) * y[8]
            bent = y[N + 1 + i]
            forgets[i] = -bent / relaxes + (relaxing * k * rate if depth > 0.0 else 0.0)
        if depth <= -abs(deeper):
            continue
        first, last = -1.0, 1.0
        if depth < abs(deeper):
            if deeper > 0.0:
                first = -depth / deeper
            else:
                last = -depth / deeper
        for node in (-GAUSS, GAUSS):
            at = 0.5 * (first + last) + 0.5 * (last - first) * node
            place, z = u + half * at, depth + deeper * at
            rate = y[11] - low_rate + (place * cos + height * sin) * y[8]
            stiff = k * (1.0 + two if place > 0.0 else 1.0 - two)
            if thick > 0.0:
                stiff /= 1.0 - min(z / thick, 0.95)
            f = stiff * z + (c + lam * z) * rate + bent
            if loose > 0.0:
                f = max(f, 0.0)
            part = 0.5 * half * (last - first) * f
            force, moment = force + part, moment + part * place
    return force, moment, forgets


@compiled()
def _rates(t, y, body, law, cells, besides, hand, fade):  # type: ignore[no-untyped-def]
    """Of all states; the hand is a couple that fades."""
    m, inertia, e, h, top, up, left, right, pivots = body
    top_hz, table, x_hz, y_hz, lost, grip, air, rub, tilt = besides[7:]
    theta, q, w, vq = y[2], y[3], y[8], y[9]
    sin, cos = math.sin(theta), math.cos(theta)
    force, moment, forgets = _bed(t, y, law, cells, besides, (e, h))
    gx, gy = GRAVITY * math.sin(tilt), -GRAVITY * math.cos(tilt)
    mass, right_side = np.zeros((7, 7)), np.zeros(7)
    mass[0, 0] = mass[1, 1] = m
    mass[2, 2] = inertia
    mass[3, 3] = mass[4, 4] = mass[5, 5] = 1.0
    mass[6, 6] = 1.0
    right_side[0], right_side[1] = m * gx, m * gy + force
    # of a point at (u, v) of the base's frame: by θ it moves (b, -a), with (a, b) from the centre turned
    place = moment / force if force > 0.0 else 0.0
    right_side[2] = -((place - e) * cos - h * sin) * force
    right_side[2] -= air * w * abs(w) + rub * math.tanh(w / DULL_RAD_S)
    if t < fade:
        right_side[2] += hand * 0.5 * (1 + math.cos(math.pi * t / fade))
    if top > 0.0:  # at (q, up) of the base's frame: rows of J are its moves by x, y, θ, q
        a, b = (q - e) * cos + (up - h) * sin, -(q - e) * sin + (up - h) * cos
        jx, jy = (1.0, 0.0, b, cos), (0.0, 1.0, -a, -sin)
        bx, by = -a * w * w - 2 * sin * w * vq, -b * w * w - 2 * cos * w * vq
        mass[3, 3] = 0.0
        for i in range(4):
            right_side[i] += top * (jx[i] * (gx - bx) + jy[i] * (gy - by))
            for j in range(4):
                mass[i, j] += top * (jx[i] * jx[j] + jy[i] * jy[j])
        turn = 2 * math.pi * top_hz
        right_side[3] -= top * (turn * turn * q + 2 * lost * turn * vq)
    if table > 0.0:
        mass[4, 4] = mass[5, 5] = table
        along, across = 2 * math.pi * x_hz, 2 * math.pi * y_hz
        if x_hz > 0.0:
            right_side[4] = -table * (along * along * y[4] + 2 * lost * along * y[10])
        if y_hz > 0.0:
            right_side[5] = -force - table * (across * across * y[5] + 2 * lost * across * y[11])
    corner = (right if theta > 0.0 else left) if pivots > 0.0 else 0.0
    slides = 0.0
    if grip > 0.0:
        b = -(place - e) * sin - h * cos
        v = y[6] + b * w - y[10]
        most = grip * max(force, 0.0)
        hold = BRISTLE_N_M * y[N] + BRISTLE_NS_M * v
        hold = min(max(-hold, -most), most)
        slides = v if (most > 0.0 and abs(BRISTLE_N_M * y[N]) < most) or v * y[N] < 0.0 else 0.0
        right_side[0] += hold
        right_side[2] += hold * b
        if x_hz > 0.0:
            right_side[4] -= hold
    else:
        a, b = (corner - e) * cos - h * sin, -(corner - e) * sin - h * cos
        mass[0, 6], mass[2, 6] = -1.0, -b
        mass[6, 0], mass[6, 2], mass[6, 6] = 1.0, b, 0.0
        right_side[6] = a * w * w
        if table > 0.0 and x_hz > 0.0:
            mass[6, 4], mass[4, 6] = -1.0, 1.0
    speeds = np.linalg.solve(mass, right_side)
    found = np.zeros(y.shape[0])
    found[:6], found[6:N] = y[6:N], speeds[:6]
    found[N] = slides
    if besides[2] > 0.0:
        found[N + 1 :] = forgets
    return found


def _state(scene: Scene, depth: float, theta: float) -> Floats:
    """At rest, the base's middle so deep."""
    body, _, _ = scene.numbers
    _, _, e, h, top, _, left, right, pivots = body
    known, sin, cos = scene.known, math.sin(theta), math.cos(theta)
    y = np.zeros(N + 1 + (CELLS if known["relaxing"] else 0))
    corner = (right if theta > 0 else left) if pivots else 0.0
    y[0] = corner * (1 - cos) + e * cos + h * sin
    y[1], y[2] = -depth - e * sin + h * cos, theta
    if top:
        y[3] = GRAVITY * (sin + known["tilt"] * cos) / (2 * math.pi * known["top_hz"]) ** 2
    if known["table_y_hz"]:
        sunk = (body[0] + top) * GRAVITY / (known["table_kg"] * (2 * math.pi * known["table_y_hz"]) ** 2)
        y[5], y[1] = -sunk, y[1] - sunk
    return y


def _at(scene: Scene, y: Floats, hand: float = 0.0) -> Floats:
    rates = _rates(0.0, y, *scene.numbers[:2], scene.cells, scene.numbers[2], hand, 1.0)
    return np.asarray(rates)


def _held(scene: Scene) -> Floats:
    """State in the hold."""
    if "r" in scene.law:
        return _state(scene, _down(scene, scene.theta0), scene.theta0)
    weight = (scene.block.mass_kg * GRAVITY) * math.cos(scene.known["tilt"])

    def excess(depth: float) -> float:
        y = _state(scene, depth, scene.theta0)
        force = _bed(0.0, y, scene.numbers[1], scene.cells, scene.numbers[2], tuple(scene.numbers[0][2:4]))[0]
        return float(force) - weight

    high = scene.block.b * math.sin(abs(scene.theta0)) + 0.01
    return _state(scene, float(brentq(excess, -high, high, xtol=1e-14)), scene.theta0)


def standing(scene: Scene) -> Floats:
    """State at rest, before and after."""
    if "r" in scene.law:
        return _state(scene, 0.0, 0.0)
    width = scene.ends[1] - scene.ends[0]
    depth = scene.block.mass_kg * GRAVITY / (scene.law["k"] * width)

    def rises(at: Floats) -> list[float]:
        rates = _at(scene, _state(scene, float(at[0]) * depth, float(at[1]) * depth / width))
        return [float(rates[7]), float(rates[8])]

    depth_leans = root(rises, [1.0, 0.0], tol=1e-12).x
    return _state(scene, float(depth_leans[0]) * depth, float(depth_leans[1]) * depth / width)


def _on_springs(scene: Scene, held: Floats, rate_hz: float, longest_s: float) -> Floats:
    """States over time, shape (12, n)."""
    pulled = _at(scene, held, 1.0)[8] - _at(scene, held)[8]
    hand = -float(_at(scene, held)[8] / pulled)
    given = (*scene.numbers[:2], scene.cells, scene.numbers[2], hand, scene.fade_s)
    y, (hit_s, kept, added) = held.copy(), scene.blow
    _turn(scene, y, math.copysign(scene.rate, scene.rate * scene.theta0))
    parts, begins = [], 0.0
    for ends in (min(hit_s, longest_s), longest_s):
        if ends <= begins:
            continue
        at = np.arange(math.ceil(begins * rate_hz - 1e-9), math.ceil(ends * rate_hz - 1e-9)) / rate_hz
        at = np.append(at[at < ends], ends)
        found = solve_ivp(
            _rates, (begins, ends), y, "DOP853", at, rtol=RTOL, atol=ATOL, max_step=5e-3, args=given
        )
        assert found.success, found.message
        parts.append(found.y[:N, :-1])
        y, begins = found.y[:, -1].copy(), ends
        y[6:N] *= kept
        _turn(scene, y, added)
    return np.hstack(parts)


def _turn(scene: Scene, y: Floats, by: float) -> None:
    """Give it a rate of rotation about its lower corner [rad/s], in place."""
    e, h, sin, cos = *scene.numbers[0][2:4], math.sin(y[2]), math.cos(y[2])
    corner = scene.ends[1] if y[2] > 0 else scene.ends[0]
    held = corner if scene.pivoting else 0.0
    y[6] += ((held - e) * sin + h * cos) * by
    y[7] += -((corner - e) * cos - h * sin) * -by
    y[8] += by


def on_corners(scene: Scene, theta: Floats) -> Floats:
    """States of a rigid block that stands on a corner at some angles [rad], shape (12, n)."""
    return np.array([_state(scene, _down(scene, each), each)[:N] for each in theta]).T


def _down(scene: Scene, theta: float) -> float:
    """Depth of the base's middle of a rigid block on its corner."""
    left, right = scene.ends
    return -(right if theta > 0 else -left) * abs(math.sin(theta))


def _rigid(scene: Scene, rate_hz: float, longest_s: float) -> Floats:
    """States over time of a rigid block that turns about its corners, from impact to impact; (12, n)."""
    block, known, (left, right) = scene.block, scene.known, scene.ends
    m, tilt, radius = block.mass_kg, known["tilt"], known["radius_m"]

    def turning(side: float, t: float, w: float, couple: float) -> float:
        """Second rate of the angle away from rest, on its right corner (1) or left one (-1) [rad/s²]."""
        b = right - block.e if side > 0 else block.e - left
        sin, cos = math.sin(t), math.cos(t)
        across, up = b - radius, block.h - radius
        x1, z1 = radius + across * sin + up * cos, across * cos - up * sin
        x2, z2 = z1, -across * sin - up * cos
        moment = -m * GRAVITY * (z1 * math.cos(tilt) - side * x1 * math.sin(tilt))
        moment -= m * (x1 * x2 + z1 * z2) * w * w + known["air_nms2"] * w * abs(w)
        moment -= known["rub_nm"] * math.tanh(w / DULL_RAD_S) - couple
        return moment / (block.inertia_cm + m * (x1 * x1 + z1 * z1))

    def rates(t: float, y: Any) -> list[float]:
        support = 0.5 * (1 + math.cos(math.pi * t / scene.fade_s)) if t < scene.fade_s else 0.0
        return [y[1], turning(side, y[0], y[1], support * hand)]

    def lands(_: float, y: Any) -> float:
        return float(y[0])

    lands.terminal, lands.direction = True, -1  # type: ignore[attr-defined]
    side, held = math.copysign(1.0, scene.theta0), abs(scene.theta0)
    weigh = turning(side, held, 0.0, 0.0)
    hand = -weigh / (turning(side, held, 0.0, 1.0) - weigh)
    time_s = np.arange(0.0, longest_s, 1 / rate_hz)
    theta, begins, y = np.zeros(len(time_s)), 0.0, [held, scene.rate]
    how: dict[str, Any] = {"events": lands, "dense_output": True, "rtol": 1e-11, "atol": 1e-14}
    while begins < time_s[-1]:
        longest = math.inf if begins else 0.02
        swing = solve_ivp(rates, (begins, time_s[-1]), y, "DOP853", max_step=longest, **how)
        first, last = np.searchsorted(time_s, (begins, swing.t[-1])).tolist()
        during = slice(first, last if swing.status else len(time_s))
        if during.start < during.stop:
            theta[during] = side * swing.sol(time_s[during])[0]
        begins, side = float(swing.t[-1]), -side
        y = [1e-300, scene.law["r"] * abs(float(swing.y[1, -1]))]
        if y[1] ** 2 < 2 * abs(turning(side, 0.0, 0.0, 0.0)) * LEAST_RAD:
            break
    return on_corners(scene, theta)
