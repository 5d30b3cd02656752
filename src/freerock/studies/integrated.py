"""Records without noise whose truth is known, by equations and an integrator that the laws do not share.

A block on a bed of Winkler's or Hunt and Crossley's law, guided or pivoting, its corners worn or not, is let
go by a finger that fades: docs/physics.md, sections 3 and 8, integrated by SciPy. A beam reads its left face,
by geometry of its own.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock.models.published import TABLE_2
from freerock.rotation.sensor import Laser
from freerock.studies.integrated_kernel import bed, rates
from freerock.studies.virtual_run import SEED
from freerock.virtual_lab.palermo import CONFIGURATIONS

RATE_HZ = 2000.0
V_PER_M, ZERO_V = 100.0, 5.0
TILT_S, REST_S, LONGEST_S = 1.2, 2.0, 12.0
AT_REST = 2e-5  # [rad]
KINDS = ("guided", "pivoting", "worn")
BLOCKS, FOUNDATIONS = tuple(CONFIGURATIONS), tuple(TABLE_2)


@dataclass(frozen=True)
class Scene:
    """A block as it moves, its half width b [m] and law."""

    block: Block
    b: float
    law: tuple[float, float, float]  # k, c, λ
    pivoting: bool
    theta0: float
    fade_s: float
    held_s: float


@dataclass(frozen=True)
class Truth:
    """A record without noise and what is true of it.

    Peaks, of which the first is held, are those that the beam shows by the geometry of a corner that does not
    sink [rad]. Energies above rest are those of the block when the finger has left it, and at its tops [J].
    """

    scene: Scene
    volts: Floats
    theta: Floats
    moving: Floats
    release_s: float
    impacts_s: Floats
    peaks: Floats
    energies: Floats

    @property
    def theta0(self) -> float:
        """The held angle."""
        return float(self.peaks[0])


def names_of(i: int) -> tuple[str, str, str]:
    """Block, foundation and kind of the i-th scene: each in turn, eighteen make a round."""
    return BLOCKS[i % 3], FOUNDATIONS[i // 3 % 2], KINDS[i // 6 % 3]


def laser_of(i: int) -> Laser:
    """The laser of the i-th scene."""
    return CONFIGURATIONS[names_of(i)[0]][2]


def scene_of(i: int) -> Scene:
    """The i-th scene."""
    draw = np.random.default_rng([SEED, 35, i])
    name, foundation, kind = names_of(i)
    block, angle, _ = CONFIGURATIONS[name]
    table = TABLE_2[foundation]["winkler" if kind == "pivoting" and i // 18 % 2 else "hunt_crossley"]
    soil = {key: value * draw.uniform(0.9, 1.1) for key, value in table.items()}
    worn = draw.uniform(0.92, 0.98) if kind == "worn" else 1.0
    return Scene(
        block,
        block.width_m / 2 * worn,
        (soil["k"], soil.get("c", 0.0), soil.get("lambda", 0.0)),
        kind == "pivoting",
        angle * draw.uniform(0.6, 1.0) * draw.choice([-1, 1]),
        draw.uniform(3e-3, 12e-3),
        round(draw.uniform(1.5, 2.5), 3),  # whole samples
    )


Body = tuple[float, float, float]  # mass, moment of inertia, half the height
Law = tuple[float, float, float, float]  # half the width of the contact, k, c, λ


@lru_cache(64)
def truth_of(i: int) -> Truth:
    """The record of the i-th scene without noise."""
    scene, laser = scene_of(i), laser_of(i)
    block, m = scene.block, scene.block.mass_kg
    body = m, m * (block.width_m**2 + block.height_m**2) / 12, block.height_m / 2
    law = (scene.b, *scene.law)
    clock = np.arange(0.0, LONGEST_S, 1 / RATE_HZ)
    fades, goes = _motion(scene, body, law)
    states = np.where(clock < scene.fade_s, fades(clock), goes(clock))
    last = int(np.flatnonzero(np.abs(states[1]) > AT_REST)[-1])
    states = states[:, : last + 1]
    at = REST_S + TILT_S + scene.held_s
    before = np.arange(0.0, at - 0.5 / RATE_HZ, 1 / RATE_HZ)
    share = np.clip((before - REST_S) / TILT_S, 0, 1)
    tilted = scene.theta0 * share**3 * (10 - 15 * share + 6 * share**2)
    grid = np.linspace(0, abs(scene.theta0), 200)
    depths = np.interp(np.abs(tilted), grid, [_depth(float(each), body, law) for each in grid])
    rests = np.zeros(int(scene.held_s * RATE_HZ))
    theta = np.concatenate([tilted, states[1], rests])
    z = np.concatenate([depths, states[0], rests + depths[0]])
    fine = np.arange(scene.fade_s, clock[last], 1e-4)
    path = goes(fine)
    passes = np.flatnonzero(path[1, 1:] * path[1, :-1] < 0)
    tops = [int(i + np.argmax(np.abs(path[1, i:j]))) for i, j in pairwise(passes + 1)]
    peaks = np.append(scene.theta0, path[1, tops]), np.append(fades(0.0)[0], path[0, tops])
    energies = np.array([_energy(path[:, i], scene, body, law) for i in [0, *tops]])
    return Truth(
        scene,
        ZERO_V + V_PER_M * _displacement(theta, z, scene, laser),
        theta,
        np.concatenate([0 * tilted, 1 + 0 * states[1], rests]),
        at + scene.fade_s / 2,
        at + fine[passes[: len(tops)]],
        _seen(*peaks, scene, laser),
        energies - _energy(np.array([depths[0], 0.0, 0.0, 0.0]), scene, body, law),
    )


def _depth(theta: float, body: Body, law: Law) -> float:
    """Of the base's centre of a block that stands or is held at an angle [m]."""
    from scipy.optimize import brentq

    def excess(z: float) -> float:
        return float(bed(z, theta, 0.0, 0.0, *law)[0]) - body[0] * GRAVITY

    return float(brentq(excess, -law[0], law[0], xtol=1e-14))


def _motion(scene: Scene, body: Body, law: Law) -> tuple[Callable[[Any], Floats], Callable[[Any], Floats]]:
    """Depth, rotation and their rates over time [s], while the finger fades and after."""
    from scipy.integrate import solve_ivp

    held = np.array([_depth(scene.theta0, body, law), scene.theta0, 0.0, 0.0])
    inertia = body[1] + body[0] * _lever(scene.theta0, scene, body) ** 2
    hand = -rates(held, 0.0, *body, *law, scene.pivoting)[3] * inertia

    def moves(t: float, y: Floats) -> Any:
        support = 0.5 * (1 + math.cos(math.pi * min(t / scene.fade_s, 1.0)))
        return rates(y, support * hand, *body, *law, scene.pivoting)

    options = {"method": "LSODA", "rtol": 1e-10, "atol": 1e-13, "dense_output": True}
    fades = solve_ivp(moves, (0.0, scene.fade_s), held, max_step=1e-3, **options)
    goes = solve_ivp(moves, (scene.fade_s, LONGEST_S), fades.y[:, -1], max_step=5e-3, **options)
    return fades.sol, goes.sol


def _lever(theta: float, scene: Scene, body: Body) -> float:
    """By which the centre of mass moves sideways as the block turns [m]."""
    return body[2] * math.cos(theta) + (scene.b * abs(math.sin(theta)) if scene.pivoting else 0.0)


def _energy(y: Floats, scene: Scene, body: Body, law: Law) -> float:
    """Kinetic, of weight and of the bed [J]."""
    z, theta, z_rate, w = y
    m, inertia, h = body
    kinetic = (
        m * ((_lever(theta, scene, body) * w) ** 2 + (z_rate + h * math.sin(theta) * w) ** 2) / 2
        + inertia * w**2 / 2
    )
    stored = float(bed(z, theta, 0.0, 0.0, *law)[2])
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
