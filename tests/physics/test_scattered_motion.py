"""Motions whose rate is multiplied by 1 + δ after each impact."""

import numpy as np
import pytest

from freerock.models.block import Block
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, restarts, simulate_fitted

BLOCK = Block(0.28, 0.07, 5.84)
TIME = np.arange(0, 3, 1 / 1000)
DELTA = np.array([0.02, -0.015, 0.01, 0.03, -0.02, 0.004])
LAWS = {
    "housner": {"r": 0.93},
    "winkler": {"k": 4.5e6, "c": 4e4},
    "hunt_crossley": {"k": 2.9e6, "lambda": 8e7},
}


def curve(law, values, kinematics="guided", rtol=1e-10):
    return simulate_fitted(
        law, BLOCK, values, TIME, rules=Rules("geometric", kinematics), solver=Solver(rtol)
    )


def released(law, **beside):
    return {**LAWS[law], "theta0": 0.17, "t0": 0.0, **beside}


def test_peaks_of_a_rigid_block_follow_the_map_with_r_of_each_impact():
    theta = curve("housner", released("housner", impacts=DELTA))
    turned = np.flatnonzero(np.signbit(theta[1:]) != np.signbit(theta[:-1])) + 1
    peaks = [np.abs(part).max() for part in np.split(theta, turned)[1:6]]
    cr = BLOCK.theta_cr
    drop = np.cos(cr - 0.17) - np.cos(cr)
    for i, peak in enumerate(peaks):
        drop *= (LAWS["housner"]["r"] * (1 + DELTA[i])) ** 2
        assert peak == pytest.approx(cr - np.arccos(np.cos(cr) + drop), rel=1e-4)


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("law", LAWS)
def test_impacts_that_do_not_scatter_change_nothing(law, kinematics):
    plain, scattered = (
        curve(law, released(law, **beside), kinematics) for beside in ({}, {"impacts": np.zeros(8)})
    )
    assert np.abs(scattered - plain).max() < 1e-12


@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
def test_the_series_and_the_stepwise_integrator_scatter_alike(law):
    # a tilt that no sensor sees is integrated stepwise where the centre of mass is off by nothing seen either
    block = Block(0.28, 0.07, 5.84, com_offset_m=1e-12)
    by_series = curve(law, released(law, impacts=DELTA))
    by_steps = simulate_fitted(law, block, released(law, impacts=DELTA), TIME, solver=Solver(1e-10))
    assert np.abs(by_steps - by_series).max() < 1e-7


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("law", LAWS)
def test_restarts_are_the_motion_with_one_impact_changed(law, kinematics):
    rules = Rules("geometric", kinematics)
    values, step = released(law, impacts=DELTA), 1e-4
    whole, seen = curve(law, values, kinematics), 0
    for i, begin, later, _ in restarts(
        law, BLOCK, values, TIME, rules=rules, solver=Solver(1e-10), step=step
    ):
        changed = curve(law, released(law, impacts=DELTA + step * np.eye(len(DELTA))[i]), kinematics)
        assert np.abs(changed[begin:] - later).max() < 1e-8
        assert np.array_equal(changed[:begin], whole[:begin])
        seen += 1
    assert seen == len(DELTA)


def test_an_impact_counts_where_a_side_has_lifted():
    """A block that rings in full contact has no impact."""
    small = {**LAWS["hunt_crossley"], "theta0": 1e-5, "t0": 0.0, "impacts": np.full(4, 0.5)}
    plain = {key: value for key, value in small.items() if key != "impacts"}
    assert np.abs(curve("hunt_crossley", small) - curve("hunt_crossley", plain)).max() == 0
