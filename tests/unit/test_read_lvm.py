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


def test_separated_by_commas(tmp_path):
    rows = [line.replace("\t", ",") for line in segment("One")]
    path = write(tmp_path / "a.lvm", rows, head=("Separator,Comma", "Decimal_Separator,."))
    np.testing.assert_array_equal(read_record(path, "laser")["laser"], VOLTS)


def test_comments_and_special_blocks(tmp_path):
    rows = segment("One", comment="released by hand")
    rows[1:1] = [
        "***Start_Special***",
        "Channels\t7",
        "Samples\t99999",
        "***End_Special***",
        "Notes\tfirst try",
    ]
    np.testing.assert_array_equal(read_record(write(tmp_path / "a.lvm", rows))["wire"], -VOLTS)


def test_text_file_that_labview_wrote(tmp_path):
    dataset = read_record(write(tmp_path / "a.txt", segment()))
    assert dataset.attrs["format"] == "LVM"


def test_segments_are_joined_by_their_dates(tmp_path):
    path = write(tmp_path / "a.lvm", segment("No"), segment("No", time="09:00:00.50", values=-VOLTS))
    dataset = read_record(path, "laser")
    assert dataset.sizes["time"] == 90
    np.testing.assert_array_equal(dataset["laser"][50:], -VOLTS)
    assert np.isnan(dataset["laser"][40:50]).all()
    assert dataset.attrs["time_base"] == "10 samples missing in 1 gap, the longest of 10 after 0.195 s"


def test_segments_whose_x_goes_on(tmp_path):
    path = write(tmp_path / "a.lvm", segment("One"), segment("One", start=0.2, time="09:00:00.45"))
    dataset = read_record(path)
    assert dataset.sizes["time"] == 80 and "time_base" not in dataset.attrs


def test_segments_without_dates_or_with_other_channels(tmp_path):
    undated = [line for line in segment() if not line.startswith("Date")]
    assert refusal(write(tmp_path / "a.lvm", undated, undated)) == (
        "X_Value starts again in its segments, and they give no date; split it, one file per segment"
    )
    other = [line.replace("wire", "rope") for line in segment()]
    assert refusal(write(tmp_path / "b.lvm", segment(), other)) == (
        "its segments hold different channels; split it, one file per segment"
    )


def test_segments_that_overlap(tmp_path):
    path = write(tmp_path / "a.lvm", segment(), segment(time="09:00:00.30"))
    assert refusal(path, "laser").startswith(
        "'X_Value of its segments': time runs backwards once, first from "
    )


def test_more_rows_than_a_header_tells(tmp_path):
    dataset = read_record(write(tmp_path / "a.lvm", segment("No", samples=20)))
    assert dataset.sizes["time"] == 40
    assert dataset.attrs["reading"].endswith(
        "40 rows under a header of 20 samples are taken for one recording"
    )


def test_empty_channel(tmp_path):
    rows = [line.replace("\t40\t40", "\t40\t0") for line in segment("One")]
    rows = [*rows[:10], *(line.rsplit("\t", 1)[0] + "\t" for line in rows[10:])]
    path = write(tmp_path / "a.lvm", rows)
    assert list(read_record(path).data_vars) == ["laser"]
    assert refusal(path, "wire") == "channel 'wire' is empty; name a channel that holds numbers"


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


def test_a_cell_that_is_no_number(tmp_path):
    rows = segment()
    rows[20] = rows[20].replace("\t-", "\t?")
    assert refusal(write(tmp_path / "a.lvm", rows)).startswith("line 27, column 3: '?")


def test_no_sampling_interval(tmp_path):
    rows = [line for line in segment("No") if not line.startswith("Delta_X")]
    assert refusal(write(tmp_path / "a.lvm", rows)) == (
        "channel 'laser' gives no sampling rate (no X_Value, no Delta_X); write the file with one X column"
    )


def test_another_file(tmp_path):
    (tmp_path / "a.lvm").write_text("time;volts\n0;1\n")
    what = "not an LVM file: its first line is not 'LabVIEW Measurement'"
    assert refusal(tmp_path / "a.lvm") == f"{what}; correct the ending of its name, or copy it again"
