"""The simulator whose impacts scatter: against golden solutions, closed forms, and its own energies."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import detrend

from freerock.models.contact import Foundation
from freerock.models.published import BLOCKS, RELEASE_ANGLES, TABLE_2
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View
from freerock_bench import realistic
from freerock_bench.golden.files import read_golden
from freerock_bench.rocking import rock
from freerock_bench.scattered import BEAMS_M, RATE_HZ, SIGMA_RAD, make
from freerock_bench.springs import Motion, Scene, energy

NONE = np.zeros(0)
BLOCK, ANGLE = BLOCKS["config2"], RELEASE_ANGLES["config2"]
MARBLE = TABLE_2["marble"]


@pytest.fixture(scope="module")
def golden():
    return read_golden()


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
@pytest.mark.parametrize("block", [*BLOCKS])
def test_beds_are_those_of_the_golden_solutions(block, law, kinematics, golden):
    true = golden[f"{block}_aerstop_{law}_geometric_{kinematics}_free"]
    pivots = kinematics == "pivoting"
    found = rock(BLOCKS[block], TABLE_2["aerstop"][law], RELEASE_ANGLES[block], NONE, pivoting=pivots)
    theta = np.zeros(len(true.time_s) * 20)
    theta[: len(found.theta)] = found.theta[: len(theta)]
    ended = true.time_s > found.time_s[-1]
    assert np.abs(theta[::20] - true.theta_rad)[~ended].max() < 2e-6  # a fiftieth of the noise
    assert np.abs(true.theta_rad[ended]).max(initial=0) < 1.1e-5


def test_a_rigid_block_has_the_impacts_of_its_closed_form():
    """physics.md, section 2."""
    found = rock(BLOCK, {"r": 0.958}, ANGLE, NONE, pivoting=True)
    assert found.passages_s[:5] == pytest.approx([0.26888, 0.71043, 1.09557, 1.44071, 1.75486], abs=1e-5)
    assert np.degrees(np.abs(found.theta)).max() == pytest.approx(10)
    assert found.restitution[:20] == pytest.approx(0.958, abs=1e-6)


def test_each_impact_of_a_rigid_block_has_its_own_restitution():
    deltas = np.array([0.01, -0.02, 0.03])
    found = rock(BLOCK, {"r": 0.95}, -ANGLE, deltas, pivoting=True)
    assert found.deltas[:4].tolist() == [*deltas, 0.0]
    assert found.restitution[:4] == pytest.approx(0.95 * (1 + found.deltas[:4]), abs=1e-6)


def test_an_impact_on_a_bed_changes_the_rate_where_the_block_stands_upright():
    plain = rock(BLOCK, MARBLE["hunt_crossley"], ANGLE, NONE, pivoting=False)
    kicked = rock(BLOCK, MARBLE["hunt_crossley"], ANGLE, np.array([0.0, 0.02]), pivoting=False)
    second = plain.passages_s[1]
    before = plain.time_s < second
    assert (kicked.theta[: before.sum()] == plain.theta[before]).all()
    after = int(second * RATE_HZ) + 2
    assert kicked.theta_rate[after] / plain.theta_rate[after] == pytest.approx(1.02, abs=2e-3)
    assert kicked.restitution[1] / plain.restitution[1] == pytest.approx(1.02, abs=3e-3)


def test_a_base_that_stays_in_contact_has_no_impacts():
    soft = rock(BLOCK, {"k": 3e5, "lambda": 1e7}, math.radians(0.3), np.full(9, 0.5), pivoting=False)
    assert len(soft.passages_s) == 0 and np.abs(soft.theta).max() < math.radians(0.31)


def test_a_hand_that_leaves_slowly_is_a_release_at_half_its_time():
    at_once, slowly = (
        rock(BLOCK, MARBLE["winkler"], ANGLE, NONE, pivoting=True, fade_s=fade) for fade in (0.0, 0.01)
    )
    late = slowly.passages_s[0] - at_once.passages_s[0]
    assert late == pytest.approx(0.005, abs=2e-4)


def test_a_record_is_what_it_says(tmp_path):
    """Its volts, by the true inputs, are the θ(t) of its truth but for noise, hand and converter."""
    record = np.load(make(tmp_path, 0.01, 1, seed=3))
    laser = Laser("horizontal", float(record["stated_position_m"]), 0.1)
    assert laser.position == BEAMS_M["config2"]
    found = find_rotation(np.arange(len(record["volts"])) / RATE_HZ, record["volts"], laser, BLOCK, "V")
    for j, begins in enumerate(record["begins_s"]):
        held = found["theta"].values[int((begins - 1) * RATE_HZ) : int(begins * RATE_HZ)]
        assert held.mean() == pytest.approx(record[f"run{j}_theta0"], rel=0.02)
        upright = np.interp(record[f"run{j}_volts_impacts_s"][:5], found["time"], found["theta"])
        assert np.abs(upright).max() < 0.01 * abs(record[f"run{j}_theta0"])
        assert len(record[f"run{j}_delta"]) == len(record[f"run{j}_r_energy"])
        noise = record[f"run{j}_theta"] - record[f"run{j}_theta_exact"]
        assert noise.std() == pytest.approx(SIGMA_RAD, rel=0.05)
    deltas = np.concatenate([record[f"run{j}_delta"] for j in range(3)])
    assert deltas.std() == pytest.approx(0.01, rel=0.3)


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
def test_two_simulators_agree_on_impacts_that_scatter(kinematics):
    """`springs` has other coordinates, equations and code."""
    pivots, deltas = kinematics == "pivoting", np.array([0.02, -0.01, 0.015, -0.02])
    factors = np.column_stack([1 + deltas, np.ones((4, 2))])
    scene = Scene(BLOCK, MARBLE["hunt_crossley"], pivots, ANGLE, 1e-7, impacts=factors)
    other = Motion(scene, RATE_HZ, 1.8)
    found = rock(BLOCK, MARBLE["hunt_crossley"], ANGLE, deltas, pivoting=pivots)
    n = 3500
    assert np.abs(found.theta[:n] - other.theta[:n]).max() < 1e-6
    assert found.passages_s[:4] == pytest.approx(other.passages_s[:4], abs=1e-6)
    swings = pairwise((found.passages_s[:4] * RATE_HZ).astype(int))
    tops = [i + int(np.argmax(np.abs(found.theta[i:j]))) for i, j in swings]
    energies = energy(other.states[:, tops], scene) - energy(other.stands[:, None], scene)
    assert np.sqrt(energies[1:] / energies[:-1]) == pytest.approx(found.restitution[1:3], abs=2e-5)


@pytest.mark.slow
def test_a_realistic_record_has_its_truth(tmp_path):
    record = np.load(realistic.make(tmp_path, 5, seed=2))
    laser = Laser("horizontal", float(record["stated_position_m"]), 0.1)
    block = BLOCKS["config3"]
    found = find_rotation(np.arange(len(record["volts"])) / RATE_HZ, record["volts"], laser, block, "V")
    for j, begins in enumerate(record["begins_s"]):
        held = found["theta"].values[int(begins * RATE_HZ) - 2000 :][:1800]
        angle = View(block, laser).released(held.mean(), block, Foundation(float(record["edge_k"])))
        assert angle == pytest.approx(record[f"run{j}_theta0"], rel=0.04)  # edges are rounded besides
        trembles = detrend(held.reshape(-1, 20).mean(axis=1))
        assert trembles.std() == pytest.approx(math.radians(0.01), rel=0.5)
        r = record[f"run{j}_volts_r_energy"]
        assert 0.4 < r.min() < r.max() < 0.9 and np.diff(np.sign(record[f"run{j}_tops"])).all()
