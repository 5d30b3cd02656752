"""Records without noise whose truth is known, by equations and an integrator that the laws do not share.

A block on a bed of Winkler's or Hunt and Crossley's law, guided or pivoting, or on a rigid base, its corners
worn or not, the base off level or not, is let go by a finger that fades: docs/equations.md, sections 3 and 8.
A beam reads its left face, by geometry of its own.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock.models.laws import LAWS, Candidate
from freerock.models.published import TABLE_2
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.integrated_kernel import bed, rates, rocks, turns
from freerock_bench.springs import rigid_swings
from freerock_bench.virtual_run import SEED

RATE_HZ = 2000.0
V_PER_M, ZERO_V = 100.0, 5.0
TILT_S, REST_S, LONGEST_S = 1.2, 2.0, 12.0
AT_REST = 2e-5  # [rad]
LARGEST_LEAN = 0.01  # of a block at rest [rad]
STEP_S = 5e-5  # at most, of the integration
KINDS = ("guided", "pivoting", "worn", "rigid")
BLOCKS, FOUNDATIONS = tuple(CONFIGURATIONS), tuple(TABLE_2)


@dataclass(frozen=True)
class Scene:
    """A block as it moves, half the width b of its contact [m] and law; r of a rigid base, else NaN."""

    block: Block
    b: float
    law: tuple[float, float, float]  # k, c, λ
    pivoting: bool
    theta0: float
    fade_s: float
    held_s: float
    r: float = math.nan
    tilt: float = 0.0  # of the base, lower on the right [rad]

    @property
    def parameters(self) -> dict[str, float]:
        """What a fit may find: of the law, and the distance of the corners [SI]."""
        found = dict(zip(("k", "c", "lambda"), self.law, strict=True))
        return {**found, "r": self.r, "width": 2 * self.b}

    @property
    def body(self) -> "Body":
        """What `rates` takes of the block."""
        m = self.block.mass_kg
        return m, m * (self.block.width_m**2 + self.block.height_m**2) / 12, self.block.height_m / 2


Body = tuple[float, float, float]  # mass, moment of inertia, half the height
Law = tuple[float, float, float, float]  # half the width of the contact, k, c, λ


@dataclass(frozen=True, eq=False)
class Truth:
    """A record without noise and what is true of it.

    Parameters
    ----------
    scene : Scene
    laser : Laser
        As it truly is.
    volts, theta, moving : ndarray, shape (n_time,)
        Reading [V], rotation [rad], and 1 where the block moves freely or as the finger leaves.
    let_go_s : float
        When the finger begins to leave, since the start.
    path : ndarray, shape (4, n)
        Depth, rotation and their rates since then, at every `step_s` until the motion ends.
    step_s : float
    """

    scene: Scene
    laser: Laser
    volts: Floats
    theta: Floats
    moving: Floats
    let_go_s: float
    path: Floats
    step_s: float

    @property
    def release_s(self) -> float:
        """Half of the finger is gone."""
        return self.let_go_s + self.scene.fade_s / 2

    @property
    def theta0(self) -> float:
        """The held angle."""
        return float(self.peaks[0])

    @property
    def impacts_s(self) -> Floats:
        """Instants at which the block stands upright [s], each with a top after it."""
        return np.asarray(self.let_go_s + self.step_s * self._passes[: len(self._tops)])

    @cached_property
    def peaks(self) -> Floats:
        """Angle of the hold and of the tops after it, as the beam shows them by the geometry of a corner that
        does not sink [rad]."""
        z, theta, _, _ = self.path[:, [0, *self._tops]]
        return _seen(theta, z, self.scene, self.laser)

    @property
    def block_peaks(self) -> Floats:
        """The same angles, of the block itself [rad]."""
        return np.asarray(self.path[1, [0, *self._tops]])

    @cached_property
    def energies(self) -> Floats:
        """Of the block above rest when the finger has left it, and at its tops [J]."""
        rests = np.array([_depth(0.0, self.scene), 0.0, 0.0, 0.0])
        free = math.ceil(self.scene.fade_s / self.step_s)
        found = [_energy(self.path[:, i], self.scene) for i in [free, *self._tops]]
        return np.array(found) - _energy(rests, self.scene)

    @cached_property
    def _passes(self) -> Any:
        theta = self.path[1]
        return np.flatnonzero(theta[1:] * theta[:-1] < 0)

    @cached_property
    def _tops(self) -> list[int]:
        theta = self.path[1]
        return [int(i + np.argmax(np.abs(theta[i:j]))) for i, j in pairwise(self._passes + 1)]


def names_of(i: int) -> tuple[str, str, str]:
    """Block, foundation and kind of the i-th scene: each in turn, twenty-four make a round."""
    return BLOCKS[i % 3], FOUNDATIONS[i // 3 % 2], KINDS[i // 6 % len(KINDS)]


def law_of(i: int) -> str:
    """The law of the i-th scene."""
    kind = names_of(i)[2]
    if kind == "rigid":
        return "housner"
    return "winkler" if kind == "pivoting" and i // 24 % 2 else "hunt_crossley"


def candidate_of(i: int) -> str:
    """The candidate that holds the truth of the i-th scene."""
    kind = names_of(i)[2]
    kinematics = "pivoting" if kind == "pivoting" else LAWS[law_of(i)].kinematics[0]
    return Candidate(law_of(i), kinematics, kind == "worn").name


def laser_of(i: int) -> Laser:
    """The laser of the i-th scene."""
    return CONFIGURATIONS[names_of(i)[0]][2]


def scene_of(i: int) -> Scene:
    """The i-th scene."""
    draw = np.random.default_rng([SEED, 35, i])
    name, foundation, kind = names_of(i)
    block, angle, _ = CONFIGURATIONS[name]
    soil = {key: value * draw.uniform(0.9, 1.1) for key, value in TABLE_2[foundation][law_of(i)].items()}
    if kind == "rigid":
        soil = {"r": TABLE_2[foundation]["housner"]["r"] ** draw.uniform(1.0, 1.5)}
    worn = draw.uniform(0.92, 0.98) if kind == "worn" else 1.0
    return Scene(
        block,
        block.width_m / 2 * worn,
        (soil.get("k", 0.0), soil.get("c", 0.0), soil.get("lambda", 0.0)),
        kind == "pivoting",
        angle * draw.uniform(0.6, 1.0) * draw.choice([-1, 1]),
        draw.uniform(3e-3, 12e-3),
        round(draw.uniform(1.5, 2.5), 3),  # whole samples
        soil.get("r", math.nan),
    )


@lru_cache(64)
def truth_of(i: int) -> Truth:
    """The record of the i-th scene without noise."""
    return recorded(scene_of(i), laser_of(i), RATE_HZ)


def recorded(scene: Scene, laser: Laser, rate_hz: float) -> Truth:
    """The record of a scene without noise."""
    every = math.ceil(1 / (rate_hz * STEP_S))
    step_s = 1 / (rate_hz * every)
    path = (_rigid_path if math.isfinite(scene.r) else _path)(scene, step_s)
    depth, stands = _standing(scene)
    last = int(np.flatnonzero(np.abs(path[1, ::every] - stands) > AT_REST)[-1])
    path = path[:, : every * last + 1]
    states = path[:, ::every]
    at = REST_S + TILT_S + scene.held_s
    before = np.arange(0.0, at - 0.5 / rate_hz, 1 / rate_hz)
    share = np.clip((before - REST_S) / TILT_S, 0, 1)
    tilted = stands + (scene.theta0 - stands) * share**3 * (10 - 15 * share + 6 * share**2)
    grid = np.linspace(0, max(abs(scene.theta0), abs(stands)), 200)
    depths = np.interp(np.abs(tilted), grid, [_depth(float(each), scene) for each in grid])
    rests = np.zeros(int(scene.held_s * rate_hz))
    theta = np.concatenate([tilted, states[1], rests + stands])
    z = np.concatenate([depths, states[0], rests + depth])
    return Truth(
        scene,
        laser,
        ZERO_V + V_PER_M * _displacement(theta, z, scene, laser),
        theta,
        np.concatenate([0 * tilted, 1 + 0 * states[1], rests]),
        at,
        path,
        step_s,
    )


def _depth(theta: float, scene: Scene) -> float:
    """Of the base's centre of a block that stands or is held at an angle [m]."""
    from scipy.optimize import brentq

    if math.isfinite(scene.r):
        return -scene.b * abs(math.sin(theta))

    def excess(z: float) -> float:
        return float(bed(z, theta, 0.0, 0.0, scene.b, *scene.law)[0]) - weight

    weight = scene.body[0] * GRAVITY * math.cos(scene.tilt)
    return float(brentq(excess, -scene.b, scene.b, xtol=1e-14))


def _standing(scene: Scene) -> tuple[float, float]:
    """Depth [m] and rotation [rad] at rest: on a bed, a block on a base off level leans."""
    from scipy.optimize import brentq

    if math.isfinite(scene.r) or not scene.tilt:
        return _depth(0.0, scene), 0.0
    given = (*scene.body, scene.b, *scene.law, scene.pivoting, scene.tilt)

    def turn(theta: float) -> float:
        return float(rates(np.array([_depth(theta, scene), theta, 0.0, 0.0]), 0.0, *given)[3])

    leans = float(brentq(turn, -LARGEST_LEAN, LARGEST_LEAN, xtol=1e-14))
    return _depth(leans, scene), leans


def _path(scene: Scene, step_s: float) -> Floats:
    """Depth, rotation and their rates since the finger begins to leave."""
    given = (*scene.body, scene.b, *scene.law, scene.pivoting, scene.tilt)
    held = np.array([_depth(scene.theta0, scene), scene.theta0, 0.0, 0.0])
    inertia = scene.body[1] + scene.body[0] * _lever(scene.theta0, scene) ** 2
    hand = -rates(held, 0.0, *given)[3] * inertia
    return np.asarray(rocks(held, int(LONGEST_S / step_s), step_s, scene.fade_s, hand, *given)).T


def _rigid_path(scene: Scene, step_s: float) -> Floats:
    """The same of a rigid block on a rigid base, from impact to impact."""
    given = (*scene.body, scene.b, scene.tilt)
    hand = -turns(scene.theta0, math.copysign(1.0, scene.theta0), *given)

    def turning(side: float, angle: float, rate: float, support: float) -> float:
        return float(side * (turns(side * angle, side, *given) + support * hand))

    time_s = np.arange(0.0, LONGEST_S, step_s)
    theta, rate = rigid_swings(turning, scene.r, (scene.theta0, 0.0), scene.fade_s, time_s)
    down = -scene.b * np.sin(np.abs(theta)), -scene.b * np.cos(theta) * np.sign(theta) * rate
    return np.stack([down[0], theta, down[1], rate])


def _lever(theta: float, scene: Scene) -> float:
    """By which the centre of mass moves sideways as the block turns [m]."""
    return scene.body[2] * math.cos(theta) + (scene.b * abs(math.sin(theta)) if scene.pivoting else 0.0)


def _energy(y: Floats, scene: Scene) -> float:
    """Kinetic, of weight and of the bed [J]."""
    z, theta, z_rate, w = y
    m, inertia, h = scene.body
    kinetic = (
        m * ((_lever(theta, scene) * w) ** 2 + (z_rate + h * math.sin(theta) * w) ** 2) / 2
        + inertia * w**2 / 2
    )
    stored = float(bed(z, theta, 0.0, 0.0, scene.b, *scene.law)[2])
    return float(kinetic + stored + m * GRAVITY * (h * math.cos(theta) - z))


def _displacement(theta: Floats, z: Floats, scene: Scene, laser: Laser) -> Floats:
    """Of the left face at the beam's height: the block has turned about its lower corner, which has sunk."""
    face, corner = scene.block.width_m / 2, np.sign(theta) * scene.b
    depth = z + scene.b * np.abs(np.sin(theta))
    along = (laser.position + depth - (face + corner) * np.sin(theta)) / np.cos(theta)
    return np.asarray(corner - (face + corner) * np.cos(theta) + along * np.sin(theta) + face)


def _seen(theta: Floats, z: Floats, scene: Scene, laser: Laser) -> Floats:
    """Rotation by the geometry of the nominal block, whose corner does not sink."""
    from scipy.optimize import brentq

    nominal = replace(scene, b=scene.block.width_m / 2)
    read = _displacement(theta, z, scene, laser)

    def turned(s: float) -> float:
        def off(angle: float) -> float:
            t = np.array([angle])
            return float(_displacement(t, -nominal.b * np.abs(np.sin(t)), nominal, laser)[0]) - s

        return float(brentq(off, -0.7, 0.7, xtol=1e-13))

    return np.array([turned(float(s)) for s in read])
