"""A bed of finite thickness that hardens as rock joints close: k z/(1 - z/H), H = k/κ."""

import math
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest
from scipy.integrate import quad

from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.models.contact import Foundation, State, contact_force, energy, static_depth
from freerock.models.kernel import _accelerations as compiled_accelerations
from freerock.models.kernel import _jacobian, _regime, _signs
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate
from freerock_bench.golden import dop853, ours
from freerock_bench.golden.scenes import scenes

BLOCK = Block(0.28, 0.07, 5.84)
K, LAMBDA = 6.88e6, 1.3e8


def on_a_bed(thickness_m, damping=LAMBDA):
    return {"k": K, "lambda": damping, "kappa": K / thickness_m}


SOFT = {
    name: scene
    for name, scene in scenes("small").items()
    if scene.law == "hunt_crossley" and scene.debonding == "geometric"
}
MATS = {
    f"{name}, {thickness_m * 1e3:g} mm": replace(
        scene, law="hardening", parameters={**scene.parameters, "kappa": scene.parameters["k"] / thickness_m}
    )
    for (name, scene), thickness_m in zip(SOFT.items(), cycle((3e-3, 12e-3)))
}


@pytest.mark.parametrize("name", MATS)
def test_an_independent_integrator_finds_the_same_motion(name):
    """Equations, quadrature and integrator of its own, restarted at every change of regime."""
    scene = MATS[name]
    expected = np.array(dop853.solve(scene, 0.6).theta_rad)
    found = ours.solve(scene, 1e-12, 0.6).theta_rad
    assert np.abs(found[: len(expected)] - expected).max() < 1e-10
    plain = {name: scene.parameters[name] for name in ("k", "lambda")}
    soft = ours.solve(replace(scene, law="hunt_crossley", parameters=plain), 1e-12, 0.6).theta_rad
    assert np.abs(soft - found).max() > 1e-3


@pytest.mark.parametrize("theta", [0.0, 1e-4, 0.05, 0.17])
@pytest.mark.parametrize("depth", [1e-4, 8e-4])
def test_force_and_moment_against_adaptive_quadrature(theta, depth):
    foundation = Foundation.of(on_a_bed(0.02))
    z, v, w = depth, 0.02, -0.3
    s, cos = math.sin(theta), math.cos(theta)

    def f(u):
        at = z + u * s
        return K * at / (1 - at / 0.02) + LAMBDA * at * (v + u * w * cos)

    left = max(-BLOCK.b, -z / s) if s else -BLOCK.b
    force, _ = quad(f, left, BLOCK.b, epsabs=0, epsrel=1e-12)
    moment, _ = quad(lambda u: f(u) * u * cos, left, BLOCK.b, epsabs=1e-11 * force * BLOCK.b)
    found = contact_force(BLOCK, foundation, State(z, v, theta, w))
    assert found == pytest.approx((force, moment), rel=1e-11, abs=1e-9 * force * BLOCK.b)


@pytest.mark.parametrize("theta", [0.0, 1e-3, 0.17])
@pytest.mark.parametrize("thickness_m", [3e-3, 12e-3, 1.0])
def test_the_bed_carries_the_weight_at_its_static_depth(theta, thickness_m):
    foundation = Foundation.of(on_a_bed(thickness_m))
    z = static_depth(BLOCK, foundation, theta)
    assert z + BLOCK.b * math.sin(theta) < thickness_m
    force, _ = contact_force(BLOCK, foundation, State(z, 0.0, theta, 0.0))
    assert force == pytest.approx(BLOCK.mass_kg * GRAVITY, rel=1e-10)


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
def test_without_damping_the_energy_is_kept(kinematics):
    parameters, rules = on_a_bed(4e-3, 0.0), Rules(kinematics=kinematics)
    found = simulate(
        "hardening", BLOCK, parameters, np.linspace(0, 1, 501), theta0=0.15, rules=rules, solver=Solver(1e-11)
    )
    motion = found.z_cb, found.z_cb_rate, found.theta, found.theta_rate
    kept = energy(BLOCK, Foundation.of(parameters), *motion, rules)
    assert np.abs(kept / kept[0] - 1).max() < 1e-7
    soft = energy(BLOCK, Foundation(K), *motion, rules)
    assert np.abs(soft / soft[0] - 1).max() > 1e-3


def test_the_tensionless_rule_is_refused():
    rules, time = Rules("tensionless"), np.linspace(0, 1, 11)
    with pytest.raises(FreerockError, match=r"debonding: .*lambda and kappa"):
        simulate("hardening", BLOCK, on_a_bed(0.01), time, theta0=0.1, rules=rules)


@pytest.mark.parametrize("theta", [0.1, -0.1, 1e-3])
def test_the_jacobian_is_that_of_the_accelerations(theta):
    law = Foundation.of(on_a_bed(4e-3)).constants(BLOCK, True)
    if theta < 0:
        law = (*law[:7], -law[7], *law[8:])
    y = (static_depth(BLOCK, Foundation.of(on_a_bed(4e-3)), theta), 0.01, theta, -0.2)
    regime = _regime(_signs(False, y, law), False)
    found = np.reshape(_jacobian(regime, y, 0.0, GRAVITY, law), (2, 4))
    for i, step in enumerate((1e-8, 1e-5, 1e-7, 1e-5)):
        ends = [
            np.array(compiled_accelerations(regime, *(y + sign * step * np.eye(4)[i]), 0.0, GRAVITY, law))
            for sign in (1, -1)
        ]
        slope = (ends[0] - ends[1]) / (2 * step)
        assert found[:, i] == pytest.approx(slope, rel=1e-5, abs=1e-4 * np.abs(found).max())
