"""Quantities, calibrations and pairs of lasers: the same motion, however it was measured."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.processing import RotationOptions
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.beam import displacement_from_rotation
from freerock.rotation.flags import listed_faults
from freerock.rotation.rotation import _swing_sides, find_rotation
from freerock.rotation.sensor import Calibration, Laser
from freerock.runs.runs import find_runs

BLOCK = Block(0.28, 0.07, 5.84)
HIGH, LOW = Laser("horizontal", 0.2, 0.1), Laser("horizontal", 0.08, 0.1)
RATE = 1000.0
TIME = np.arange(0, 14, 1 / RATE)


def motion(release_deg=8.0):
    """Rest, tilt by hand, hold until 6 s, a decaying swing about zero, rest: θ [rad]."""
    t = np.maximum(TIME - 6.0, 0)
    tilt = np.clip((TIME - 2.5) / 1.5, 0, 1)
    swing = np.exp(-1.5 * t) * np.cos(2 * np.pi * (1.1 + 0.4 * t) * t)
    return math.radians(release_deg) * np.where(TIME > 6.0, swing, tilt**2 * (3 - 2 * tilt))


THETA = motion()


def noise(seed, scale):
    return scale * np.random.default_rng(seed).standard_normal(TIME.size)


def volts(laser=HIGH, seed=1, scale=0.002, shift_m=0.0):
    s = displacement_from_rotation(THETA, BLOCK, laser) + shift_m
    return 5 + s / laser.metres_per() + noise(seed, scale)


def score(found):
    return ((found.theta - THETA) / found.sigma_theta).values


def names(found):
    return [fault.name for fault in listed_faults(found)]


MILLIAMPS = 12 + displacement_from_rotation(THETA, BLOCK, HIGH) / 0.1 * 16 + noise(2, 0.003)
TABLE = Calibration("voltage", (0.0, 4.0, 10.0), (0.0, 0.04, 0.1))
QUANTITIES = {
    "current": (replace(HIGH, units="mA"), MILLIAMPS, "mA"),
    "sensitivity": (replace(HIGH, range_m=None, sensitivity_per_mm=0.1), volts(), "V"),
    "calibration": (replace(HIGH, range_m=None, calibration=TABLE), volts(), ""),
    "millivolts": (replace(HIGH, units="mV"), 1e3 * volts(), ""),
    "displacement": (
        Laser("horizontal", 0.2, units="mm"),
        1e3 * displacement_from_rotation(THETA, BLOCK, HIGH) + noise(3, 0.02),
        "mm",
    ),
    "rotation": (Laser(units="deg"), np.degrees(THETA) + 0.3 + noise(4, 0.005), "deg"),
    "anticlockwise": (Laser(units="rad", sign=-1), -THETA + noise(5, 1e-4), "rad"),
}


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_same_motion_in_any_quantity(quantity):
    laser, signal, stated = QUANTITIES[quantity]
    found = find_rotation(TIME, signal, laser, BLOCK, None if stated == "" else stated)
    assert score(found).var() == pytest.approx(1, abs=0.04)
    assert abs(score(found).mean()) < 0.1
    assert names(found) == []
    recorded = {"millivolts": "voltage", "sensitivity": "voltage", "calibration": "voltage"}
    assert recorded.get(quantity, "rotation" if quantity == "anticlockwise" else quantity) in found


@pytest.mark.parametrize("scale", [{"range_m": 0.1}, {"sensitivity_per_mm": 0.1}, {"calibration": TABLE}])
@pytest.mark.parametrize("stated", ["mm", "deg"])
def test_a_scale_of_volts_is_no_scale_of_another_quantity(scale, stated):
    laser = replace(HIGH, **{"range_m": None, **scale})
    with pytest.raises(FreerockError) as caught:
        find_rotation(TIME, volts(), laser, BLOCK, stated)
    assert next(iter(scale)) in caught.value.what and repr(stated) in caught.value.what


def test_a_bent_calibration_scales_the_noise_too():
    bent = Calibration("voltage", (0.0, 5.0, 10.0), (0.0, 0.03, 0.1))
    laser = replace(HIGH, range_m=None, calibration=bent)
    s = 0.03 + displacement_from_rotation(THETA, BLOCK, laser)
    found = find_rotation(TIME, np.interp(s, bent.distance_m, bent.output) + noise(6, 0.001), laser, BLOCK)
    assert score(found)[np.abs(THETA) > 0.01].var() == pytest.approx(1, abs=0.06)


VERTICAL = Laser("vertical", 0.0349, 0.1), Laser("vertical", 0.01, 0.1)


@pytest.mark.parametrize("lasers", [(HIGH,), (HIGH, LOW)], ids=["one", "two"])
def test_a_rest_that_moves_is_an_error_of_the_zero(lasers):
    """A quarter of the step of the first laser, over what it or the pair moves per angle."""
    signals = [volts(each, seed, 1e-5) for seed, each in enumerate(lasers)]
    signals[0] += np.where(TIME > 6.0, 0.004, 0.0)
    found = find_rotation(TIME, signals, lasers, BLOCK, options=RotationOptions(mains_hz=None))
    per_angle = abs(lasers[0].position_m - (lasers[1].position_m if len(lasers) > 1 else 0.0))
    assert found.attrs["zero_stderr_rad"] == pytest.approx(0.004 * 0.01 / 4 / per_angle, rel=0.03)


@pytest.mark.parametrize(
    ("lasers", "seed"),
    [((HIGH,), 1), ((HIGH, LOW), 2), (VERTICAL, 3)],
    ids=["one", "two", "two vertical"],
)
def test_the_error_of_the_zero_is_that_of_the_rest_levels(lasers, seed):
    """Against the scatter of θ at rest over many noises."""
    generator, levels, given = np.random.default_rng(seed), [], []
    clean = [5 + displacement_from_rotation(THETA, BLOCK, each) / each.metres_per() for each in lasers]
    for _ in range(25):
        signals = [each + 0.002 * generator.standard_normal(TIME.size) for each in clean]
        found = find_rotation(TIME, signals, lasers, BLOCK, options=RotationOptions(mains_hz=None))
        held = (TIME > 4.2) & (TIME < 5.8)
        levels.append(float((found.theta.values - THETA)[held].mean()))
        given.append(found.attrs["zero_stderr_rad"])
    assert 0.3 * np.std(levels) < np.mean(given) < 3 * np.std(levels)


@pytest.mark.parametrize(
    "pair",
    [(HIGH, LOW), (replace(HIGH, face="right"), replace(LOW, face="right"))],
    ids=["left face", "right face"],
)
def test_two_lasers_separate_rotation_from_translation(pair):
    slid = 5e-4 * np.sin(TIME) * np.abs(THETA / THETA.max())
    signals = [volts(laser, seed, shift_m=slid) for seed, laser in enumerate(pair)]
    found = find_rotation(TIME, signals, pair, BLOCK)
    assert score(found).var() == pytest.approx(1, abs=0.04)
    assert {"voltage", "voltage_2", "translation"} <= set(found.data_vars)
    assert np.std(found.translation.values - slid) < 1e-4
    assert names(found) == []


def test_two_vertical_lasers_know_the_side():
    pair = Laser("vertical", 0.09, 0.1), Laser("vertical", 0.13, 0.1)
    found = find_rotation(TIME, [volts(laser, seed, 2e-4) for seed, laser in enumerate(pair)], pair, BLOCK)
    assert score(found).var() == pytest.approx(1, abs=0.04)


@pytest.mark.parametrize("step_s", [1e-4, 5e-3])
def test_a_reading_without_sign_changes_side_down_to_swings_of_a_few_per_cent(step_s):
    """At the larger step no sample lies near a touch-down: the first swings pass 2.5 % of θ0 in each."""
    time_s = np.arange(0, 7, step_s)
    theta = np.exp(-0.5 * time_s) * np.cos(5 * time_s)
    side = _swing_sides(np.abs(theta), 1e-9, time_s, [], Laser("vertical", 0.0, 0.1))
    assert (side * theta > 0)[np.abs(theta) > 0.03].all()


def test_two_lasers_that_disagree_are_named():
    wrong = replace(LOW, range_m=0.12)
    found = find_rotation(TIME, [volts(HIGH, 1), volts(LOW, 2)], (HIGH, wrong), BLOCK)
    (fault,) = listed_faults(found)
    assert fault.name == "lasers_disagree"
    assert fault.start_s == pytest.approx(3.3, abs=0.7)
    assert math.degrees(fault.angle) > 0.5


def test_a_line_that_is_not_from_the_mains_is_named():
    found = find_rotation(TIME, volts() + 0.003 * np.sin(2 * np.pi * 1123.0 * TIME), HIGH, BLOCK)
    (fault,) = listed_faults(found)
    assert fault.name == "aliasing" and fault.note.startswith("12")


def test_gaps_are_dropouts():
    """As a reader leaves them: not a number; in a rest, in a hold and while the block rocks."""
    gone = [slice(1000, 1100), slice(5000, 5003), slice(6500, 6520)]
    signal = volts()
    for part in gone:
        signal[part] = np.nan
    found = find_rotation(TIME, signal, HIGH, BLOCK)
    assert np.array_equal(np.flatnonzero(found.flags), np.concatenate([np.r_[part] for part in gone]))
    given = [(fault.name, fault.start_s, fault.note) for fault in listed_faults(found)]
    assert given == [
        ("dropout", 1.0, "100 samples"),
        ("dropout", 5.0, "3 samples"),
        ("dropout", 6.5, "20 samples"),
    ]
    whole = find_rotation(TIME, volts(), HIGH, BLOCK)
    valid = found.flags.values == 0
    np.testing.assert_allclose(found.theta[valid], whole.theta[valid], atol=1e-5)
    names = ("time", "theta", "sigma_theta", "flags")
    (run,), (other,) = (find_runs(*(each[name].values for name in names), BLOCK) for each in (found, whole))
    assert run.release_s == pytest.approx(other.release_s, abs=0.002)
    assert run.theta0 == pytest.approx(other.theta0, rel=1e-4)
    assert run.verdict.level != "ok" and any("invalid (dropout)" in text for text in run.verdict.texts)
