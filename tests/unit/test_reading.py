"""One laser: rotation with honest errors, flags, and signals from which none can come."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.processing import RotationOptions
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.beam import displacement_from_rotation
from freerock.rotation.flags import FLAGS
from freerock.rotation.rotation import find_rotation, rotation_in
from freerock.rotation.sensor import Laser

BLOCK = Block(0.28, 0.07, 5.84)
LASER = Laser("horizontal", 0.2, 0.1)
RATE = 2000.0


def record(generator, *, noise=0.002, drift=0.0, mains=0.0, laser=LASER, block=BLOCK, release_deg=8.0):
    """Rest, tilt by hand, hold, a decaying swing about zero, rest: time, θ and volts."""
    time = np.arange(0, 20, 1 / RATE)
    t = time - 8.0
    tilt = np.clip((time - 4) / 1.5, 0, 1)
    theta = math.radians(release_deg) * tilt**2 * (3 - 2 * tilt)
    swing = (
        math.radians(release_deg) * np.exp(-1.2 * np.maximum(t, 0)) * np.cos(2 * np.pi * (1.1 + 0.4 * t) * t)
    )
    theta = np.where(t > 0, swing, theta)
    volts = 5.1 + displacement_from_rotation(theta, block, laser) / laser.metres_per()
    volts = volts + drift * time / 20 + mains * np.sin(2 * np.pi * 50.013 * time + 0.4)
    return time, theta, volts + noise * generator.standard_normal(time.size)


@pytest.mark.parametrize(
    "laser", [LASER, replace(LASER, face="right"), replace(LASER, sign=-1), Laser("vertical", 0.12, 0.1)]
)
def test_rotation_scores_have_unit_variance(laser):
    time, theta, volts = record(np.random.default_rng(2), drift=0.003, mains=0.003, laser=laser)
    found = find_rotation(time, volts, laser, BLOCK)
    score = (found.theta - theta) / found.sigma_theta
    assert score.var().item() == pytest.approx(1, abs=0.03)
    assert found.attrs["noise_v"] == pytest.approx(0.002, rel=0.02)
    assert found.attrs["mains_amplitude_v"] == pytest.approx(0.003, rel=0.03)
    assert found.attrs["mains_hz"] == pytest.approx(50.013, abs=0.001)
    assert found.attrs["sampling_rate_hz"] == pytest.approx(RATE)
    assert not found.flags.any()


def test_noise_free_rotation_is_exact():
    time, theta, volts = (x[: int(8 * RATE)] for x in record(np.random.default_rng(4), noise=0.0))
    found = find_rotation(time, volts, LASER, BLOCK, options=RotationOptions(mains_hz=None))
    assert np.abs(found.theta - theta).max() <= 1e-12


def test_vertical_beam_between_the_corners_changes_side_at_touch_down():
    laser = Laser("vertical", 0.004, 0.1, release_side="negative")
    time, theta, volts = record(np.random.default_rng(5), noise=0.001, laser=laser, release_deg=-5.0)
    found = find_rotation(time, volts, laser, BLOCK)
    clear = np.abs(theta) > math.radians(0.4)
    assert np.abs(found.theta - theta)[clear].max() < 6 * found.sigma_theta.max()
    assert {1.0, -1.0} == set(np.sign(theta[clear]))


def test_target_lost_is_flagged():
    time, _, volts = record(np.random.default_rng(7))
    low = replace(LASER, position_m=0.02)
    found = find_rotation(time, volts, low, BLOCK)
    lost = found.flags == FLAGS["target_lost"]
    assert lost.any() and np.isnan(found.theta[lost.values]).all()


@pytest.mark.parametrize(
    ("volts", "message"),
    [
        (
            np.full(4000, np.nan),
            "laser signal: no sample is a number; check the channel, the cable and the sensor's range",
        ),
        (
            np.full(4000, 4.5),
            "laser signal: constant at 4.5 V; check the channel, the cable and the sensor's range",
        ),
        (
            np.full(4000, 10.2),
            "laser signal: no sample within -0.1 to 10.1 V (100% error_level); "
            "check the channel, the cable and the sensor's range",
        ),
        (
            np.full(4000, 10.5),
            "laser signal: no sample within -0.1 to 10.1 V (100% out_of_range); "
            "check the channel, the cable and the sensor's range",
        ),
        (
            12 + np.sin(np.arange(4000) / 100),
            "laser signal: 100 % of the samples are beyond 10.1 V: 11 to 13 looks like mA; "
            "declare units: mA of the laser, or name its channel",
        ),
        (
            9 + np.clip(np.arange(4000) / 1000, 1, 3),
            "laser signal: 72.5 % of the samples are beyond 10.1 V: 10 to 12 looks like mA; "
            "declare units: mA of the laser, or name its channel",
        ),
        (
            5 + np.sin(np.arange(4000) / 100),
            "laser signal: the block never stands still, so θ = 0 is unknown; "
            "record the block at rest before the first or after the last release",
        ),
    ],
)
def test_useless_signals(volts, message):
    with pytest.raises(FreerockError) as error:
        find_rotation(np.arange(volts.size) / RATE, volts, LASER, BLOCK)
    assert str(error.value) == message


def test_samples_that_the_instrument_marks_are_out_of_range(tmp_path):
    time, _, volts = (each[::4] for each in record(np.random.default_rng(2)))
    marked = [100, 4700]
    volts[marked] = 1e38
    np.savetxt(
        path := tmp_path / "a.csv",
        np.column_stack([time, volts]),
        "%.6g",
        ",",
        header="Time [s],laser [V]",
        comments="",
    )
    found = rotation_in(path, [""], [LASER], BLOCK, RotationOptions())
    assert np.flatnonzero(found.flags.values & FLAGS["out_of_range"]).tolist() == marked
