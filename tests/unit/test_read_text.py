import numpy as np
import pytest
from reading import refusal

from freerock.records.read import read_record

TIME = np.arange(50) / 1000
VOLTS = np.round(5 + np.sin(90 * TIME), 6)


def table(path, *head, delimiter=";", comma=False, encoding="utf-8", columns=(TIME, VOLTS), end="\n"):
    rows = [delimiter.join(f"{x:.6f}" for x in row) for row in zip(*columns, strict=True)]
    if comma:
        rows = [row.replace(".", ",") for row in rows]
    path.write_bytes((end.join([*head, *rows]) + end).encode(encoding))
    return path


@pytest.mark.parametrize(
    ("delimiter", "comma", "reading"),
    [
        ("\t", False, "columns between tabs, decimal point, utf-8"),
        ("\t", True, "columns between tabs, decimal comma, utf-8"),
        (";", False, "columns between semicolons, decimal point, utf-8"),
        (";", True, "columns between semicolons, decimal comma, utf-8"),
        (",", False, "columns between commas, decimal point, utf-8"),
        (", ", False, "columns between commas, decimal point, utf-8"),
        ("  ", False, "columns between spaces, decimal point, utf-8"),
        (" ", True, "columns between spaces, decimal comma, utf-8"),
    ],
)
def test_delimiter_and_decimal_mark(tmp_path, delimiter, comma, reading):
    head = delimiter.join(["time[s]", "laser[V]"])
    dataset = read_record(table(tmp_path / "a.csv", head, delimiter=delimiter, comma=comma))
    assert dataset.attrs == {"format": "text", "sampling_rate_hz": pytest.approx(1000), "reading": reading}
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
    assert dataset["laser"].attrs["units"] == "V"


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends(tmp_path, encoding, end):
    path = table(tmp_path / "a.txt", "Zeit (s);Weg (µm)", comma=True, encoding=encoding, end=end)
    dataset = read_record(path, "Weg")
    np.testing.assert_array_equal(dataset["Weg"], VOLTS)
    assert dataset["Weg"].attrs["units"] == "µm"
    assert dataset.attrs["reading"] == f"columns between semicolons, decimal comma, {encoding}"


@pytest.mark.parametrize(
    ("line", "rate"),
    [
        ("Sampling rate: 2 kS/s", 2000),
        ("fs = 2000 Samples/s", 2000),
        ("Sample rate [S/s]: 500", 500),
        ("Sample rate: 2500 samples per second", 2500),
        ("sampling frequency: 0,25 kHz", 250),
        ("fs: 0.01 MHz", 10_000),
        ("dt = 500 ns", 2e6),
        ("dt: 0,500 ms", 2000),
        ("fs: 1250,5", 1250.5),
        ("Sampling rate;2;kHz", 2000),
        ("Sampling rate;2;channels 2", 2),
        ("Sampling rate,0.5,kHz", 500),
        ("dt;500;\tus", 2000),
        ("Sampling rate;2;[kHz]", 2000),
        ("Sampling rate [kHz];2;Samples;400", 2000),
        ("Sampling rate;2000;Samples;400", 2000),
        ("Sampling interval;0.0005;Min;-10;Max;10", 2000),
        ("fs;0,5;kHz", 500),
    ],
)
def test_units_of_a_stated_sampling_rate(tmp_path, line, rate):
    path = table(tmp_path / "a.txt", line, "volts [V];second [V]", columns=(VOLTS, VOLTS[::-1]))
    assert read_record(path).attrs["sampling_rate_hz"] == pytest.approx(rate)


def test_pairs_of_columns(tmp_path):
    head = ("A;;B;", "t [s];theta [rad];t [s];theta [rad]")
    path = table(tmp_path / "a.csv", *head, columns=(TIME, VOLTS, 2 * TIME, -VOLTS))
    assert refusal(path) == "channels of several time bases: A, B; name the channel"
    dataset = read_record(path, "B")
    np.testing.assert_array_equal(dataset["B"], -VOLTS)
    assert dataset.attrs["sampling_rate_hz"] == pytest.approx(500)
    same = table(tmp_path / "b.csv", *head, columns=(TIME, VOLTS, TIME, -VOLTS))
    assert list(read_record(same).data_vars) == ["A", "B"]


def test_empty_cells_are_missing_samples_and_gaps_are_told(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];laser [V]")
    lines = path.read_text().splitlines()
    lines[11] = lines[11].split(";")[0] + ";"
    del lines[31:34]
    path.write_text("\n".join(lines) + "\n")
    dataset = read_record(path)
    assert np.flatnonzero(np.isnan(dataset["laser"])).tolist() == [10, 30, 31, 32]
    assert dataset.attrs["time_base"] == "3 samples missing in 1 gap, the first after 0.029 s"


@pytest.mark.parametrize("head", [[], ["time,volts"]])
def test_decimal_commas_between_commas(tmp_path, head):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([*head, *(f"0,{i:03d},5,{i:03d}" for i in range(20))]) + "\n")
    assert refusal(path) == (
        f"line {len(head) + 1} may hold 4 columns, or decimal commas; "
        "export with tabs or semicolons between the columns"
    )


def test_no_time_and_no_rate(tmp_path):
    path = table(tmp_path / "a.csv", "a;b", columns=(VOLTS, np.cos(500 * TIME)))
    assert refusal(path).startswith("no column of time and no sampling rate; head the time as Time [s]")
