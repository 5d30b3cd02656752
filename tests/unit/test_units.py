"""Units declared or read, never guessed."""

import math

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.units import in_base_units, understood


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("V", "V"),
        (" Volts ", "V"),
        ("v", "V"),
        ("mV", "mV"),
        ("mA", "mA"),
        ("MV", None),
        ("°", "deg"),
        ("Degrees", "deg"),
        ("µm", "um"),
        ("MM", "mm"),
        ("kg", None),
        ("KV", "kV"),
        ("centimeters", "cm"),
        ("", None),
    ],
)
def test_what_files_write(text, unit):
    assert understood(text) == unit


@pytest.mark.parametrize(
    ("declared", "stated", "quantity", "factor"),
    [
        ("", "V", "voltage", 1.0),
        ("mV", "", "voltage", 1e-3),
        ("mA", "milliampere", "current", 1.0),
        ("mm", "arbitrary", "displacement", 1e-3),
        ("", "cm", "displacement", 1e-2),
        ("", "kV", "voltage", 1e3),
        ("deg", "°", "rotation", math.pi / 180),
    ],
)
def test_values_come_in_the_unit_used_inside(declared, stated, quantity, factor):
    values, found = in_base_units([1.0, -2.0], declared, stated)
    assert found == quantity
    np.testing.assert_allclose(values, [factor, -2 * factor])


@pytest.mark.parametrize(
    ("declared", "stated", "what"),
    [
        ("", "", "the channel states no unit; declare it as units of the laser: "),
        (
            "",
            "kg",
            "the channel's unit 'kg' is not known; name another channel, or declare it as units of the "
            "laser: ",
        ),
        ("V", "mV", "'V' is declared and the file states 'mV'; correct the one that is wrong"),
        ("mm", "cm", "'mm' is declared and the file states 'cm'; correct the one that is wrong"),
        ("V", "kV", "'V' is declared and the file states 'kV'; correct the one that is wrong"),
        ("V", "°C", "'V' is declared and the file states '°C'; correct the one that is wrong, or name the"),
        ("V", "N", "'V' is declared and the file states 'N'; correct the one that is wrong, or name the"),
        ("mm", "µε", "'mm' is declared and the file states 'µε'; correct the one that is wrong, or name"),
        ("deg", "deg/s", "'deg' is declared and the file states 'deg/s'; correct the one that is wrong"),
        ("volts", "", "'volts' is unknown; use one of V, mV"),
    ],
)
def test_units_are_not_guessed(declared, stated, what):
    with pytest.raises(FreerockError) as error:
        in_base_units([1.0], declared, stated)
    assert str(error.value).startswith(f"lasers: units: {what}")
    assert "\n" not in str(error.value)
