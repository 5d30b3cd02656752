"""What `freerock check` doubts: angles, rates and units, of records on which no threshold was set."""

import math
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, RootObject, TdmsWriter

from freerock.cli.check_command import check_config
from freerock.models.block import Block
from freerock.models.simulate import simulate

YAML = """\
title: Blocks
origin: simulated
blocks:
  tall: {height_m: 1.2, width_m: 0.25, mass_kg: 150, release_angle_deg: 7}
foundations:
  floor: {}
lasers:
  near: {beam: horizontal, position_m: 1.0, range_m: 0.5}
"""
CSV = "test,file,channel,block,foundation,laser\na,a.tdms,,tall,floor,near\n"
CRITICAL_DEG = math.degrees(math.atan2(0.25, 1.2))


def swings(rate_hz=500.0, theta0_deg=7.0):
    """Volts of a laser 1 m above the base that watches a held block, its release and its rocking."""
    block = Block(1.2, 0.25, 150)
    time_s = np.arange(0, 8, 1 / rate_hz)
    theta = simulate("housner", block, {"r": 0.92}, time_s, theta0=math.radians(theta0_deg)).theta
    held = np.full(int(2 * rate_hz), theta[0])
    return 5 + np.tan(np.concatenate([held, theta])) * 1.0 / 0.5 * 10


@pytest.fixture
def doubts(tmp_path, monkeypatch):
    """The function that writes a campaign, changed, and gives what is doubted of it."""
    monkeypatch.chdir(tmp_path)
    Path("config/campaigns").mkdir(parents=True)
    Path("raw/lab").mkdir(parents=True)

    def doubts(*changes, volts=None, step=0.002, unit="V", csv=CSV, title=""):
        yaml = YAML
        for old, new in changes:
            assert old in yaml
            yaml = yaml.replace(old, new)
        Path("config/config.yaml").write_text("campaigns: [lab]\n")
        Path("config/campaigns/lab.yaml").write_text(yaml)
        Path("config/campaigns/lab.csv").write_text(csv)
        with TdmsWriter("raw/lab/a.tdms") as writer:
            properties = {"wf_increment": step, "wf_start_offset": 0.0, "unit_string": unit}
            samples = swings() if volts is None else volts
            writer.write_segment(
                [RootObject({"title": title}), ChannelObject("g", "laser", samples, properties)]
            )
        sound, problems, found = check_config()
        assert (problems, len(sound)) == ([], 1)
        return [str(each) for each in found]

    return doubts


def test_a_usual_record_is_not_doubted(doubts):
    assert doubts() == []
    assert doubts(("release_angle_deg: 7", "release_angle_deg: 8.5")) == []
    assert doubts(("release_angle_deg: 7", "release_angle_deg: 1"), volts=swings(theta0_deg=1.0)) == []


def test_a_measured_campaign_is_asked_whether_its_base_is_level(doubts):
    measured = ("origin: simulated", "origin: measured")
    assert doubts(measured) == [
        "config/campaigns/lab.yaml:6: foundations.floor: has no levelled_deg, and a tilt of a "
        "tenth of a degree changes k; level its base in the plane of rocking, and state levelled_deg"
    ]
    assert doubts(measured, ("floor: {}", "floor: {levelled_deg: 0.02}")) == []


def test_radians_for_degrees(doubts):
    angle, record = doubts(("release_angle_deg: 7", "release_angle_deg: 0.122"))
    assert angle == (
        "config/campaigns/lab.yaml:4: blocks.tall: a release angle of 0.122° is 1 % of the critical angle, "
        "in radians it would be 6.99°; give it in degrees"
    )
    assert record.startswith("config/campaigns/lab.csv:2: a: the signal sweeps 1")
    assert record.endswith(
        "°, the block's release_angle_deg is 0.122; is that in degrees, and the unit of the channel right?"
    )


UNITS = {
    "a rotation in radians, said to be degrees": ("{units: deg}", 1.0, "rad"),
    "a rotation in degrees, said to be radians": ("{units: rad}", math.degrees(1), "deg"),
}


@pytest.mark.parametrize("case", UNITS)
def test_rotations_in_another_unit(doubts, case):
    laser, factor, _ = UNITS[case]
    theta = np.arctan((swings() - 5) * 0.05) * factor
    (doubt,) = doubts(("{beam: horizontal, position_m: 1.0, range_m: 0.5}", laser), volts=theta, unit="")
    assert "a: the signal sweeps " in doubt
    assert doubt.endswith(
        f"°, the critical angle is {CRITICAL_DEG:.3g}°; are its unit and the laser's scale right?"
    )


@pytest.mark.parametrize(
    ("changes", "volts", "unit"),
    [
        ([], 1e-3, "V"),  # thousandths of volts
        ([("range_m: 0.5", "range_m: 500")], 1, "V"),  # millimetres
        ([("position_m: 1.0, range_m: 0.5", "position_m: 1.0")], 500 / 10, "m"),  # the same
    ],
)
def test_distances_in_another_unit(doubts, changes, volts, unit):
    (doubt,) = doubts(*changes, volts=swings() * volts, unit=unit)
    assert "a: the signal sweeps " in doubt and "the critical angle is 11.8°" in doubt


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("mass_kg: 150", "mass_kg: 0.0002"),
        ("height_m: 1.2, width_m: 0.25", "height_m: 100, width_m: 25"),
        ("height_m: 1.2, width_m: 0.25", "height_m: 0.0012, width_m: 0.00025"),
    ],
)
def test_blocks_of_an_impossible_density_are_refused(doubts, old, new):
    doubts()
    yaml = Path("config/campaigns/lab.yaml")
    yaml.write_text(
        yaml.read_text().replace(old, new).replace("release_angle_deg: 7", "release_angle_deg: 5")
    )
    _, (problem, *_), _ = check_config()
    assert problem.where == "config/campaigns/lab.yaml:4: blocks.tall.mass_kg"
    assert problem.what.startswith("as deep as it is high, the block would have")
