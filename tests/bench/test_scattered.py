"""Records whose impacts scatter and their truth, against golden solutions, closed forms and energies."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import detrend

from freerock.models.laws import Foundation
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View
from freerock.virtual_lab.published import BLOCKS, RELEASE_ANGLES, TABLE_2
from freerock_bench import realistic
from freerock_bench.golden.files import read_golden
from freerock_bench.scattered import BEAMS_M, RATE_HZ, SIGMA_RAD, make
from freerock_bench.springs import Motion, Scene, restitution_of

pytestmark = pytest.mark.usefixtures("springs")

AT_ONCE_S = 1e-7
BLOCK, ANGLE = BLOCKS["config2"], RELEASE_ANGLES["config2"]
MARBLE = TABLE_2["marble"]


def rock(block, law, angle, deltas=(), pivoting=True, longest_s=60.0):
    impacts = np.column_stack([1 + np.array([*deltas], float), *np.ones((2, len(deltas)))])
    scene = Scene(block, dict(law), pivoting, angle, AT_ONCE_S, impacts=impacts)
    return Motion(scene, RATE_HZ, longest_s)


@pytest.fixture(scope="module")
def golden():
    return read_golden()


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
@pytest.mark.parametrize("block", [*BLOCKS])
def test_beds_are_those_of_the_golden_solutions(block, law, kinematics, golden):
    true = golden[f"{block}_aerstop_{law}_geometric_{kinematics}_free"]
    of_block = BLOCKS[block], TABLE_2["aerstop"][law], RELEASE_ANGLES[block]
    found = rock(*of_block, (), kinematics == "pivoting", true.time_s[-1])
    theta = np.zeros(len(true.time_s) * 20)
    theta[: found.theta.size] = found.theta[: len(theta)]
    ended = true.time_s > found.theta.size / RATE_HZ
    assert np.abs(theta[::20] - true.theta_rad)[~ended].max() < 5e-6  # a twentieth of the noise
    assert np.abs(true.theta_rad[ended]).max(initial=0) < 2.1e-5


def test_a_rigid_block_has_the_impacts_of_its_closed_form():
    """physics.md, section 2."""
    passages_s, restitution = restitution_of(rock(BLOCK, {"r": 0.958}, ANGLE))
    assert passages_s[:5] == pytest.approx([0.26888, 0.71043, 1.09557, 1.44071, 1.75486], abs=1e-5)
    assert restitution[:20] == pytest.approx(0.958, abs=1e-6)


def test_each_impact_of_a_rigid_block_has_its_own_restitution():
    deltas = np.array([0.01, -0.02, 0.03])
    found = rock(BLOCK, {"r": 0.95}, -ANGLE, deltas)
    assert restitution_of(found)[1][:4] == pytest.approx(0.95 * (1 + np.array([*deltas, 0.0])), abs=1e-9)
    plain = rock(BLOCK, {"r": 0.95}, -ANGLE)
    tops = [np.abs(each.theta[int(each.passages_s[0] * RATE_HZ) + 1 :]).max() for each in (found, plain)]
    fallen = [math.cos(BLOCK.theta_cr - top) - math.cos(BLOCK.theta_cr) for top in tops]
    assert math.sqrt(fallen[0] / fallen[1]) == pytest.approx(1.01, abs=1e-5)


def test_an_impact_on_a_bed_changes_the_energy_that_is_left():
    law, longest_s = MARBLE["hunt_crossley"], 2.0
    plain, kicked = (rock(BLOCK, law, ANGLE, each, False, longest_s) for each in ((), (0.0, 0.02)))
    before = int(plain.passages_s[1] * RATE_HZ)
    assert (kicked.theta[:before] == plain.theta[:before]).all()
    one, other = restitution_of(plain)[1], restitution_of(kicked)[1]
    assert other[0] == pytest.approx(one[0], abs=1e-9)
    assert other[1] / one[1] == pytest.approx(1.02, abs=3e-3)


def test_a_base_that_stays_in_contact_has_no_impacts():
    soft = rock(BLOCK, {"k": 3e5, "lambda": 1e7}, math.radians(0.3), np.full(9, 0.5), False)
    assert len(soft.passages_s) == 0 and np.abs(soft.theta).max() < math.radians(0.31)


def test_a_hand_that_leaves_slowly_is_a_release_at_half_its_time():
    at_once = rock(BLOCK, MARBLE["winkler"], ANGLE, longest_s=1.0)
    slowly = Motion(replace(at_once.scene, fade_s=0.01), RATE_HZ, 1.0)
    assert slowly.passages_s[0] - at_once.passages_s[0] == pytest.approx(0.005, abs=2e-4)


def test_a_record_is_what_it_says(tmp_path):
    """Its volts, by the true inputs, are the θ(t) of its truth but for noise and converter."""
    record = np.load(make(tmp_path, 0.01, 1, seed=3, at_once=True))
    laser = Laser("horizontal", float(record["stated_position_m"]), 0.1)
    assert laser.position == BEAMS_M["config2"]
    found = find_rotation(np.arange(len(record["volts"])) / RATE_HZ, record["volts"], laser, BLOCK, "V")
    for j, begins in enumerate(record["begins_s"]):
        held = found["theta"].values[int((begins - 1) * RATE_HZ) : int(begins * RATE_HZ)]
        assert held.mean() == pytest.approx(record[f"run{j}_theta0"], rel=0.02)
        upright = np.interp(record[f"run{j}_volts_impacts_s"][:5], found["time"], found["theta"])
        assert np.abs(upright).max() < 0.01 * abs(record[f"run{j}_theta0"])
        read = found["theta"].values[int(begins * RATE_HZ) :][:2000]
        assert np.abs(read - record[f"run{j}_theta"][:2000]).max() < 0.02 * abs(record[f"run{j}_theta0"])
        last = record[f"run{j}_theta"][-50:]
        assert last.std() == pytest.approx(SIGMA_RAD, rel=0.5)
    deltas = np.concatenate([record[f"run{j}_delta"] for j in range(3)])
    assert deltas.std() == pytest.approx(0.01, rel=0.3)


def test_a_realistic_record_has_its_truth(tmp_path, monkeypatch):
    monkeypatch.setattr(realistic, "RUNS", 2)
    monkeypatch.setattr(realistic, "Motion", lambda scene, rate_hz, _: Motion(scene, rate_hz, 3.0))
    record = np.load(realistic.make(tmp_path, 4))
    laser = Laser("horizontal", float(record["stated_position_m"]), 0.1)
    block = BLOCKS["config2"]
    found = find_rotation(np.arange(len(record["volts"])) / RATE_HZ, record["volts"], laser, block, "V")
    for j, begins in enumerate(record["begins_s"]):
        held = found["theta"].values[int(begins * RATE_HZ) - 2000 :][:1800]
        angle = View(block, laser).released(held.mean(), block, Foundation(float(record[f"run{j}_k"])))
        assert angle == pytest.approx(record[f"run{j}_theta0"], rel=0.04)  # edges are rounded besides
        trembles = detrend(held.reshape(-1, 20).mean(axis=1))
        assert trembles.std() == pytest.approx(math.radians(0.01), rel=0.5)
        r = record[f"run{j}_volts_true_r"]
        assert 0.4 < r.min() < r.max() < 0.9
