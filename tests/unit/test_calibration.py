"""Calibration tables."""

import pytest

from freerock.errors import FreerockError
from freerock.rotation.sensor import Calibration, read_calibration


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
        ("V,mm\n0,0\n\n1\n", "not enough values to unpack (expected 2, got 1); write two numbers"),
        ("V,mm\n0,0\n1,2,3\n", "too many values to unpack (expected 2); write two numbers"),
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
