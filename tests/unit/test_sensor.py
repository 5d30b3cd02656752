"""Sensors: what their output means, and what no sensor has."""

from dataclasses import replace

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.rotation.sensor import Laser, distance_from_output, looks_like_current

LASER = Laser("horizontal", 0.2, 0.1)


def test_sensor_manual_example():
    sensor = Laser("horizontal", 0.2, 0.010)
    assert distance_from_output(4.6, sensor)[0] == pytest.approx(0.0046)
    assert distance_from_output(4.6, sensor)[0] - 0.010 / 2 == pytest.approx(-0.0004)


@pytest.mark.parametrize(("beyond", "current"), [(2, False), (10, True)])
def test_more_than_a_hundredth_beyond_the_volts_looks_like_milliamperes(beyond, current):
    output = np.append(np.linspace(4, 10, 200 - beyond), np.linspace(12, 18, beyond))
    assert looks_like_current(output, LASER) is current


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"beam": "slanted"}, "laser.beam: "),
        ({"position_m": 0.0}, "laser.position_m: 0 is not above the base"),
        ({"range_m": -1.0}, "laser.range_m: "),
        ({"volts_at_end": 0.0}, "laser.volts_at_end: 0 is not above volts_at_start; "),
    ],
)
def test_impossible_laser(change, message):
    with pytest.raises(FreerockError) as error:
        replace(LASER, **change)
    assert str(error.value).startswith(message)
