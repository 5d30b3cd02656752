"""The compiled integrator: its law, Jacobian, borders, two methods, and its cache on disk."""

import math

import numpy as np
import plain_law
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from freerock.models import block_on_bed, kernel
from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State
from freerock.models.laws import Foundation, Rules

BLOCK = Block(0.28, 0.07, 5.84)
ODD = Block(0.28, 0.07, 5.84, com_height_m=0.15, com_offset_m=0.004, inertia_kg_m2=0.05)
STILL = np.empty((0, 10))
SHAKEN = np.array([[1.0, 2.0, 5.0, 6.0, 0.3, -1.0, 2.0, 0.5, 7.0, 0.1]])

laws = st.tuples(st.floats(1e5, 1e9), st.floats(0.001, 0.1), st.booleans()).map(
    lambda x: (x[0], x[0] * x[1], 0.0) if x[2] else (x[0], 0.0, 1e3 * x[0] * x[1])
)
states = st.tuples(st.floats(-0.02, 0.02), st.floats(-1, 1), st.floats(-0.6, 0.6), st.floats(-5, 5))
blocks = st.sampled_from([BLOCK, ODD])
ground = st.tuples(st.floats(-5, 5), st.floats(0, 20))  # ẍ_g, g + z̈_g
kinematics = st.sampled_from(["guided", "pivoting"])


def per_mass(law, sideways="guided", side=1, block=BLOCK):
    """The kernel's constants; a block that pivots turns about its right corner, or its left one."""
    *constants, corner, radius, offset = Foundation(*law).constants(block, sideways == "pivoting")
    return (*constants, math.copysign(corner, side), radius, offset)


def regime_of(law, state, tensionless):
    bits = kernel._signs(tensionless, state, per_mass(law))
    return kernel._regime(bits, tensionless)


def away_from_edges(law, state, tensionless):
    """No end of the contact interval, nor the slope of the base, is near a border of the regime."""
    z, _, theta, _ = state
    corners = [z + side * BLOCK.b * math.sin(theta) for side in (1, -1)]
    assume(abs(theta) > 1e-2 and min(map(abs, corners)) > 1e-4)
    rule = "tensionless" if tensionless else "geometric"
    for u0, u1 in plain_law.contact_intervals(BLOCK, Foundation(*law), State(*state), Rules(rule)):
        assume(u1 - u0 > 1e-3)


@given(laws, states, ground, st.booleans(), kinematics, blocks)
def test_compiled_law_is_the_readable_one(law, state, moved, tensionless, sideways, block):
    away_from_edges(law, state, tensionless)
    rules = Rules("tensionless" if tensionless else "geometric", sideways)
    regime = regime_of(law, state, tensionless)
    found = kernel._accelerations(regime, *state, *moved, per_mass(law, sideways, state[2], block))
    expected = plain_law.accelerations(
        block, Foundation(*law), State(*state), rules, x_ground=moved[0], z_ground=moved[1] - GRAVITY
    )
    force, _ = plain_law.contact_force(BLOCK, Foundation(*law), State(*state), rules)
    scale = abs(force) / BLOCK.mass_kg + 40
    assert found[0] == pytest.approx(expected[0], abs=1e-10 * scale)
    assert found[1] == pytest.approx(expected[1], abs=1e-10 * scale / BLOCK.b)


@given(laws, states, ground, st.booleans(), kinematics, blocks)
def test_jacobian_is_the_derivative(law, state, moved, tensionless, sideways, block):
    away_from_edges(law, state, tensionless)
    law = per_mass(law, sideways, state[2], block)
    bits = kernel._signs(tensionless, state, law)
    regime = kernel._regime(bits, tensionless)
    found = np.reshape(kernel._jacobian(regime, state, *moved, law), (2, 4))
    for i, step in enumerate((1e-7, 1e-5, 1e-6, 1e-4)):
        shifted = np.array([state, state])
        shifted[:, i] += step, -step
        above, below = (kernel._accelerations(regime, *row, *moved, law) for row in shifted)
        slope = (np.array(above) - below) / (2 * step)
        scale = np.abs(found).max(axis=1) * (0.01 if i in (1, 3) else 1) + np.abs(above).max() + 1
        assert found[:, i] == pytest.approx(slope, abs=2e-4 * scale.max() / (BLOCK.b if i in (1, 3) else 1))


@given(laws, st.floats(-1, 1), st.floats(0.02, 0.5), st.floats(-5, 5), st.sampled_from([1, -1]))
def test_formulas_of_neighbouring_regimes_meet(law, v, theta, w, side):
    """Full to partial contact, partial contact to flight: the border has one acceleration."""
    theta *= side
    reach = BLOCK.b * math.sin(abs(theta))
    partial = kernel.RIGHT if side > 0 else kernel.LEFT
    for z, other in ((reach, kernel.FULL), (-reach, kernel.FLIGHT)):
        here, there = (
            kernel._accelerations(regime, z, v, theta, w, 0.0, GRAVITY, per_mass(law))
            for regime in (partial, other)
        )
        assert here == pytest.approx(there, rel=1e-9, abs=1e-6)


def bounce(stiff, duration, steps, coefficients, sideways):
    """Bouncing on the whole base, in equal steps: the state at the end, and from the dense output of the
    last step that at its middle."""
    law = per_mass((6e6, 0.0, 4e7), sideways)
    state, dense, stages = (2e-4, 0.02, 1e-3, 0.05), np.zeros((4, 5)), np.empty((8, 4))
    h = duration / steps
    for i in range(steps):
        x, gravity = kernel._ground(coefficients, 0, i * h, GRAVITY)
        rates = kernel._accelerations(kernel.FULL, *state, x, gravity, law)
        state, *_ = kernel._step(
            stiff, kernel.FULL, h, state, rates, (coefficients, 0, i * h), law, (1.0, 1.0, 1.0), dense, stages
        )
    return np.array(state), np.array(kernel._state_at(dense, 0.5))


@pytest.mark.parametrize("coefficients", [STILL, SHAKEN], ids=["still", "shaken"])
@pytest.mark.parametrize("stiff", [False, True], ids=["explicit", "implicit"])
@pytest.mark.parametrize("sideways", ["guided", "pivoting"])
def test_both_methods_and_their_dense_output_are_of_fifth_order(sideways, stiff, coefficients):
    scale, duration = np.array([1e-4, 1e-2, 1e-3, 1e-1]), 0.02
    steps, errors, between = np.array([12, 16, 24, 32]), [], []
    exact, _ = bounce(False, duration, 500, coefficients, sideways)
    for n in steps:
        end, middle = bounce(stiff, duration, int(n), coefficients, sideways)
        exact_middle, _ = bounce(False, duration * (1 - 0.5 / n), 500, coefficients, sideways)
        errors.append(np.abs((end - exact) / scale).max())
        between.append(np.abs((middle - exact_middle) / scale).max())
    for error in (errors, between):
        assert -np.polyfit(np.log(steps), np.log(error), 1)[0] > 4.7


def test_an_excursion_inside_one_step_is_found():
    """The right corner leaves the ground and returns: z = z0 - 1e-3 x (1 - x), of equal sign at both ends."""
    theta = 0.1
    reach = BLOCK.b * math.sin(theta)
    dense = np.zeros((4, 5))
    dense[0, :3] = 1e-4 - reach, 0.0, -1e-3
    dense[1, :2] = -1e-3, 2e-3
    dense[2, 0] = theta
    x, which = kernel._first_event(kernel.RIGHT, 1, False, False, dense, per_mass((6e6, 0.0, 4e7)))
    assert which == 0
    assert x == pytest.approx((1 - math.sqrt(0.6)) / 2, rel=1e-12)
    dense[0, 2] = -3e-4
    assert kernel._first_event(kernel.RIGHT, 1, False, False, dense, per_mass((6e6, 0.0, 4e7))) == (2.0, -1)


def test_a_change_of_corner_inside_one_step_is_found():
    """θ passes zero and returns, 1e-3 - 6e-3 x (1 - x), or does not return."""
    dense, law = np.zeros((4, 5)), per_mass((6e6, 0.0, 4e7), "pivoting")
    dense[0, 0] = 1e-2
    dense[2, 0], dense[2, 2] = 1e-3, -6e-3
    dense[3, :2] = -6e-3, 12e-3
    x, which = kernel._first_event(kernel.FULL, 3, False, True, dense, law)
    assert which == 5
    assert x == pytest.approx((1 - math.sqrt(1 / 3)) / 2, rel=1e-12)
    assert kernel._first_event(kernel.FULL, 3, False, False, dense, law) == (2.0, -1)
    dense[2, 1:3] = -4e-3, 0.0
    dense[3, :2] = -4e-3, 0.0
    assert kernel._first_event(kernel.FULL, 3, False, True, dense, law) == pytest.approx((0.25, 5))


def run(law, theta0, time, tolerance=1e-9, max_steps=100_000):
    theta = np.empty(time.size)
    z0 = block_on_bed.static_depth(BLOCK, Foundation(*law), theta0)
    outcome, *counts, _ = kernel.integrate(
        per_mass(law), -1.0, False, (z0, 0.0, theta0, 0.0), time, np.empty(0), STILL, tolerance, max_steps,
        np.empty(0), np.empty((0, 5)), theta, np.empty((0, 3)),
    )  # fmt: skip
    return theta, outcome, counts


def test_same_bytes_every_time():
    time = np.linspace(0, 2, 1001)
    first, *_ = run((6.88e6, 0.0, 1.3e8), 0.17, time)
    again, *_ = run((6.88e6, 0.0, 1.3e8), 0.17, time)
    assert first.tobytes() == again.tobytes()


def test_samples_do_not_change_the_motion():
    time = np.linspace(0, 2, 1001)
    all_samples, _, counts = run((6.77e6, 2.17e4, 0.0), 0.17, time)
    few_samples, _, few_counts = run((6.77e6, 2.17e4, 0.0), 0.17, time[::100].copy())
    assert np.array_equal(all_samples[::100], few_samples)
    assert counts == few_counts


def test_stiff_law_is_integrated_implicitly_and_work_stays_bounded():
    """Winkler, c/k fixed: explicit steps alone would need 1e5 times as many at k = 1e12 as at 1e6."""
    time = np.array([0.0, 5.0])
    steps = {}
    for k in (1e6, 1e8, 1e10, 1e12):
        _, outcome, (taken, rejected, implicit, _) = run((k, k * 3.2e-3, 0.0), 0.17, time)
        assert outcome in (kernel.COMPLETED, kernel.AT_REST)
        steps[k] = taken + rejected
    assert implicit > 1000
    assert steps[1e12] < 10 * steps[1e6]


def test_implicit_and_explicit_agree():
    """A light tolerance drives the implicit method, a tight one the explicit."""
    time = np.linspace(0, 1.0, 101)
    law = (1e11, 3.2e8, 0.0)
    loose, _, (_, _, implicit, _) = run(law, 0.17, time, tolerance=1e-8)
    tight, _, (_, _, still_implicit, _) = run(law, 0.17, time, tolerance=1e-12, max_steps=1_000_000)
    assert implicit > 100 > still_implicit
    assert loose == pytest.approx(tight, abs=1e-6)
