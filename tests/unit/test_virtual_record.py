import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from freerock.files import check_file, listed_checksums
from freerock.models.block import Block
from freerock.models.block_on_bed import static_depth
from freerock.models.laws import GEOMETRIC, Foundation
from freerock.noise.still_phases import stationary_phases
from freerock.records.read import read_record
from freerock.rotation.beam import displacement_from_rotation, rotation_from_displacement
from freerock.rotation.flags import FLAGS
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.added_noise import AddedNoise
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS, palermo_records, palermo_releases
from freerock.virtual_lab.virtual_record import Recording, VirtualRelease, simulate_record
from freerock.virtual_lab.write_tdms import write_records

CAMPAIGN = Path(__file__).parents[2] / "raw" / "palermo_virtual"
TESTS = [f"{block}_{foundation}" for block in CONFIGURATIONS for foundation in FOUNDATIONS]
BLOCK, _, LASER = CONFIGURATIONS["config2"]
SILENT = Recording(noise=AddedNoise(white_v=0.0, mains_v=0.0, drift_v=0.0))
MARBLE = FOUNDATIONS["marble"]


@pytest.fixture(scope="module")
def truth():
    return json.loads((CAMPAIGN / "truth.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def records():
    return dict(palermo_records())


def one(theta0=0.17, parameters=MARBLE, model="hunt_crossley", faults=(), rules=GEOMETRIC, **release):
    """A record of one release without noise."""
    how = [VirtualRelease(theta0, parameters, **release)]
    return simulate_record(BLOCK, LASER, model, how, seed=1, recording=SILENT, faults=faults, rules=rules)


def test_campaign_is_regenerated_bit_for_bit(records, tmp_path):
    write_records(tmp_path, records.items())
    names = sorted(path.name for path in CAMPAIGN.iterdir() if path.name != "README.md")
    assert names == sorted(path.name for path in tmp_path.iterdir())
    assert names == sorted([f"{test}.tdms" for test in TESTS] + ["manifest.csv", "truth.json"])
    for name in names:
        assert (tmp_path / name).read_bytes() == (CAMPAIGN / name).read_bytes(), name
    for name, listed in listed_checksums(CAMPAIGN).items():
        check_file(CAMPAIGN, name, listed)
    assert sum((CAMPAIGN / name).stat().st_size for name in names) < 4e6


def seen_at_rest(run, block, laser):
    """A held angle [rad] as the beam shows it: it meets the block higher by the depth of the corner (F32)."""
    theta = run["theta0_rad"]
    sunk = static_depth(block, Foundation(run["k"]), theta) + block.b * abs(math.sin(theta))
    higher = replace(laser, position_m=laser.position + sunk)
    return float(rotation_from_displacement(displacement_from_rotation(theta, block, higher), block, laser))


@pytest.mark.parametrize("test", TESTS)
def test_rotation_of_a_record_is_as_exact_as_it_says(test, truth):
    known = truth[test]
    volts = read_record(CAMPAIGN / f"{test}.tdms", "laser")["laser"]
    block, laser = Block(**known["block"]), Laser(**known["laser"])
    assert (block, laser) == CONFIGURATIONS[test.split("_")[0]][::2]
    found = find_rotation(volts["time"], volts, laser, block)

    blocked = np.zeros(volts.size, bool)
    for start, end in (span for run in known["runs"] for span in run["blocked_s"]):
        blocked |= ((volts["time"] >= start) & (volts["time"] < end)).values
    np.testing.assert_array_equal(found["flags"], np.where(blocked, FLAGS["error_level"], 0))
    assert math.radians(0.005) < found["sigma_theta"].max() < math.radians(0.02)
    assert found.attrs["noise_v"] == pytest.approx(known["noise"]["white_v"], rel=0.02)
    assert found.attrs["mains_hz"] == pytest.approx(known["noise"]["mains_hz"], abs=2e-3)
    assert found.attrs["mains_amplitude_v"] == pytest.approx(known["noise"]["mains_v"], rel=0.1)

    phases = stationary_phases(volts["time"], found["theta"])
    assert [phase.kind for phase in phases] == ["rest", "held"] * 3 + ["rest"]
    assert phases[0].level == pytest.approx(0, abs=5 * found.attrs["zero_stderr_rad"])
    for run, held, rest in zip(known["runs"], phases[1::2], phases[2::2], strict=True):
        assert held.end_s == pytest.approx(run["release_s"], abs=0.06)
        assert held.level == pytest.approx(seen_at_rest(run, block, laser), abs=5 * held.level_stderr)
        assert run["impacts_s"][0] < rest.start_s < run["rest_s"]


@pytest.mark.parametrize("test", TESTS)
def test_scores_against_truth_have_unit_variance(test, records):
    record = records[test]
    block, _, laser = CONFIGURATIONS[test.split("_")[0]]
    found = find_rotation(record.time_s, record.volts, laser, block)
    score = (found["theta"] - record.seen) / found["sigma_theta"]
    assert score.var().item() == pytest.approx(1, abs=0.03)
    assert abs(score.mean().item()) < 0.05


def test_volts_invert_to_the_motion():
    record = one()
    displacement = (record.volts - 5.0) * LASER.metres_per()
    theta = rotation_from_displacement(displacement, BLOCK, LASER)
    one_count = record.volts_per_count * LASER.metres_per() / 0.19
    assert np.abs(theta - record.seen).max() <= one_count


def test_overturned_block_leaves_the_beam():
    record = one(math.radians(13.9), {"k": 2e5, "lambda": 1e7})
    assert record.truth["runs"][0]["outcome"] == "overturned"
    assert record.volts[-1] == pytest.approx(10.2, abs=1e-6)


def test_a_sinking_corner_reads_as_a_higher_beam():
    angle, silent = 0.15, AddedNoise(white_v=0.0, mains_v=0.0, drift_v=0.0, bits=32)
    volts = simulate_record(
        BLOCK,
        LASER,
        "hunt_crossley",
        [VirtualRelease(angle, MARBLE, fade_s=0.0)],
        seed=1,
        recording=Recording(noise=silent),
    ).volts
    seen = float(rotation_from_displacement((volts[9000] - 5) / 100, BLOCK, LASER))
    depth = static_depth(BLOCK, Foundation.of(MARBLE), angle) + BLOCK.b * math.sin(angle)
    assert seen / angle - 1 == pytest.approx(depth / LASER.position, rel=0.1)


def test_an_impact_that_scatters_is_followed_by_a_swing_of_its_rate():
    """Energy is ½ω² at the impact: a rate smaller by half a per cent lowers the next peak by about 1 %."""
    plain, moved = (one(fade_s=0.0, impacts=impacts) for impacts in ((), (-0.005, 0.0)))
    assert "impact_factors" not in plain.truth["runs"][0]
    assert moved.truth["runs"][0]["impact_factors"] == [0.995, 1.0]
    first, second = plain.truth["runs"][0]["impacts_s"][:2]
    assert moved.truth["runs"][0]["impacts_s"][0] == first
    swing = (plain.time_s > first) & (plain.time_s < second)
    peaks = [np.abs(each.theta[: swing.size][swing[: each.theta.size]]).max() for each in (plain, moved)]
    assert peaks[1] < 0.995 * peaks[0]


def test_scattering_impacts_of_a_campaign_are_seeded_and_leave_all_else():
    generators = [np.random.RandomState(3) for _ in range(3)]
    plain, one_way, again = (
        palermo_releases(0.17, MARBLE, generator, number=1, sigma_r=sigma_r)[0]
        for generator, sigma_r in zip(generators, (0.0, 0.02, 0.02), strict=True)
    )
    assert one_way == again and plain == replace(one_way, impacts=())
    assert np.std(one_way.impacts) == pytest.approx(0.02, rel=0.2)
