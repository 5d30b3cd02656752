"""Names and units of headings, in time that grows with their length and no faster."""

import pytest

from freerock.records.headings import split_unit


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("Time [s]", "Time", "s"),
        ("volts (V)", "volts", "V"),
        ("theta_deg", "theta", "deg"),
        ("t/ms", "t", "ms"),
        ("angle in rad", "angle", "rad"),
        ("laser", "laser", ""),
        ("laser__ [V]", "laser", "V"),
        ("laser (left) [mm]", "laser (left)", "mm"),
        ('"Time\n[s]"', "Time", "s"),
        ("in rad", "in rad", ""),
        ("plain rad", "plain rad", ""),
        ("pin rad", "pin rad", ""),
        ("_deg", "_deg", ""),
        ("node_a", "node_a", ""),
        ("a_[b", "a_[b", ""),
        ("", "", ""),
        ("t / ms", "t", "ms"),
        ("U / V", "U", "V"),
        ("I / mA", "I", "mA"),
        ("F / N", "F", "N"),
        ("x / m", "x", "m"),
        ("T / °C", "T", "°C"),
        ("s\N{NO-BREAK SPACE}/\N{NO-BREAK SPACE}µm", "s", "µm"),
        ("a / (m/s²)", "a", "m/s²"),
        ("a / m/s²", "a", "m/s²"),
        ("ω / rad/s", "ω", "rad/s"),
        ("left / right / mm", "left / right", "mm"),
        ("left / right", "left / right", ""),
        ("laser / 1", "laser / 1", ""),
        ("/ V", "/ V", ""),
        ("Abtastrate / Hz", "Abtastrate", "Hz"),
    ],
)
def test_name_and_unit_of_a_heading(heading, name, unit):
    assert split_unit(heading) == (name, unit)
