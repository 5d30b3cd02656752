"""A block on springs by Newton and Euler, with what real laboratories have besides: a second simulator.

Coordinates are those of the centre of mass (x, y, θ clockwise), of a part of the mass that moves along a
track near the top (q) and of a table (X, Y). Cells of the base press on the bed by two points of Gauss's rule
in the part of each that touches. What holds the base sideways is a multiplier, or friction. The classical
Runge-Kutta method integrates, a rigid block by SciPy's DOP853 from event to event. Each impact may have its
own loss, stiffness and damping. Of freerock it takes the constants of a block alone.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock_bench.springs_compiled import (
    AT_REST,
    DULL_RAD_S,
    STEP_S,
    N,
    bed_force,
    march,
    rates_of,
    stored,
    turn,
)

CELLS = 128
LEAST_RAD = 1e-5  # a rigid block lies still below
LONGEST_S = 60.0
TILT_S = 1.2  # of a record, before its hold
AWAY_M = 0.5  # sensor from the face
BASE = {  # what a base may be besides flat
    "left_m": 0.0,  # by how much the left corner is worn
    "right_m": 0.0,
    "radius_m": 0.0,  # of the edges
    "hollow_m": 0.0,  # depth in the middle
}
BESIDES = {  # what may be besides a law; 0 is none
    "two_beds": 0.0,  # share by which the right half is stiffer and the left one softer
    "varies": 0.0,  # share by which the stiffness goes up and down along the base, once
    "varies_from": 0.0,  # phase of that at the left corner [rad]
    "hysteresis": 0.0,  # share of k z that has the sign of the rate
    "relaxing": 0.0,  # stiffness that relaxes over that which stays: a standard linear solid
    "relaxes_s": 0.01,
    "tensionless": 0.0,  # 1 where the bed can't pull
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
UNEVEN = ("radius_m", "hollow_m", "varies", "hysteresis", "relaxing", "tensionless")


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
    impacts : ndarray, shape (n_impact, 3)
        What the rate is multiplied with where the block stands upright, and k and damping from then on, each
        time after a side has lifted off.
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
    impacts: Floats = field(default_factory=lambda: np.ones((0, 3)))

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
        """Middles and half lengths [m], heights [m], slopes, stiffness over k; shape (n_cells, 5)."""
        left, right = self.ends
        middle, b, radius = (left + right) / 2, (right - left) / 2, self.known["radius_m"]
        n = CELLS if any(self.known[name] for name in UNEVEN) else 2
        at = middle - b * np.cos(np.pi * np.arange(n + 1) / n)
        u, half = (at[1:] + at[:-1]) / 2, np.diff(at) / 2
        v = np.maximum(np.abs(u - middle) - (b - radius), 0.0)
        arc = np.sqrt(np.maximum(radius**2 - v**2, 1e-30))
        hollow = self.known["hollow_m"]
        height = (radius - arc if radius else 0 * u) + hollow * (1 - ((u - middle) / b) ** 2)
        slope = (np.sign(u - middle) * v / arc if radius else 0 * u) - 2 * hollow * (u - middle) / b**2
        stiff = 1 + self.known["two_beds"] * np.sign(u)
        stiff += self.known["varies"] * np.sin(np.pi * (u - left) / b + self.known["varies_from"])
        return np.column_stack([u, half, height, slope, stiff])

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
        if "r" in scene.law:
            states, self.passages_s = _rigid(scene, rate_hz, longest_s)
        else:
            states, self.passages_s = _on_springs(scene, self.held, self.stands[2], rate_hz, longest_s)
        moves = int(np.flatnonzero(np.abs(states[2] - self.stands[2]) > AT_REST)[-1])
        self.states = states[:, : moves + 2]

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


def energy(states: Floats, scene: Scene, stiffness: float | Floats = 1.0) -> Floats:
    """Kinetic, of the weight, of the springs of the bed and of the table [J], shape (n,).

    Parameters
    ----------
    states : ndarray, shape (12, n)
    scene : Scene
    stiffness : float or ndarray, shape (n,)
        Of the bed, over k.
    """
    (m, inertia, e, h), known = scene.numbers[0][:4], scene.known
    bed = np.array([stored(y, scene.cells, e, h) for y in states.T.copy()])
    moving = m * (states[6] ** 2 + states[7] ** 2) + inertia * states[8] ** 2
    for i, hz in ((4, known["table_x_hz"]), (5, known["table_y_hz"])):
        if hz:
            moving += known["table_kg"] * ((2 * math.pi * hz * states[i]) ** 2 + states[i + 6] ** 2)
    return np.asarray(moving / 2 + m * GRAVITY * states[1] + scene.law.get("k", 0.0) * stiffness * bed)


def restitution_of(motion: Motion) -> tuple[Floats, Floats]:
    """Instants of the impacts [s] and √(energy after / before) of each, at the tops of the swings between."""
    scene, last = motion.scene, motion.theta.size
    passed = np.ceil(motion.passages_s * motion.rate_hz).astype(int)
    ends = [*passed[passed < last].tolist(), last]
    tops = [i + int(np.argmax(np.abs(motion.theta[i:j]))) for i, j in pairwise(ends) if j > i]
    n, (rate, k, _) = len(tops), np.ones((3, len(tops)))
    rate[: len(scene.impacts)], k[: len(scene.impacts)] = scene.impacts[:n, :2].T
    if "r" in scene.law:
        return motion.passages_s[:n], scene.law["r"] * rate
    places = [math.ceil(scene.fade_s * motion.rate_hz), *tops]
    energies = energy(motion.states[:, places], scene, np.concatenate([[1.0], k]))
    energies -= energy(motion.stands[:N, None], scene)
    return motion.passages_s[:n], np.sqrt(np.maximum(energies[1:], 0) / np.maximum(energies[:-1], 1e-12))


def _state(scene: Scene, depth: float, theta: float) -> Floats:
    """At rest, the base's middle so deep."""
    body, _, _ = scene.numbers
    _, _, e, h, top, _, left, right, pivots = body
    known, sin, cos = scene.known, math.sin(theta), math.cos(theta)
    y = np.zeros(N + 1 + (len(scene.cells) if known["relaxing"] else 0))
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
    rates = rates_of(0.0, y, *scene.numbers[:2], scene.cells, scene.numbers[2], hand, 1.0)
    return np.asarray(rates)


def _held(scene: Scene) -> Floats:
    """State in the hold."""
    if "r" in scene.law:
        return _state(scene, _down(scene, scene.theta0), scene.theta0)
    weight = (scene.block.mass_kg * GRAVITY) * math.cos(scene.known["tilt"])

    def excess(depth: float) -> float:
        y = _state(scene, depth, scene.theta0)
        force = bed_force(y, scene.numbers[1], scene.cells, scene.numbers[2], tuple(scene.numbers[0][2:4]))[0]
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


def _on_springs(
    scene: Scene, held: Floats, rests: float, rate_hz: float, longest_s: float
) -> tuple[Floats, Floats]:
    """States over time, shape (12, n), and instants of impacts [s]."""
    pulled = _at(scene, held, 1.0)[8] - _at(scene, held)[8]
    hand = -float(_at(scene, held)[8] / pulled) if scene.fade_s > STEP_S else 0.0
    given = (*scene.numbers[:2], scene.cells, scene.numbers[2], hand, scene.fade_s)
    y = held.copy()
    turn(scene.numbers[0], y, math.copysign(scene.rate, scene.rate * scene.theta0))
    states, passages = np.zeros((round(longest_s * rate_hz) + 1, N)), np.zeros(1000)
    lifts = scene.block.mass_kg * GRAVITY / (scene.law["k"] * 2 * scene.block.b**2)
    how = np.array([1 / rate_hz, rests, lifts, *scene.blow])
    n, count = march(given, y, how, np.asarray(scene.impacts, float), states, passages)
    return states[:n].T, passages[:count]


def on_corners(scene: Scene, theta: Floats) -> Floats:
    """States of a rigid block that stands on a corner at some angles [rad], shape (12, n)."""
    return np.array([_state(scene, _down(scene, each), each)[:N] for each in theta]).T


def _down(scene: Scene, theta: float) -> float:
    """Depth of the base's middle of a rigid block on its corner."""
    left, right = scene.ends
    return -(right if theta > 0 else -left) * abs(math.sin(theta))


def _rigid(scene: Scene, rate_hz: float, longest_s: float) -> tuple[Floats, Floats]:
    """As of `_on_springs`, of a rigid block that turns about its corners, from impact to impact."""
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
    theta, begins, y, passages = np.zeros(len(time_s)), 0.0, [held, scene.rate], list[float]()
    how: dict[str, Any] = {"events": lands, "dense_output": True, "rtol": 1e-11, "atol": 1e-14}
    while begins < time_s[-1]:
        longest = math.inf if begins else 0.02
        swing = solve_ivp(rates, (begins, time_s[-1]), y, "DOP853", max_step=longest, **how)
        first, last = np.searchsorted(time_s, (begins, swing.t[-1])).tolist()
        during = slice(first, last if swing.status else len(time_s))
        if during.start < during.stop:
            theta[during] = side * swing.sol(time_s[during])[0]
        begins, side = float(swing.t[-1]), -side
        own = scene.impacts[len(passages), 0] if len(passages) < len(scene.impacts) else 1.0
        y = [1e-300, scene.law["r"] * own * abs(float(swing.y[1, -1]))]
        passages.append(begins)
        if y[1] ** 2 < 2 * abs(turning(side, 0.0, 0.0, 0.0)) * LEAST_RAD:
            break
    return on_corners(scene, theta), np.array(passages)
