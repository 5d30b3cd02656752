"""Motions of the studies by integrations of their own, against the models where these know the case."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.models.contact import Foundation, energy
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate, simulate_theta
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.imperfect import base_of, on_bed, rigid, tops_on_bed

TIME_S = np.arange(0.0, 2.0, 1 / 2000)
CLOSE = math.radians(0.006) / 10  # a tenth of the noise
CASES = [("config1", "marble"), ("config3", "aerstop")]


def of_law(block, soil, theta0, **options):
    return simulate_theta(
        "hunt_crossley", block, soil, TIME_S, theta0=theta0, solver=Solver(1e-10), **options
    )[0]


@pytest.mark.parametrize(("configuration", "foundation"), CASES)
def test_with_nothing_besides_it_is_the_law(configuration, foundation):
    (block, theta0, _), soil = CONFIGURATIONS[configuration], FOUNDATIONS[foundation]
    np.testing.assert_allclose(
        on_bed(block, soil, theta0, TIME_S), of_law(block, soil, theta0), rtol=0, atol=CLOSE
    )


@pytest.mark.parametrize(("configuration", "foundation"), CASES)
def test_rounded_edges_and_a_bed_that_does_not_pull_are_those_of_the_models(configuration, foundation):
    (block, theta0, _), soil = CONFIGURATIONS[configuration], FOUNDATIONS[foundation]
    rounded = on_bed(block, soil, theta0, TIME_S, base={"radius_m": 2e-3})
    known = of_law(replace(block, edge_radius_m=2e-3), soil, theta0)
    np.testing.assert_allclose(rounded, known, rtol=0, atol=10 * CLOSE)
    loose = on_bed(block, soil, theta0, TIME_S, tensionless=1.0)
    known = of_law(block, soil, theta0, rules=Rules("tensionless"))
    np.testing.assert_allclose(loose, known, rtol=0, atol=2 * CLOSE)


def test_a_base_that_can_hardly_slip_is_guided_and_one_that_slips_is_not():
    block, theta0, _ = CONFIGURATIONS["config2"]
    soil = FOUNDATIONS["marble"]
    guided = on_bed(block, soil, theta0, TIME_S)
    stuck = on_bed(block, soil, theta0, TIME_S, grip=1e3, side_k=1e8)
    loose = on_bed(block, soil, theta0, TIME_S, grip=0.1)
    assert np.abs(stuck - guided).max() < 20 * CLOSE < np.abs(loose - guided).max()


def test_what_takes_energy_ends_the_motion_sooner():
    block, theta0, _ = CONFIGURATIONS["config2"]
    soil = FOUNDATIONS["aerstop"]
    late = TIME_S > 1.5
    least = np.abs(on_bed(block, soil, theta0, TIME_S)[late]).max()
    for more in ({"friction_nm": 5e-3}, {"air_nms2": 5e-3}):
        assert np.abs(on_bed(block, soil, theta0, TIME_S, **more)[late]).max() < 0.99 * least


def test_a_mass_off_centre_leans_to_its_side():
    block, _, _ = CONFIGURATIONS["config2"]
    soil = FOUNDATIONS["aerstop"]
    off = on_bed(block, soil, 0.05, TIME_S, off_m=1e-3)
    mirrored = on_bed(block, soil, -0.05, TIME_S, off_m=-1e-3)
    np.testing.assert_allclose(off, -mirrored, atol=1e-12)
    assert np.mean(off > 0) > np.mean(on_bed(block, soil, 0.05, TIME_S) > 0)  # longer on its own side


def test_cells_of_a_base():
    block, _, _ = CONFIGURATIONS["config2"]
    u, half, height, _, touches = base_of(block, feet=0.3, hollow_m=1e-4).T
    assert 2 * half.sum() == pytest.approx(2 * block.b)
    np.testing.assert_array_equal(touches, np.abs(u) >= 0.3 * block.b)
    assert height.max() == pytest.approx(1e-4, rel=1e-2) and height[0] == pytest.approx(0, abs=1e-7)


def test_a_rigid_block_is_housners():
    block, theta0, _ = CONFIGURATIONS["config2"]
    theta, impacts = rigid(block, lambda rate: 0.95, theta0, TIME_S)
    known = simulate_theta("housner", block, {"r": 0.95}, TIME_S, theta0=theta0)[0]
    np.testing.assert_allclose(theta, known, rtol=0, atol=CLOSE)
    assert np.all(impacts[:, 1] == 0.95) and np.all(np.diff(np.abs(impacts[:5, 0])) < 0)


def test_restitution_by_the_side_is_told_the_sign_of_the_rate():
    block, theta0, _ = CONFIGURATIONS["config2"]
    _, impacts = rigid(block, lambda rate: 0.95 + math.copysign(0.01, rate), theta0, TIME_S)
    np.testing.assert_allclose(impacts[:, 1], 0.95 + 0.01 * np.sign(impacts[:, 0]))
    assert set(np.sign(impacts[:4, 0])) == {-1.0, 1.0}


@pytest.mark.parametrize(("configuration", "foundation"), CASES)
def test_tops_have_the_energies_of_the_law_where_nothing_is_besides(configuration, foundation):
    (block, theta0, _), soil = CONFIGURATIONS[configuration], FOUNDATIONS[foundation]
    theta, impacts, heights, energies = tops_on_bed(block, soil, theta0, TIME_S)
    np.testing.assert_array_equal(theta, on_bed(block, soil, theta0, TIME_S))
    assert len(heights) == len(energies) == len(impacts) + 1
    law = simulate("hunt_crossley", block, soil, TIME_S, theta0=theta0, solver=Solver(1e-10))
    state = law.z_cb, law.z_cb_rate, law.theta, law.theta_rate
    left = energy(block, Foundation.of(soil), *state)
    assert energies[0] == pytest.approx(left[0], rel=1e-4)
    first, second = np.searchsorted(TIME_S, impacts[:2])
    top = first + np.argmax(np.abs(law.theta[first:second]))
    assert energies[1] == pytest.approx(left[top], rel=1e-3)
    assert heights[1] == pytest.approx(abs(law.theta[top]), abs=CLOSE)


@pytest.mark.parametrize(
    "differs",
    [
        {"power": 0.2, "middle_m": 1e-4},
        {"base": {"hollow_m": 5e-5}},
        {"base": {"radius_m": 2e-3}},
        {"base": {"feet": 0.3}},
        {"off_m": 4e-4},
    ],
)
def test_a_bed_without_damping_gives_all_energy_back(differs):
    block, theta0, _ = CONFIGURATIONS["config2"]
    soil = {"k": FOUNDATIONS["aerstop"]["k"], "lambda": 0.0}
    _, impacts, heights, energies = tops_on_bed(block, soil, theta0, TIME_S[TIME_S < 1.2], **differs)
    assert len(impacts) > 1 and np.ptp(heights[:-1]) > 0
    assert energies[:-1] == pytest.approx(energies[0], rel=3e-3)
