"""What the laboratory knows: the same readings with other inputs, and what the configuration says of them."""

import math

import numpy as np
import pytest
from laboratory import CSV, YAML, problems

from freerock.config.campaign import load_campaign
from freerock.config.step_settings import laboratory as laboratory_settings
from freerock.models.block import Block
from freerock.models.laws import Foundation
from freerock.rotation.beam import displacement_from_rotation
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.view import view_of

BLOCK = Block(0.28, 0.07, 5.84)
HIGH, LOW = Laser("horizontal", 0.2, 0.1), Laser("horizontal", 0.1, 0.1)
THETA = np.radians([-10.0, -1.0, 0.0, 2.0, 9.0])


def test_a_higher_beam_makes_of_its_reading_a_smaller_angle():
    laboratory = Laboratory(BLOCK, {"high": HIGH})
    moved = laboratory.moved({Input("high", "position_m", 1e-3, True): 2.0})
    assert moved.lasers["high"].position_m == pytest.approx(0.202)
    theta = laboratory.reread(THETA, moved)
    np.testing.assert_allclose(
        displacement_from_rotation(theta, BLOCK, moved.lasers["high"]),
        displacement_from_rotation(THETA, BLOCK, HIGH),
        atol=1e-15,
    )
    assert theta[3] == pytest.approx(THETA[3] * 0.2 / 0.202, rel=1e-3)


def test_what_one_laboratory_sees_is_reread_by_another_at_once():
    """A corner that sinks under a beam, read by a moved laser, then as stated: one pass or two."""
    stated, bed, depth = Laboratory(BLOCK, {"high": HIGH}), Foundation(6.9e6, 0.0, 1.3e8), np.full(5, 2e-4)
    higher, larger = Input("high", "position_m", 1e-3, True), Input("high", "scale_fraction", 1e-2, True)
    moved = stated.moved({higher: 1.3, larger: -0.7})
    view = view_of(moved.lasers["high"], BLOCK)
    two = moved.reread(view.seen(THETA[None], depth[None], BLOCK, bed), stated)
    one = view.seen(THETA[None], depth[None], BLOCK, bed, by=moved.read_by(stated))
    np.testing.assert_allclose(one, two, atol=1e-14)
    assert np.abs(one - THETA).max() > 1e-3


def test_two_lasers_know_the_angle_by_the_distance_of_their_beams():
    laboratory = Laboratory(BLOCK, {"high": HIGH, "low": LOW})
    theta = laboratory.reread(THETA, laboratory.moved({Input("low", "position_m", 1e-3, True): 1.0}))
    np.testing.assert_allclose(np.tan(theta), np.tan(THETA) * 0.1 / 0.099, rtol=1e-9)
    second = laboratory.reread(THETA, laboratory.moved({Input("low", "scale_fraction", 0.01, True): 1.0}))
    s = displacement_from_rotation(THETA, BLOCK, HIGH), displacement_from_rotation(THETA, BLOCK, LOW)
    np.testing.assert_allclose(np.tan(second), (s[0] - 1.01 * s[1]) / 0.1, atol=1e-12)


def of_record(folder, old, new):
    """Inputs of the only record of a campaign whose YAML was changed, by name."""
    (folder / "lab.yaml").write_text(YAML.replace(old, new))
    (folder / "lab.csv").write_text(CSV)
    lab = load_campaign(folder / "lab.yaml")
    return {each["name"]: each for each in laboratory_settings(lab, lab.records[0].scene)["inputs"]}


def test_inputs_are_stated_or_defaults(tmp_path):
    known = of_record(tmp_path, "5.84", "5.84\n    uncertainty: {width_m: 0.00003}")
    assert (known["width_m"]["u"], known["width_m"]["stated"]) == (3e-5, True)
    assert (known["height_m"]["u"], known["height_m"]["stated"]) == (3e-4, False)
    assert known["mass_kg"]["u"] == pytest.approx(0.00584)
    assert {"position_m", "scale_fraction", "sampling_rate_fraction"} <= set(known)
    assert "levelled_deg" not in known and "contact_width_m" not in known
    assert known["com_height_m"]["u"] == 3e-4 and not known["com_height_m"]["stated"]
    assert known["inertia_kg_m2"]["u"] == pytest.approx(5e-3 * BLOCK.inertia_cm)
    assert "com_offset_m" not in known  # a tilt, which fits look for, does the same
    assert of_record(tmp_path, "5.84", "5.84\n    com_offset_m: 0.001")["com_offset_m"]["u"] == 3e-4
    stated = of_record(tmp_path, "5.84", "5.84\n    uncertainty: {com_offset_m: 0.002}")["com_offset_m"]
    assert (stated["u"], stated["stated"]) == (2e-3, True)


def test_a_levelled_base_lies_evenly_within_its_bound(tmp_path):
    known = of_record(tmp_path, "marble: {}", "marble: {levelled_deg: 0.03}")
    assert known["levelled_deg"]["u"] == pytest.approx(0.03 / math.sqrt(3))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "5.84",
            "5.84\n    uncertainty: {contact_width_m: 0.001}",
            "lab.yaml:8: blocks.tall.uncertainty: states the uncertainty of a contact_width_m that is "
            "not given; "
            "give contact_width_m beside, or remove it",
        ),
        (
            "{beam: horizontal, position_m: 0.1, range_m: 0.05}",
            "{units: deg, uncertainty: {position_m: 0.001}}",
            "lab.yaml:11: lasers.near.uncertainty: states the uncertainty of a position_m that is not given; "
            "remove it: the channel is the rotation",
        ),
        (
            "5.84",
            "5.84\n    uncertainty: {height_m: -1}",
            "lab.yaml:8: blocks.tall.uncertainty.height_m: -1 is not greater than or equal to 0; "
            "give the uncertainty of its height in metres; by default 0.0003 (a rule, 1 mm/√12)",
        ),
    ],
)
def test_an_uncertainty_that_means_nothing_is_refused(tmp_path, monkeypatch, old, new, message):
    monkeypatch.chdir(tmp_path)
    assert problems((old, new)) == [message]
