"""Motions whose rate is multiplied by 1 + δ after each impact."""

import numpy as np
import pytest

from freerock.models.block import Block
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate_fitted, tangents

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


@pytest.mark.parametrize("block", [BLOCK, Block(0.28, 0.07, 5.84, com_offset_m=1e-3)], ids=["even", "off"])
@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("law", LAWS)
def test_derivatives_by_the_rate_after_each_impact_are_quotients(law, kinematics, block):
    rules, solver = Rules("geometric", kinematics), Solver(1e-10)
    values = released(law, impacts=DELTA)

    def motion(held=np.nan):
        rates, passages = np.empty((TIME.size, 3)), np.full((DELTA.size, 5), np.nan)
        passages[:, 4] = held
        theta = simulate_fitted(
            law, block, values, TIME, rules=rules, solver=solver, rates=rates, passages=passages
        )
        return theta, rates, passages

    whole = motion()
    steps = (1e-4, -1e-4) if block.e else (3e-7,)
    found = tangents(law, block, values, TIME, whole, rules=rules, solver=solver, steps=steps)
    columns, depths = np.zeros((2, DELTA.size, TIME.size + DELTA.size)).transpose(0, 2, 1)
    found.by_rates(np.ones(TIME.size), np.zeros(TIME.size), whole[1][:, -1], columns)
    found.by_rates(np.zeros(TIME.size), np.ones(TIME.size), whole[1][:, 1], depths)
    rates = np.abs(whole[2][:, 4])
    assert np.abs(motion(rates)[0] - whole[0]).max() < 1e-9
    for i, step in enumerate(1e-5 * np.eye(DELTA.size)):
        (up, of_up, after_up), (down, of_down, after_down) = (
            motion(rates * (1 + by)) for by in (step, -step)
        )
        of_delta = (after_up - after_down)[:, 3] / 2e-5
        assert columns[TIME.size :, i] == pytest.approx(of_delta, abs=5e-3)
        for column, one, other in ((columns, up, down), (depths, of_up[:, 0], of_down[:, 0])):
            if column is columns or law != "housner":
                central = (one - other) / 2e-5
                off = column[: TIME.size, i] - central
                assert np.linalg.norm(off) < 5e-3 * np.linalg.norm(central)


@pytest.mark.parametrize("law", LAWS)
def test_an_impact_leaves_the_rate_that_is_held(law):
    passages = np.full((4, 5), np.nan)
    passages[:, 4] = held = np.array([1.2, 1.0, 0.9, 0.7])
    theta = simulate_fitted(
        law, BLOCK, released(law, impacts=np.zeros(4)), TIME, solver=Solver(1e-10), passages=passages
    )
    assert np.abs(passages[:, 4]) == pytest.approx(held, rel=1e-9)
    again = curve(law, released(law, impacts=passages[:, 3] - 1))
    assert np.abs(again - theta).max() < 1e-7


def test_each_passage_counts_be_a_side_lifted_or_not():
    """So no impact takes another's δ where the swing before it ceases to lift."""
    small = {**LAWS["hunt_crossley"], "theta0": 1e-5, "t0": 0.0}
    plain, larger = (curve("hunt_crossley", small | {"impacts": each}) for each in (np.zeros(1), np.ones(1)))
    after = int(np.flatnonzero(plain < 0)[0])
    assert np.abs(larger[:after] - plain[:after]).max() < 1e-12
    assert larger[after:].min() == pytest.approx(2 * plain[after:].min(), rel=0.05)
