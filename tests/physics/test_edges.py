"""Rounded edges of the base: the law on what of it is below the ground, a block at rest, an independent
integration, and sharp edges as their limit."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from plain_law import accelerations, contact_force
from scipy.integrate import solve_ivp

from freerock.errors import FreerockError
from freerock.models import kernel
from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State, energy, static_depth
from freerock.models.laws import GEOMETRIC, Foundation, Rules
from freerock.models.simulate import Solver, simulate, simulate_fitted
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS

BLOCK = Block(0.28, 0.07, 5.84)
TIME = np.arange(0, 3, 1e-3)
MARBLE = FOUNDATIONS["marble"]
KNOTS, WEIGHTS = np.polynomial.legendre.leggauss(24)  # over the part of the base that touches

laws = st.tuples(st.floats(1e5, 1e9), st.floats(0.001, 0.1), st.booleans()).map(
    lambda x: Foundation(x[0], x[0] * x[1]) if x[2] else Foundation(x[0], 0.0, 1e3 * x[0] * x[1])
)
radii = st.floats(1e-5, 5e-3)
states = st.builds(State, st.floats(-0.01, 0.01), st.floats(-1, 1), st.floats(-0.4, 0.4), st.floats(-5, 5))


def rounded(radius, block=BLOCK):
    return replace(block, edge_radius_m=radius)


def scale(law, state):
    """Of the force and of its parts, which may be of either sign."""
    speed = abs(state.z_rate) + BLOCK.b * abs(state.theta_rate)
    return 2 * BLOCK.b * (law.k + law.lam * speed) * 1e-2 + 2 * BLOCK.b * law.c * speed


def on_rounded(block, soil, state, radius_m):
    """Force [N] and moment [N·m] of the contact law on a base with rounded edges, as `contact_force`.

    At u from the base's centre the base lies w(u) = ρ - sqrt(ρ² - v²) higher, with v = |u| - (b - ρ) > 0 on
    an edge of radius ρ. It touches where z + u sinθ > w(u), which is one interval, for w is convex.
    """
    flat, s = block.b - radius_m, abs(math.sin(state.theta))
    right = end_of(state.z + flat * s, s, radius_m)
    if right is None:
        return 0.0, 0.0
    high = flat + right[1]
    low = -state.z / s if s > 0 else -math.inf
    if low > flat:
        low = flat + right[0]
    elif low < -flat:
        left = end_of(state.z - flat * s, -s, radius_m)
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


def end_of(depth, slope, radius_m):
    """Where v on an edge, which begins so deep [m], comes out: depth + v slope = ρ - sqrt(ρ² - v²)."""
    free = radius_m - depth
    root = radius_m**2 * (1 + slope**2) - free**2
    if radius_m * slope >= free:  # the whole edge touches
        return -math.inf, radius_m
    if root < 0:
        return None
    middle, half = free * slope, math.sqrt(root)
    return (middle - half) / (1 + slope**2), (middle + half) / (1 + slope**2)


def integrated(block, law, theta0, radius_m, kinematics):
    """θ [rad] and depth [m] of a block with rounded edges by SciPy, shape (2, n).

    It turns in place, or about the end of its flat base that is down.
    """
    soil, arm = Foundation.of(law), block.b - radius_m if kinematics == "pivoting" else 0.0

    def rates(_, y):
        theta, w, z, z_rate = y.tolist()
        force, moment = on_rounded(block, soil, State(z, z_rate, theta, w), radius_m)
        m, s = block.mass_kg, math.sin(theta)
        held, cos = math.copysign(arm, theta), math.cos(theta)
        lever, slope = block.h * cos + held * s, held * cos - block.h * s
        turn = (block.h * s * force - moment - m * lever * slope * w**2) / (block.inertia_cm + m * lever**2)
        fall = GRAVITY - force / m - block.h * (math.cos(theta) * w**2 + s * turn)
        return [w, turn, z_rate, fall]

    start = [theta0, 0.0, static_depth(rounded(radius_m, block), soil, theta0), 0.0]
    rtol = 1e-8 if arm else 1e-7  # the lever of a pivoting block has a kink
    return solve_ivp(rates, (0, TIME[-1]), start, "DOP853", TIME, rtol=rtol, atol=1e-3 * rtol).y[[0, 2]]


def test_rounded_edges_turn_nearer_to_the_middle():
    """At rest on one edge of a rounded base the force stands nearer to the middle, ρ sinθ of a rigid one."""
    theta, radius, stiff = 0.1, 2e-3, Foundation(1e12)
    flat = BLOCK.b - radius
    u = flat + radius * math.sin(theta)
    touching = radius * (1 / math.cos(theta) - 1)  # z at which the edge would just touch, less its slope
    depths = -u * math.sin(theta) + radius - math.sqrt(radius**2 - (u - flat) ** 2)
    force, moment = on_rounded(BLOCK, stiff, State(depths + 1e-7, 0.0, theta, 0.0), radius)
    assert touching > 0 and force > 0
    assert moment / force / math.cos(theta) == pytest.approx(u, abs=2e-5)


@given(laws, states, radii)
def test_force_and_moment_are_those_of_a_quadrature_over_the_base(law, state, radius):
    corners = [state.z + side * (BLOCK.b - radius) * math.sin(state.theta) for side in (1, -1)]
    assume(abs(state.theta) > 1e-6 and min(map(abs, corners)) > 1e-7)
    found = contact_force(rounded(radius), law, state)
    expected = on_rounded(BLOCK, law, state, radius)
    # Gauss's rule over v, of the expected, meets the end of the arc, where its slope has no bound
    speed = abs(state.z_rate) + BLOCK.b * abs(state.theta_rate)
    error = 1e-4 * radius * (radius * (law.k + law.lam * speed) + 1e-2 * law.c * speed)
    assert found[0] == pytest.approx(expected[0], rel=1e-9, abs=error)
    assert found[1] == pytest.approx(expected[1], rel=1e-9, abs=BLOCK.b * error)


@given(laws, states, radii)
def test_the_compiled_law_is_the_readable_one(law, state, radius):
    block, constants = rounded(radius), law.constants(rounded(radius))
    assume(abs(state.theta) > 1e-6)
    regime = kernel._regime(kernel._signs(False, tuple(state), constants), False)
    found = kernel._accelerations(regime, *state, 0.0, GRAVITY, constants)
    expected = accelerations(block, law, state)
    size = scale(law, state) / BLOCK.mass_kg + 40
    assert found[0] == pytest.approx(expected[0], abs=1e-9 * size)
    assert found[1] == pytest.approx(expected[1], abs=1e-9 * size / BLOCK.b)


@given(st.floats(1e5, 1e9), radii, st.floats(-0.3, 0.3))
def test_the_foundation_carries_a_block_with_rounded_edges(k, radius, theta):
    block, law = rounded(radius), Foundation(k)
    depth = static_depth(block, law, theta)
    force, _ = contact_force(block, law, State(depth, 0.0, theta, 0.0))
    assert force == pytest.approx(block.mass_kg * GRAVITY, rel=1e-9)
    assert 0 <= depth - static_depth(BLOCK, law, theta) <= radius


@given(st.floats(1e5, 1e9), radii)
def test_depth_and_contact_of_an_upright_block_by_the_area_of_a_circle(k, radius):
    block = rounded(radius)
    depth, stiffness = kernel.depth_at_rest(0.0, Foundation(k).constants(block))
    if depth < radius:
        angle = math.acos(1 - depth / radius)
        assert stiffness * block.mass_kg / (2 * k) == pytest.approx(
            block.flat + radius * math.sin(angle), rel=1e-9
        )
        segments = radius**2 * (angle - math.sin(angle) * math.cos(angle))
        area = 2 * block.flat * depth + segments
        assert k * area == pytest.approx(block.mass_kg * GRAVITY, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("configuration", "foundation", "radius", "kinematics"),  # each pair of two of them once at least
    [
        ("config1", "marble", 7e-4, "guided"),
        ("config1", "aerstop", 2e-3, "pivoting"),
        ("config2", "marble", 2e-3, "guided"),
        ("config2", "aerstop", 7e-4, "pivoting"),
        ("config3", "marble", 7e-4, "pivoting"),
        ("config3", "aerstop", 2e-3, "guided"),
    ],
)
def test_motion_is_that_of_an_independent_integration(configuration, foundation, radius, kinematics):
    sharp, angle, _ = CONFIGURATIONS[configuration]
    block, law, rules = rounded(radius, sharp), FOUNDATIONS[foundation], Rules(kinematics=kinematics)
    expected, depth = integrated(sharp, law, angle, radius, kinematics)
    found = simulate("hunt_crossley", block, law, TIME, theta0=angle, rules=rules, solver=Solver(1e-9))
    np.testing.assert_allclose(found.theta, expected, atol=5e-6)
    np.testing.assert_allclose(found.z_cb, depth, atol=5e-7)
    freed = {**law, "theta0": angle, "edge_radius": radius}
    as_fits = simulate_fitted("hunt_crossley", sharp, freed, TIME, rules=rules)
    np.testing.assert_allclose(as_fits, expected, atol=5e-6)


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
def test_without_damping_the_energy_is_kept(kinematics):
    block, bed, rules = rounded(2e-3), {"k": 6.77e6, "c": 0.0}, Rules(kinematics=kinematics)
    found = simulate("winkler", block, bed, TIME, theta0=0.15, rules=rules, solver=Solver(1e-11))
    motion = found.z_cb, found.z_cb_rate, found.theta, found.theta_rate
    kept = energy(block, Foundation.of(bed), *motion, rules)
    assert np.abs(kept / kept[0] - 1).max() < 1e-7
    sunk = static_depth(block, Foundation.of(bed), 0.0)
    assert energy(block, Foundation.of(bed), sunk, 0.0, 0.0, 0.0, rules) == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("law", [("hunt_crossley", MARBLE), ("winkler", {"k": 6.77e6, "c": 2.17e4})])
def test_sharp_edges_are_the_limit(law):
    sharp = simulate(*law[:1], BLOCK, law[1], TIME, theta0=0.12)
    none = simulate(*law[:1], rounded(0.0), law[1], TIME, theta0=0.12)
    assert np.array_equal(sharp.theta, none.theta)
    off = [
        np.abs(simulate(*law[:1], rounded(radius), law[1], TIME, theta0=0.12).theta - sharp.theta).max()
        for radius in (1e-6, 1e-5, 1e-4)
    ]
    assert off[0] < 1e-5 and off[0] < off[1] < off[2]


@pytest.mark.parametrize(
    ("model", "law", "rules"),
    [
        ("housner", {"r": 0.9}, GEOMETRIC),
        ("hunt_crossley", MARBLE, Rules("tensionless")),
    ],
)
def test_what_is_not_worked_out_is_refused(model, law, rules):
    with pytest.raises(FreerockError) as error:
        simulate(model, rounded(1e-3), law, TIME, theta0=0.1, rules=rules)
    assert str(error.value) == (
        "edge_radius_m: rounded edges are implemented for geometric debonding only, "
        "under winkler, hunt_crossley, general; leave it out"
    )


@pytest.mark.parametrize("radius", [-1e-3, 0.035, None])
def test_a_radius_beyond_the_base_is_refused(radius):
    with pytest.raises(FreerockError) as error:
        simulate("hunt_crossley", rounded(radius), MARBLE, TIME, theta0=0.1)
    assert str(error.value) == (
        f"edge_radius_m: {radius} m is no radius of an edge; give 0 to 0.035 m, half the width"
    )
