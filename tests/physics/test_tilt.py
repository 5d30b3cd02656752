"""A base off level: gravity along it, where the block stands, mirror, an independent integration."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_law import accelerations, contact_force, sideways
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State, lean, static_depth
from freerock.models.ground import tilted
from freerock.models.laws import Foundation, Rules
from freerock.models.simulate import Solver, simulate, simulate_fitted

BLOCK = Block(0.28, 0.07, 5.84)
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}
AEROSTOP = {"k": 2.86e6, "lambda": 8.16e7}
TIME = np.arange(0, 3, 2e-3)
LAWS = [("housner", {"r": 0.93}), ("winkler", {"k": 6.77e6, "c": 2.17e4}), ("hunt_crossley", MARBLE)]


def test_gravity_keeps_its_size():
    x, z = tilted(0.02, 5.0)([-0.5, 0.0, 5.0])
    np.testing.assert_allclose(x, GRAVITY * math.sin(0.02), rtol=1e-14)
    np.testing.assert_allclose(np.hypot(x, GRAVITY + z), GRAVITY, rtol=1e-14)


@pytest.mark.parametrize("parameters", [MARBLE, AEROSTOP])
@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
def test_the_block_stands_where_the_moments_are_in_balance(parameters, kinematics):
    soil, tau = Foundation.of(parameters), math.radians(0.5)
    along, across = GRAVITY * math.sin(tau), GRAVITY * math.cos(tau)

    def left_over(theta):
        depth = BLOCK.mass_kg * across / (2 * BLOCK.b * soil.k)
        state = State(depth, 0.0, theta, 0.0)
        ground = {"x_ground": along, "z_ground": across - GRAVITY}
        return accelerations(BLOCK, soil, state, Rules(kinematics=kinematics), **ground)[1]

    stands = brentq(left_over, -0.01, 0.01)
    assert lean(BLOCK, soil, tau) == pytest.approx(stands, rel=1e-2 if kinematics == "pivoting" else 1e-4)
    assert lean(BLOCK, soil, tau) == pytest.approx(
        BLOCK.mass_kg * along * BLOCK.h / (2 / 3 * BLOCK.b**3 * soil.k - BLOCK.mass_kg * across * BLOCK.h)
    )


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-9, 1e-10, 1e-12])
@pytest.mark.parametrize("r", [0.5, 0.9, 0.99])
def test_a_rigid_block_comes_to_rest_however_exact_it_is_asked(r, rtol):
    """Its impacts follow ever faster upon each other, each located no better than the tolerance."""
    solver = Solver(rtol, max_steps=20_000)
    theta = simulate_fitted(
        "housner", BLOCK, {"r": r, "tilt": 1e-5, "theta0": 0.1}, np.arange(0, 40, 1e-2), solver=solver
    )
    assert theta[-1] == 0


@given(
    st.sampled_from(LAWS),
    st.floats(-0.01, 0.01),
    st.floats(0.05, 0.13),
    st.sampled_from(["guided", "pivoting"]),
)
@settings(max_examples=25, deadline=None)
def test_mirrored_tilt_and_release_mirror_the_motion(law, tilt, theta0, kinematics):
    model, parameters = law
    moved = partial(simulate_fitted, model, BLOCK, time=TIME, rules=Rules(kinematics=kinematics))
    one = moved(values=parameters | {"tilt": tilt, "theta0": theta0})
    other = moved(values=parameters | {"tilt": -tilt, "theta0": -theta0})
    np.testing.assert_allclose(one, -other, atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
def test_an_independent_integration_of_the_tilted_base(kinematics):
    """The readable law in SciPy's DOP853, in axes of the base."""
    soil, tau, theta0, rules = Foundation.of(AEROSTOP), 6e-3, 0.12, Rules(kinematics=kinematics)
    stands = lean(BLOCK, soil, tau)
    m = BLOCK.mass_kg

    def rates(_, y):
        theta, w, z, v = y
        force, moment = contact_force(BLOCK, soil, State(z, v, theta, w), rules)
        lever, slope = sideways(BLOCK, theta, rules)
        turning = m * lever * (GRAVITY * math.sin(tau) - slope * w**2) - moment
        turning += BLOCK.h * math.sin(theta) * force
        turned = turning / (BLOCK.inertia_cm + m * lever**2)
        fall = BLOCK.h * (math.cos(theta) * w**2 + math.sin(theta) * turned)
        return [w, turned, v, GRAVITY * math.cos(tau) - force / m - fall]

    begin = [theta0 + stands, 0.0, static_depth(BLOCK, soil, theta0), 0.0]
    time = TIME[TIME < 1.2]
    reference = solve_ivp(rates, (0, 1.3), begin, "DOP853", time, rtol=1e-10, atol=1e-13, max_step=1e-3).y[0]
    values = AEROSTOP | {"tilt": tau}
    theta = simulate_fitted(
        "hunt_crossley", BLOCK, {**values, "theta0": theta0}, time, rules=rules, solver=Solver(1e-11)
    )
    np.testing.assert_allclose(theta, reference - stands, atol=2e-7)


def test_a_rigid_block_has_less_to_overcome_on_the_side_to_which_the_base_leans():
    """Between impacts φ̈ = p² sin φ about θ_cr ∓ τ (Housner's equation in axes of the base)."""
    tau, theta0 = 4e-3, 0.1
    for sign in (1, -1):
        theta = simulate_fitted(
            "housner", BLOCK, {"r": 0.93, "tilt": tau, "theta0": sign * theta0}, TIME, solver=Solver(1e-11)
        )
        before = sign * theta > 0.02
        before &= np.cumsum(sign * theta < 0) == 0

        def rates(_, y, sign=sign):
            return [y[1], -sign * BLOCK.p**2 * math.sin(BLOCK.theta_cr - abs(y[0]) - sign * tau)]

        reference = solve_ivp(
            rates, (0, 3), [sign * theta0, 0.0], "DOP853", TIME[before], rtol=1e-11, atol=1e-13
        ).y[0]
        np.testing.assert_allclose(theta[before], reference, atol=1e-8)
    response = simulate("housner", BLOCK, {"r": 0.93}, TIME, theta0=theta0, base_excitation=tilted(tau, 3.0))
    again = simulate_fitted("housner", BLOCK, {"r": 0.93, "tilt": tau, "theta0": theta0}, TIME)
    np.testing.assert_allclose(again, response.theta, atol=1e-6)
