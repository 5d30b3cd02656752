"""Housner's closed form: pushes, throws, machine precision, rest."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from freerock.models import housner
from freerock.models.block import Block
from freerock.models.block_on_bed import State
from freerock.models.housner import REST_AMPLITUDE, housner_motion, housner_swings
from freerock.models.simulate import Solver, simulate

BLOCK = Block(0.28, 0.07, 5.84)
ALPHA = math.radians(10)

blocks = st.builds(Block, st.floats(0.05, 3), st.floats(0.05, 1), st.floats(0.1, 1e3))


@pytest.mark.parametrize(
    ("r", "impacts", "peaks"),
    [
        (0.958, [0.26888, 0.71043, 1.09557, 1.44071, 1.75486], [8.4603, 7.3517, 6.4754, 5.7520]),
        (0.895, [0.26888, 0.62923, 0.91424, 1.15108], [6.8169, 5.0438, 3.8421, 2.9724]),
    ],
)
def test_impacts_and_peaks_of_configuration_2(r, impacts, peaks):
    swings = housner_swings(BLOCK, r, ALPHA)
    assert swings.impact_time[: len(impacts)] == pytest.approx(impacts, abs=6e-6)
    assert np.degrees(swings.peak[1 : len(peaks) + 1]) == pytest.approx(peaks, abs=6e-5)


def pendulum(theta0, theta_rate0, time, **options):
    """Rotation and rate until the first impact, by SciPy."""
    side = math.copysign(1.0, theta0 or theta_rate0)
    return solve_ivp(
        lambda t, y: [y[1], -(BLOCK.p**2) * math.sin(side * BLOCK.theta_cr - y[0])],
        (0, time[-1]),
        [theta0, theta_rate0],
        "DOP853",
        t_eval=time,
        rtol=3e-14,
        atol=1e-16,
        **options,
    )


@pytest.mark.parametrize("theta0", [ALPHA, -ALPHA, BLOCK.theta_cr - 1e-9])
def test_first_swing_from_rest(theta0):
    swings = housner_swings(BLOCK, 0.5, theta0)
    time = np.linspace(0, swings.impact_time[0], 60)
    theta, theta_rate = housner_motion(swings, time, theta0)
    expected = pendulum(theta0, 0.0, time).y
    # near the critical angle an error grows as exp(p t)
    growth = math.exp(BLOCK.p * time[-1])
    assert theta == pytest.approx(expected[0], abs=1e-13 * growth)
    assert theta_rate == pytest.approx(expected[1], abs=1e-12 * growth)
    assert theta[-1] == pytest.approx(0, abs=2e-15)
    assert theta_rate[-1] == pytest.approx(-swings.sign[0] * swings.impact_rate[0], rel=1e-12)


@pytest.mark.parametrize(
    ("theta0", "theta_rate0"),
    [
        (0.1, 0.8),  # pushed outward
        (0.1, -0.8),  # inward
        (0.0, 1.0),  # struck at rest
        (0.15, -2.5),  # inward, too fast ever to have been at rest
        (0.3, -1.5),  # thrown back from beyond the critical angle
    ],
)
def test_first_swing_of_a_block_that_is_pushed(theta0, theta_rate0):
    def upright(_, y):
        return y[0] if theta0 else y[0] + 1e-3

    upright.terminal, upright.direction = True, -1
    last = pendulum(theta0, theta_rate0, np.array([0.0, 2.0]), events=upright).t_events[0][0]
    time = np.linspace(0, last, 60)[:-1]
    start = State(0.0, 0.0, theta0, theta_rate0)
    response = simulate(
        "housner", BLOCK, {"r": 0.5}, [*time, last + 1e-6], theta0=start, solver=Solver(1e-12)
    )
    expected = pendulum(theta0, theta_rate0, time).y
    assert response.theta[:-1] == pytest.approx(expected[0], abs=1e-9)
    assert response.theta_rate[:-1] == pytest.approx(expected[1], abs=1e-8)
    assert not theta0 or response.impacts == pytest.approx([last], abs=1e-9)


@given(blocks, st.floats(1e-6, 1 - 1e-6), st.floats(0.05, 1.0))
def test_energy_is_kept_to_machine_precision(block, share, r):
    """½ θ̇² + p² (cosφ - cosθ_cr) within every swing, and r² of it in the next."""
    theta0 = share * block.theta_cr
    swings = housner_swings(block, r, theta0, until=40 / block.p)
    time = np.linspace(0, min(swings.impact_time[-1], 40 / block.p), 500)
    theta, theta_rate = housner_motion(swings, time, theta0)
    swing = np.searchsorted(swings.impact_time, time)
    kinetic = (theta_rate / (2 * block.p)) ** 2
    # sin²(θ_cr/2) - sin²(φ/2)
    potential = np.sin(np.abs(theta) / 2) * np.sin(block.theta_cr - np.abs(theta) / 2)
    expected = swings.energy[0] * r ** (2.0 * swing)
    scale = math.sin(block.theta_cr / 2) ** 2
    assert kinetic + potential == pytest.approx(expected, abs=2e-14 * scale)


def test_every_impact_up_to_rest():
    swings = housner_swings(BLOCK, 0.9, ALPHA)
    assert np.all(np.diff(swings.impact_time) > 0)
    assert swings.peak[-1] < REST_AMPLITUDE < swings.peak[-2]
    assert swings.impact_time[-1] < swings.rest_time < swings.impact_time[-1] + 1e-5
    theta, rate = housner_motion(swings, np.array([swings.rest_time, 100.0]), ALPHA)
    assert np.all(theta == 0) and np.all(rate == 0)


def test_no_restitution_no_second_swing():
    swings = housner_swings(BLOCK, 0.0, ALPHA)
    assert len(swings.impact_time) == 1
    assert swings.rest_time == swings.impact_time[0]


@pytest.mark.parametrize(
    "theta0, theta_rate0", [(0.25, 0.0), (-0.25, 0.0), (0.2, 2.0), (BLOCK.theta_cr, 0.0)]
)
def test_beyond_return(theta0, theta_rate0):
    response = simulate("housner", BLOCK, {"r": 0.9}, [0.0, 1.0], theta0=State(0.0, 0.0, theta0, theta_rate0))
    assert response.outcome == "overturned"
    assert response.theta[0] == theta0 and np.isnan(response.theta[1])


def test_thrown_over_to_the_other_side():
    start = State(0.0, 0.0, 0.1, -5.0)
    response = simulate("housner", BLOCK, {"r": 0.95}, np.linspace(0, 1, 101), theta0=start)
    assert response.outcome == "overturned" and len(response.impacts) == 1
    assert np.isfinite(response.theta[:2]).all() and np.isnan(response.theta[-1])


def test_endless_rocking_has_a_limit():
    response = simulate("housner", BLOCK, {"r": 1.0}, [0.0, 50.0], theta0=1e-3, solver=Solver(max_steps=100))
    assert response.outcome == "step_limit" and np.isnan(response.theta[-1])


def test_depth_of_the_base_centre_follows_the_corner():
    time = np.linspace(0, 2, 2001)
    response = simulate("housner", BLOCK, {"r": 0.9}, time, theta0=ALPHA)
    assert response.z_cb == pytest.approx(-BLOCK.b * np.sin(np.abs(response.theta)), abs=1e-17)
    smooth = response.contact[1:] == response.contact[:-1]
    change = np.diff(response.z_cb) - (response.z_cb_rate[1:] + response.z_cb_rate[:-1]) / 2 * np.diff(time)
    assert np.abs(change[smooth]).max() < 1e-8


def test_sums_of_powers_have_all_digits():
    """Those that stand for functions, and a motion by either."""
    short, slender = np.linspace(-housner.SHORT, housner.SHORT, 401), np.linspace(1e-9, housner.SLENDER, 401)
    for found, expected in (
        ([housner._sum_of_powers(x * x, housner.C) for x in short], np.cosh(short)),
        ([x * housner._sum_of_powers(x * x, housner.S) for x in short], np.sinh(short)),
        ([x * housner._sum_of_powers(x * x, housner.A) for x in slender], np.arcsin(slender)),
    ):
        np.testing.assert_allclose(found, expected, rtol=4e-16, atol=0)
    # from near θ_cr a swing lasts too long for them, its beginning does not
    theta0 = 0.999 * BLOCK.theta_cr
    swings = housner_swings(BLOCK, 0.9, theta0)
    time = np.linspace(0.0, swings.impact_time[0], 2000)
    assert BLOCK.p * time[200] < 1 < 6 < BLOCK.p * time[-1]
    for whole, beginning in zip(
        *(housner_motion(swings, each, theta0) for each in (time, time[:200])), strict=True
    ):
        np.testing.assert_allclose(whole[:200], beginning, rtol=1e-12, atol=1e-15)
