from datetime import datetime, timedelta

import numpy as np
import pytest
from openpyxl import Workbook
from reading import refusal

from freerock.records.read import read_record

TIME = np.arange(80) / 100
SPECIMENS = [f"{letter}{number}" for letter in "ABC" for number in (1, 2, 3)]


def theta(n):
    return np.cos((5 + n) * TIME)


@pytest.fixture
def pairs(tmp_path):
    """A sheet of remarks and one of nine pairs (time, θ) of unequal length under three rows of headings."""
    book = Workbook()
    book.active.title = "read me"
    book.active.append(["Free-rocking tests of wooden blocks"])
    sheet = book.create_sheet("free rocking")
    sheet.append([cell for name in SPECIMENS for cell in (name, None)])
    sheet.append(["time", "θ"] * 9)
    sheet.append(["[s]", "[rad]"] * 9)
    for i, t in enumerate(TIME):
        row = []
        for n in range(9):
            row += [(n + 1) * t, theta(n)[i]] if i < 80 - 5 * n else [None, None]
        sheet.append(row)
    path = tmp_path / "blocks.xlsx"
    book.save(path)
    return path


def save(path, *rows, title="tests"):
    book = Workbook()
    book.active.title = title
    for row in rows:
        book.active.append(row)
    book.save(path)
    return path


def test_each_pair_has_its_own_time(pairs):
    for n, name in enumerate(SPECIMENS):
        dataset = read_record(pairs, name)
        np.testing.assert_allclose(dataset[name], theta(n)[: 80 - 5 * n], atol=1e-15)
        np.testing.assert_allclose(dataset["time"], (n + 1) * TIME[: 80 - 5 * n], atol=1e-12)
        assert dataset[name].attrs["units"] == "rad"
        assert dataset.attrs["sampling_rate_hz"] == pytest.approx(100 / (n + 1))


def test_pairs_without_a_choice_are_listed(pairs):
    assert refusal(pairs) == (
        "channels of several time bases: A1, A2, A3, B1, B2, B3, C1, C2, C3; name the channel"
    )
    assert refusal(pairs, "D1").startswith("no channel 'D1'; its channels are A1, A2, ")


def test_empty_cells_are_missing_samples(tmp_path):
    rows = [[t, v] for t, v in zip(TIME, theta(0), strict=True)]
    rows[7][1] = None
    dataset = read_record(save(tmp_path / "a.xlsx", ["time [s]", "theta [rad]"], *rows))
    assert np.flatnonzero(np.isnan(dataset["theta"])).tolist() == [7]


def test_a_cell_that_is_no_number(tmp_path):
    rows = [[t, v] for t, v in zip(TIME, theta(0), strict=True)]
    rows[7][1] = "soon"
    path = save(tmp_path / "a.xlsx", ["time [s]", "theta [rad]"], *rows)
    assert refusal(path) == (
        "sheet 'tests': cell B9: 'soon' is not a number; correct the line, or export the file again"
    )


def test_stated_sampling_rate(tmp_path):
    rows = [["Sampling rate [Hz]", 250], ["left [V]", "right [V]"], *zip(theta(1), theta(2), strict=True)]
    dataset = read_record(save(tmp_path / "a.xlsx", *rows))
    assert dataset.attrs["sampling_rate_hz"] == 250
    assert [dataset[name].attrs["units"] for name in ("left", "right")] == ["V", "V"]


def test_no_time(tmp_path):
    path = save(tmp_path / "a.xlsx", ["a", "b"], *zip(theta(1), theta(2), strict=True))
    assert refusal(path).startswith("no column of time and no sampling rate; head the time as Time [s], ")


def test_not_a_workbook(tmp_path):
    path = tmp_path / "a.xlsx"
    path.write_text("time;volts\n0;1\n")
    assert refusal(path) == (
        "not a readable .xlsx file (BadZipFile: File is not a zip file); "
        "copy it again from the acquisition computer"
    )


def test_clock_times(tmp_path):
    start = datetime(2017, 5, 2, 9, 30)
    rows = [[start + timedelta(seconds=t), v] for t, v in zip(TIME, theta(0), strict=True)]
    dataset = read_record(save(tmp_path / "a.xlsx", ["when", "theta [rad]"], *rows))
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-6)
    assert dataset["theta"].attrs["units"] == "rad" and "reading" not in dataset.attrs
    rows[5][0] = "soon"
    path = save(tmp_path / "b.xlsx", ["when", "theta [rad]"], *rows)
    assert refusal(path).startswith("sheet 'tests': column A: 'soon' in row 7 is no time; ")
