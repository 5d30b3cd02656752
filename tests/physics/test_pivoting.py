"""A block that turns about the corner that is down: an independent integration, Housner's limit, energy."""

import math
from itertools import pairwise

import numpy as np
import pytest
from beds import beds, starts
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from freerock.identification.epsilon_theta import epsilon_theta
from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State, energy, static_depth
from freerock.models.ground import accelerogram, pulse
from freerock.models.housner import housner_swings
from freerock.models.laws import Foundation, Rules
from freerock.models.simulate import Solver, simulate

BLOCKS = {1: Block(0.42, 0.07, 8.67), 2: Block(0.28, 0.07, 5.84), 3: Block(0.14, 0.07, 2.98)}
RELEASE = {1: math.radians(6), 2: math.radians(10), 3: math.radians(20)}
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}
PIVOTING = Rules(kinematics="pivoting")
GAUSS = [(-math.sqrt(0.6), 5 / 9), (0.0, 8 / 9), (math.sqrt(0.6), 5 / 9)]  # exact for f and f u


def part_above(value, slope, low, high):
    """Part of [low, high] where value + slope u > 0."""
    if slope == 0:
        return (low, high) if value > 0 else (low, low)
    root = min(max(-value / slope, low), high)
    return (root, high) if slope > 0 else (low, root)


def followed(block, parameters, start, time, rule="geometric", motion=None):
    """θ(t) by SciPy, from the two equations of the Lagrangian in docs/equations.md, section 4."""
    k, c, lam = parameters["k"], parameters.get("c", 0.0), parameters.get("lambda", 0.0)
    m, b, h = block.mass_kg, block.b, block.h
    edges = [0.0, time[-1]]
    if motion is not None:
        inside = (motion.breaks > 0) & (motion.breaks < time[-1])
        edges = np.unique([*edges, *motion.breaks[inside]]).tolist()

    def rates(t, y, first, last):
        z, v, theta, w = y
        s, cos = math.sin(theta), math.cos(theta)
        # the ground of this segment, from its inner side at both ends
        x, up = (0.0, 0.0) if motion is None else motion(min(max(t, first), last))
        low, high = part_above(z, s, -b, b)
        if rule == "tensionless":
            factor = (k + lam * v, lam * w * cos) if lam else (k * z + c * v, k * s + c * w * cos)
            low, high = part_above(*factor, low, high)
        force = moment = 0.0
        for node, weight in GAUSS:
            u = 0.5 * (low + high) + 0.5 * (high - low) * node
            depth, rate = z + u * s, v + u * w * cos
            f = 0.5 * (high - low) * weight * (k * depth + (c + lam * depth) * rate)
            force, moment = force + f, moment + f * u * cos
        side = math.copysign(b, theta)
        lever, lever_slope = h * cos + side * s, side * cos - h * s
        # m z̈ + m h s θ̈ = down,  m h s z̈ + (I + m lever² + m h² s²) θ̈ = turn
        down = m * (GRAVITY + up) - force - m * h * cos * w * w
        turn = m * h * s * (GRAVITY + up) - moment + m * lever * x
        turn -= m * w * w * (lever * lever_slope + h * h * s * cos)
        inertia = block.inertia_cm + m * lever**2
        theta_acceleration = (turn - h * s * down) / inertia
        return v, down / m - h * s * theta_acceleration, w, theta_acceleration

    theta, y = np.empty(time.size), list(start)
    for first, last in pairwise(edges):
        inner = (first + 1e-12, last - 1e-12)
        limits = {"rtol": 1e-10, "atol": [1e-13, 1e-11, 1e-12, 1e-10], "dense_output": True}
        solution = solve_ivp(rates, (first, last), y, "DOP853", args=inner, **limits)
        here = (time >= first) & (time <= last)
        theta[here], y = solution.sol(time[here])[2], solution.y[:, -1]
    return theta


SHAKEN = accelerogram(
    np.arange(41) * 0.025,
    x=np.random.default_rng(3).standard_normal(41),
    z=2 * np.random.default_rng(4).standard_normal(41),
)
SINE = pulse("sine", 0.4, x=3.0, z=2.0)
SCENES = {
    "1, marble": (1, "hunt_crossley", MARBLE, "geometric", 1.0, None),
    "1, upright, moving ground": (1, "winkler", {"k": 4.5e6, "c": 4.05e4}, "geometric", 0.0, SHAKEN),
    "2, stiff": (2, "hunt_crossley", {"k": 1e9, "lambda": 2e10}, "geometric", 1.0, None),
    "2, tensionless Winkler": (2, "winkler", {"k": 6.77e6, "c": 2.17e4}, "tensionless", 1.0, None),
    "3, soft": (3, "winkler", {"k": 1e6, "c": 3e3}, "geometric", 0.7, None),
    "3, tensionless, moving ground": (3, "hunt_crossley", MARBLE, "tensionless", 0.2, SINE),
}


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_motion_is_that_of_an_independent_integration(scene):
    number, model, parameters, rule, share, motion = scene
    block, theta0, time = BLOCKS[number], share * RELEASE[number], np.linspace(0, 1, 201)
    found = simulate(
        model, block, parameters, time, theta0=theta0, rules=Rules(rule, "pivoting"), base_excitation=motion
    )
    assert found.outcome == "completed" and len(found.impacts) >= 2
    start = (static_depth(block, Foundation.of(parameters), theta0), 0.0, theta0, 0.0)
    expected = followed(block, parameters, start, time, rule, motion)
    assert epsilon_theta(time, found.theta, expected) <= 1e-12
    guided = simulate(
        model, block, parameters, time, theta0=theta0, rules=Rules(rule), base_excitation=motion
    )
    assert epsilon_theta(time, guided.theta, expected) > 1e-6


def first_impact(number, k):
    law = {"k": k, "lambda": 20 * k}
    time = np.array([0.0, 0.35])
    return simulate(
        "hunt_crossley", BLOCKS[number], law, time, theta0=RELEASE[number], rules=PIVOTING
    ).impacts[0]


@pytest.mark.parametrize("number, quarter_s", [(1, 0.284390), (2, 0.269800), (3, 0.215028)])
def test_stiff_limit_is_housners_block(number, quarter_s):
    """The quarter period at k = 1e10 of an independent program; what it has above Housner's falls as 1/√k."""
    block, theta0 = BLOCKS[number], RELEASE[number]
    housner = housner_swings(block, 1.0, theta0, until=0.1).impact_time[0]
    late = {k: first_impact(number, k) - housner for k in (1e10, 1e11, 1e12)}
    assert late[1e10] + housner == pytest.approx(quarter_s, abs=6e-7)
    assert late[1e11] / late[1e10] == pytest.approx(0.1**0.5, rel=0.01)
    assert late[1e12] / late[1e11] == pytest.approx(0.1**0.5, rel=0.01)
    assert 0 < late[1e12] < 1.31e-4


every_rule = st.sampled_from(["geometric", "tensionless"]).map(lambda rule: Rules(rule, "pivoting"))


def thrown(parameters, theta0, theta_rate0):
    """State of configuration 2 thrown from its static depth."""
    depth = static_depth(BLOCKS[2], Foundation.of(parameters), theta0)
    return State(depth, 0.0, theta0, theta_rate0)


@given(beds, starts, every_rule)
@settings(max_examples=25)
def test_damping_never_adds_energy(bed, start, rules):
    model, parameters = bed
    time, begin = np.linspace(0, 0.6, 601), thrown(parameters, *start)
    found = simulate(model, BLOCKS[2], parameters, time, theta0=begin, rules=rules, solver=Solver(1e-9))
    motion = found.z_cb, found.z_cb_rate, found.theta, found.theta_rate
    level = energy(BLOCKS[2], Foundation.of(parameters), *motion, rules)
    level = level[np.isfinite(level)]
    assert np.diff(level).max(initial=0) <= 1e-7 * level[0] + 1e-12


@pytest.mark.parametrize("number", BLOCKS)
def test_energy_without_damping_is_kept(number):
    time, law = np.linspace(0, 20, 2001), {"k": 6.88e6, "c": 0.0}
    solver = Solver(1e-10)
    found = simulate(
        "winkler", BLOCKS[number], law, time, theta0=RELEASE[number], rules=PIVOTING, solver=solver
    )
    motion = found.z_cb, found.z_cb_rate, found.theta, found.theta_rate
    level = energy(BLOCKS[number], Foundation(law["k"]), *motion, PIVOTING)
    assert len(found.impacts) > 20
    assert np.abs(level / level[0] - 1).max() < 1e-8


@given(beds, starts, every_rule)
@settings(max_examples=15)
def test_mirror_symmetry(bed, start, rules):
    model, parameters = bed
    time = np.linspace(0, 0.6, 61)
    one, other = (
        simulate(model, BLOCKS[2], parameters, time, theta0=thrown(parameters, *start), rules=rules)
        for start in (start, (-start[0], -start[1]))
    )
    assert one.theta == pytest.approx(-other.theta, abs=1e-9, nan_ok=True)
    assert one.outcome == other.outcome and one.impacts == pytest.approx(other.impacts, abs=1e-6)


@given(beds, st.floats(0.02, 0.15), st.floats(-4, 8), every_rule)
@settings(max_examples=15)
def test_accelerating_frame_is_another_gravity(bed, theta0, z_ground, rules):
    """θ(t) under g + z̈_g is θ(t) under g, in other units of time and force."""
    model, parameters = bed
    share = math.sqrt((GRAVITY + z_ground) / GRAVITY)
    time = np.linspace(0, 0.6, 61)
    depth = static_depth(BLOCKS[2], Foundation(parameters["k"] / share**2), theta0)
    lift = accelerogram([0.0, 1.0], x=[0.0, 0.0], z=[z_ground, z_ground])
    begin, solver = State(depth, 0.0, theta0, 0.0), Solver(1e-10)
    found = simulate(
        model, BLOCKS[2], parameters, time, theta0=begin, rules=rules, solver=solver, base_excitation=lift
    )
    slower = {name: value / share ** {"k": 2}.get(name, 1) for name, value in parameters.items()}
    expected = simulate(model, BLOCKS[2], slower, time * share, theta0=begin, rules=rules, solver=solver)
    assume(found.outcome == expected.outcome == "completed")
    assert found.theta == pytest.approx(expected.theta, abs=2e-8)


@pytest.mark.parametrize("shape", ["sine", "cosine"])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
def test_upright_block_leaves_no_side_when_the_ground_starts(kinematics, side, shape):
    motion, time = pulse(shape, 0.3, x=side * 1.5), np.linspace(0, 0.5, 2001)
    rules = Rules(kinematics=kinematics)
    found = simulate("hunt_crossley", BLOCKS[2], MARBLE, time, base_excitation=motion, rules=rules)
    changes = time[1:][np.diff(np.sign(found.theta)) != 0][1:]  # the first is that from 0
    assert side * found.theta[1] > 0 and len(changes) == 2
    assert found.impacts == pytest.approx(changes, abs=3e-4)
