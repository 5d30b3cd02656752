"""Names and units of headings, in time that grows with their length and no faster."""

import time

import pytest

from freerock.records.headings import is_time, split_unit
from freerock.records.read import read_record
from freerock.records.table import kind_of


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


LONG = 50_000


@pytest.mark.parametrize(
    "heading",
    [
        "_" * LONG,
        "[" * LONG,
        "(" * LONG + ")" * LONG,
        " " * LONG + "x",
        "x" + " " * LONG + "/" + " " * LONG + "V",
        "x / " * LONG + "V",
        "a in " * LONG,
        "/" * LONG,
        "a" * LONG + "_",
    ],
)
def test_long_headings_take_no_time(heading):
    began = time.process_time()
    split_unit(heading)
    is_time(heading)
    assert time.process_time() - began < 1


def test_a_file_with_a_heading_of_underscores_is_read_at_once(tmp_path):
    rows = "".join(f"{n / 100},{n % 7}\n" for n in range(100))
    (tmp_path / "record.csv").write_text(f"time [s],{'_' * LONG}\n{rows}")
    began = time.process_time()
    assert list(read_record(tmp_path / "record.csv").data_vars) == ["_" * LONG]
    assert time.process_time() - began < 3


def test_a_cell_of_many_digits_takes_no_time():
    began = time.process_time()
    assert kind_of("1" * LONG + "x", ".") == "t"
    assert kind_of("1" * LONG, ".") == "n"
    assert time.process_time() - began < 1
