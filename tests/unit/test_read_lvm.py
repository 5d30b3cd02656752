import numpy as np
import pytest
from reading import refusal

from freerock.records.read import read_record

VOLTS = np.round(5 + np.sin(np.arange(40) / 9), 6)
COPY = "copy it again from the acquisition computer"
END = "***End_of_Header***"


def segment(x="One", step="0.005", samples=40, time="09:00:00.25", start=0.0, values=VOLTS, comment=""):
    """Header and rows of two channels, laser and its negative, with the X columns asked for."""
    n = {"No": 0, "One": 0, "Multi": 1}[x]
    gap = [""] * n

    def line(key, *cells):
        return "\t".join([key, cells[0], *gap, cells[1], *gap])

    rows = []
    for i, v in enumerate(values):
        t = f"{start + i * float(step):.6f}"
        first, second = ("", "") if x == "No" else (t, t)
        rows.append("\t".join([first, f"{v:.6f}", *([second] if n else []), f"{-v:.6f}"]))
    if comment:
        rows[0] += f"\t{comment}"
    return [
        line("Channels", "2", ""),
        line("Samples", str(samples), str(samples)),
        line("Date", "2017/05/02", "2017/05/02"),
        line("Time", time, time),
        line("Y_Unit_Label", "V", "mm"),
        line("X_Dimension", "Time", "Time"),
        line("X0", str(start), str(start)),
        line("Delta_X", step, step),
        END,
        "\t".join(["X_Value", "laser", *(["X_Value"] * n), "wire", "Comment"]),
        *rows,
    ]


def write(path, *segments, head=("Separator\tTab", "Decimal_Separator\t."), encoding="utf-8"):
    lines = ["LabVIEW Measurement\t", "Writer_Version\t2", *head, f"{END}\t", ""]
    for rows in segments:
        lines += [*rows, ""]
    path.write_bytes("\r\n".join(lines).encode(encoding))
    return path


@pytest.mark.parametrize("x", ["No", "One", "Multi"])
def test_columns_of_time(tmp_path, x):
    dataset = read_record(write(tmp_path / "a.lvm", segment(x)))
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    np.testing.assert_array_equal(dataset["wire"], -VOLTS)
    np.testing.assert_allclose(dataset["time"], np.arange(40) * 0.005, atol=1e-12)
    assert [dataset[name].attrs["units"] for name in dataset] == ["V", "mm"]
    assert dataset.attrs == {
        "format": "LVM",
        "start_time": "2017-05-02T09:00:00.250",
        "sampling_rate_hz": pytest.approx(200),
        "reading": "columns between tabs, decimal point, utf-8",
    }


def test_decimal_comma_and_old_encoding(tmp_path):
    rows = [line.replace(".", ",").replace("mm", "µm") for line in segment("One")]
    head = ("Separator\tTab", "Operator\tJosé", "Decimal_Separator\t,")
    dataset = read_record(write(tmp_path / "a.lvm", rows, head=head, encoding="cp1252"))
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    assert dataset["wire"].attrs["units"] == "µm"
    assert dataset.attrs["reading"] == "columns between tabs, decimal comma, cp1252"
    assert dataset.attrs["start_time"] == "2017-05-02T09:00:00.250"


def test_segments_are_joined_by_their_dates(tmp_path):
    path = write(tmp_path / "a.lvm", segment("No"), segment("No", time="09:00:00.50", values=-VOLTS))
    dataset = read_record(path, "laser")
    assert dataset.sizes["time"] == 90
    np.testing.assert_array_equal(dataset["laser"][50:], -VOLTS)
    assert np.isnan(dataset["laser"][40:50]).all()
    assert dataset.attrs["time_base"] == "10 samples missing in 1 gap, the first after 0.195 s"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (3, "the file is truncated: the header of the file has no end"),
        (5, "the file is truncated: no segment follows its header"),
        (8, "the file is truncated: the header of segment 1 has no end"),
        (14, "the file is truncated: the header of segment 1 has no end"),
        (15, "the file is truncated: segment 1 holds no data"),
        (25, "the file is truncated: channel 'laser' holds 9 of 40 samples in segment 1"),
    ],
)
def test_truncated(tmp_path, lines, message):
    path = write(tmp_path / "a.lvm", segment())
    path.write_bytes(b"\r\n".join(path.read_bytes().split(b"\r\n")[:lines]) + b"\r\n")
    assert refusal(path) == f"{message}; {COPY}"


def test_another_file(tmp_path):
    (tmp_path / "a.lvm").write_text("time;volts\n0;1\n")
    what = "its first line is not 'LabVIEW Measurement'"
    assert refusal(tmp_path / "a.lvm") == f"{what}; correct the ending of its name"
