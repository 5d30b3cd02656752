"""Units declared or read, never guessed; calibration tables."""

import math

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.units import UNITS, Calibration, in_base_units, read_calibration, understood


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
        ("", "kg", "the channel's unit 'kg' is not known; declare it as units of the laser: "),
        ("V", "mV", "'V' is declared and the file states 'mV'; correct the one that is wrong"),
        ("mm", "cm", "'mm' is declared and the file states 'cm'; correct the one that is wrong"),
        ("V", "kV", "'V' is declared and the file states 'kV'; correct the one that is wrong"),
        ("volts", "", "'volts' is unknown; use one of V, mV"),
    ],
)
def test_units_are_not_guessed(declared, stated, what):
    with pytest.raises(FreerockError) as error:
        in_base_units([1.0], declared, stated)
    assert str(error.value).startswith(f"lasers: units: {what}")
    assert "\n" not in str(error.value)


def test_every_unit_names_itself():
    assert all(understood(unit) == unit for unit in UNITS)


def test_calibration_table(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("V,mm\n10,100\n5,49\n0,0\n")
    assert read_calibration(path) == Calibration("voltage", (0.0, 5.0, 10.0), (0.0, 0.049, 0.1))


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "the first line is ''; write the units of the two columns there, as V,mm"),
        ("0,0\n1,1\n", "the first line is '0,0'; write the units of the two columns there, as V,mm"),
        ("V,mm\n0,zero\n", "could not convert string to float: 'zero'; write two numbers"),
        ("V,mm\n0,0\n", "the columns don't rise or fall throughout; give two lines or more"),
        ("V,mm\n0,0\n1,2\n2,1\n", "the columns don't rise or fall throughout; give two lines or more"),
        ("V,mm\n0,0\n1,nan\n", "the columns don't rise or fall throughout; give two lines or more"),
        ("V,mm\n0,0\n\n1\n", "line 4 holds 1 value; write two numbers with a decimal point per line"),
        ("V,mm\n0,0\n1,2,3\n", "line 3 holds 3 values; write two numbers with a decimal point per line"),
    ],
)
def test_calibration_table_that_is_none(tmp_path, text, what):
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(FreerockError) as error:
        read_calibration(path)
    assert str(error.value).startswith(f"{path}: {what}")


def test_missing_calibration_table(tmp_path):
    with pytest.raises(FreerockError, match="put the calibration table there"):
        read_calibration(tmp_path / "none.csv")
