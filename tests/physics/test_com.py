"""A block whose centre of mass, and moment of inertia, are not those of a uniform rectangle."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import lean
from freerock.models.laws import Foundation, Rules
from freerock.models.simulate import Solver, simulate, simulate_fitted
from freerock.runs.impacts import find_impacts
from freerock_bench.golden import dop853, ours
from freerock_bench.golden.scenes import scenes

BLOCK = Block(0.28, 0.07, 5.84)
ODD = replace(BLOCK, com_height_m=0.147, com_offset_m=0.003, inertia_kg_m2=1.1 * BLOCK.inertia_cm)
SCENES = {
    name: replace(scene, block=ODD)
    for name, scene in scenes("small").items()
    if scene.debonding == "geometric" or (scene.law == "hunt_crossley" and name.endswith("free"))
}
LAWS = {
    "housner": {"r": 0.93},
    "winkler": {"k": 6.77e6, "c": 2.17e4},
    "hunt_crossley": {"k": 6.88e6, "lambda": 1.3e8},
    "general": {"k": 6.8e6, "c": 1e4, "lambda": 6e7},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_an_independent_integrator_finds_the_same_motion(name):
    """Equations and integrator of its own, restarted at every change of regime."""
    scene = SCENES[name]
    expected = np.array(dop853.solve(scene, 0.6).theta_rad)
    found = ours.solve(scene, 1e-12, 0.6).theta_rad
    assert np.abs(found[: len(expected)] - expected).max() < 1e-12
    uniform = ours.solve(replace(scene, block=BLOCK), 1e-12, 0.6).theta_rad
    assert np.abs(uniform - found).max() > 1e-4


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("law", LAWS)
def test_an_offset_does_what_a_tilt_does(law, kinematics):
    """Weight acts through the same point of the base: of a slender block the two differ by little."""
    tau, time, rules = 1e-3, np.linspace(0, 1.5, 301), Rules(kinematics=kinematics)
    level = simulate_fitted(law, BLOCK, {**LAWS[law], "theta0": 0.17}, time, rules=rules)
    tilted = simulate_fitted(law, BLOCK, {**LAWS[law], "tilt": tau, "theta0": 0.17}, time, rules=rules)
    off = replace(BLOCK, com_offset_m=BLOCK.h * tau)
    offset = simulate_fitted(law, off, {**LAWS[law], "theta0": 0.17}, time, rules=rules)
    assert np.linalg.norm(offset - tilted) < 0.2 * np.linalg.norm(tilted - level)


def test_an_offset_block_stands_where_it_leans():
    """Held there, it stays: its weight is carried by the springs of the whole base."""
    law, time = LAWS["winkler"], np.linspace(0, 1, 101)
    stands = lean(ODD, Foundation.of(law), 0.0)
    expected = 3 * ODD.mass_kg * GRAVITY * 0.003 / (2 * ODD.b**3 * law["k"])
    assert stands == pytest.approx(expected, rel=0.05)
    theta = simulate("winkler", ODD, law, time, theta0=stands).theta
    assert np.abs(theta - stands).max() < 1e-5 * stands
    let_go = simulate_fitted("winkler", ODD, {**law, "theta0": 0.1}, np.linspace(0, 8, 801))
    assert np.abs(let_go[-50:]).max() < 1e-2 * stands


def test_constants_are_those_of_the_nearer_corner():
    near = ODD.b - 0.003
    assert ODD.theta_cr == pytest.approx(math.atan(near / 0.147))
    about = ODD.inertia_cm + ODD.mass_kg * math.hypot(near, 0.147) ** 2
    assert ODD.p == pytest.approx(math.sqrt(ODD.mass_kg * GRAVITY * math.hypot(near, 0.147) / about))
    # the angular momentum about the corner that comes down is kept
    far = ODD.b + 0.003
    about = ODD.inertia_cm + ODD.mass_kg * math.hypot(far, 0.147) ** 2
    kept = ODD.inertia_cm + ODD.mass_kg * (0.147**2 - near * far)
    assert ODD.restitution_housner == pytest.approx(kept / about)


@pytest.mark.parametrize("side", [1, -1])
def test_restitution_from_peaks_is_that_of_each_impact(side):
    """Energy and moment of inertia are those of the corner on each side; else r alternates by percents."""
    time = np.linspace(0, 2, 4001)
    theta = simulate("housner", ODD, {"r": 0.93}, time, theta0=side * 0.12, solver=Solver(1e-10)).theta
    found = find_impacts(time, theta, 1e-6, ODD, theta0=side * 0.12)
    assert found.restitution.size > 4
    assert found.restitution[:4] == pytest.approx([0.93] * 4, abs=5e-4)
    uniform = replace(ODD, com_offset_m=None)
    assert np.ptp(find_impacts(time, theta, 1e-6, uniform, theta0=side * 0.12).restitution[:4]) > 0.05
