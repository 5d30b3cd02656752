import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from freerock.models.block import Block
from freerock.rotation.beam import (
    displacement_from_rotation,
    rotation_from_displacement,
    sensitivity,
)
from freerock.rotation.sensor import Laser

BLOCK = Block(0.28, 0.07, 5.84)


def turned_corners(block, theta):
    """Corners of the block turned by θ (clockwise) about the base corner it stands on."""
    pivot = np.array([math.copysign(block.b, theta), 0.0])
    turn = np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
    half = block.width_m / 2
    corners = np.array([[-half, 0], [half, 0], [half, 2 * block.h], [-half, 2 * block.h]])
    return (corners - pivot) @ turn.T + pivot


def cut(start, end, axis, at):
    """Point of the segment start-end with coordinate `at` along `axis`; None when the segment misses it."""
    if not min(start[axis], end[axis]) <= at <= max(start[axis], end[axis]):
        return None
    share = (at - start[axis]) / (end[axis] - start[axis])
    return start + share * (end - start)


def directly(block, laser, theta):
    """Displacement away from the sensor by cutting the turned rectangle with the beam; None off target."""
    bottom_left, bottom_right, top_right, top_left = turned_corners(block, theta)
    if laser.beam == "horizontal":
        edge = (bottom_left, top_left) if laser.face == "left" else (bottom_right, top_right)
        hit = cut(*edge, 1, laser.position_m)
        outwards = -1 if laser.face == "left" else 1
        return None if hit is None else block.width_m / 2 - outwards * hit[0]
    beyond = abs(laser.position_m) - block.b
    if laser.position_m * theta > 0 and 0 < beyond < block.height_m * math.sin(abs(theta)):
        return None  # sunk and risen again, or past the edge
    if (
        abs(laser.position_m) >= block.width_m / 2
    ):  # an outrigger of 10 m from the edge on, level with the top
        along = (top_right - top_left) / block.width_m * math.copysign(1, laser.position_m)
        edge = (top_right if laser.position_m > 0 else top_left,)
        edge = (edge[0], edge[0] + 10 * along)
    else:
        edge = (top_left, top_right)
    hit = cut(*edge, 0, laser.position_m)
    return None if hit is None else block.height_m - hit[1]


def checked(block, laser, theta):
    """Displacement by cutting, after the formula has given the same; NaN off target."""
    expected = directly(block, laser, theta)
    expected = math.nan if expected is None else expected
    assert displacement_from_rotation(theta, block, laser) == pytest.approx(expected, abs=2e-14, nan_ok=True)
    return expected


blocks = st.builds(
    lambda height, width, share: Block(height, width, 5.0, share * width),
    st.floats(0.1, 2.0),
    st.floats(0.03, 0.5),
    st.sampled_from([1.0, 0.9, 0.7]),
)
turns = st.floats(math.radians(1e-7), math.radians(40)).flatmap(lambda t: st.sampled_from([t, -t]))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(blocks, turns, st.sampled_from(["left", "right"]), st.floats(0.01, 0.99))
def test_horizontal_beam_meets_the_turned_rectangle(block, theta, face, share):
    laser = Laser("horizontal", share * block.height_m, 0.1, face=face)
    expected = checked(block, laser, theta)
    if math.isnan(expected):
        return
    if sensitivity(theta, block, laser) > 0.01 * laser.position_m:  # not where the lower edge passes the beam
        assert abs(rotation_from_displacement(expected, block, laser) - theta) <= 1e-12


@settings(max_examples=40, deadline=None, derandomize=True)
@given(blocks, turns, st.floats(-2.0, 2.0).map(lambda share: round(share, 6)))
def test_vertical_beam_meets_the_turned_rectangle(block, theta, share):
    laser = Laser("vertical", share * block.b, 0.1)
    expected = checked(block, laser, theta)
    if math.isnan(expected):
        return
    if sensitivity(theta, block, laser) > 0.05 * block.b:
        side = math.copysign(1, theta)
        assert abs(rotation_from_displacement(expected, block, laser, side) - theta) <= 1e-12


@pytest.mark.parametrize("x", [0.1, -0.1])
def test_a_vertical_beam_over_a_worn_corner(x):
    block, laser = Block(1.0, 0.25, 50.0, 0.2), Laser("vertical", x, 0.1)
    theta = np.radians([-1.0, -0.2, 0.0, 0.2, 1.0])
    s = displacement_from_rotation(theta, block, laser)
    np.testing.assert_allclose(s, [directly(block, laser, each) for each in theta], atol=2e-14)
    near = displacement_from_rotation(theta, block, Laser("vertical", 0.9999999 * x, 0.1))
    np.testing.assert_allclose(s, near, atol=1e-9)
    np.testing.assert_allclose(rotation_from_displacement(s, block, laser, np.sign(theta)), theta, atol=1e-9)


@pytest.mark.parametrize(
    "laser",
    [
        Laser("horizontal", 0.2, 0.1),
        Laser("horizontal", 0.2, 0.1, face="right"),
        Laser("vertical", 0.09, 0.1),
        Laser("vertical", -0.09, 0.1),
    ],
)
def test_zero_is_exact_and_sensitivity_is_the_derivative(laser):
    assert rotation_from_displacement(0.0, BLOCK, laser) == 0
    theta = np.radians([-6.0, -1.0, 1.0, 2.5])
    step = 1e-6
    slope = (
        displacement_from_rotation(theta + step, BLOCK, laser)
        - displacement_from_rotation(theta - step, BLOCK, laser)
    ) / (2 * step)
    np.testing.assert_allclose(sensitivity(theta, BLOCK, laser), np.abs(slope), rtol=1e-8)


def test_beam_under_the_raised_edge_is_lost():
    low = Laser("horizontal", 0.01, 0.1)
    edge = math.asin(0.01 / BLOCK.width_m)  # where 2b sin θ = Y
    assert np.isfinite(displacement_from_rotation(edge - 1e-6, BLOCK, low))
    assert np.isnan(displacement_from_rotation(edge + 1e-6, BLOCK, low))
    assert np.isnan(rotation_from_displacement(0.05, BLOCK, low))  # further than that edge ever gives
