"""The report's words on the sensors: lasers, channels that hold the rotation itself, hum left in."""

from fabricated import campaign
from test_report import make, settings


def test_a_channel_of_rotations_and_no_mains(tmp_path):
    shipped = settings([])
    sensor = shipped["lasers"]["at_200mm"] | {
        "beam": None,
        "position_m": None,
        "range_m": None,
        "units": "deg",
    }
    processing = shipped["processing"] | {"rotation": shipped["processing"]["rotation"] | {"mains_hz": None}}
    page = make(tmp_path, campaign(), lasers={"at_200mm": sensor}, processing=processing)
    assert "Sensor at_200mm: the channel holds the rotation itself, in deg." in page.text
    assert "mains frequency" not in page.text
    assert "Displacement became θ" not in page.text


def test_a_laser(tmp_path):
    page = make(tmp_path, campaign())
    assert "Laser at_200mm: horizontal beam at 0.2 m, range 0.1 m." in page.text
    assert "Lines at the mains frequency (50 Hz)" in page.text
