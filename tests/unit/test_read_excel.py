import time
import zipfile
from datetime import datetime, timedelta

import numpy as np
import pytest
from openpyxl import Workbook, load_workbook
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
        assert dataset.attrs == {"format": "Excel", "sampling_rate_hz": pytest.approx(100 / (n + 1))}


def test_a_workbook_is_read_once_for_all_its_records_and_again_when_it_has_changed(pairs, monkeypatch):
    read = []

    def load(path, **options):
        read.append(path)
        return load_workbook(path, **options)

    monkeypatch.setattr("freerock.records.excel.load_workbook", load)
    found = [read_record(pairs, name)[name].values for name in SPECIMENS]
    assert len(read) == 1
    book = load_workbook(pairs)
    book["free rocking"]["B4"] = 7.0
    book.save(pairs)
    changed = read_record(pairs, "A1")["A1"].values
    assert len(read) == 2
    assert (found[0][0], changed[0]) == (1.0, 7.0)
    np.testing.assert_array_equal(changed[1:], found[0][1:])


def test_pairs_without_a_choice_are_listed(pairs):
    assert refusal(pairs) == (
        "channels of several time bases: A1, A2, A3, B1, B2, B3, C1, C2, C3; name the channel"
    )
    assert refusal(pairs, "D1").startswith("no channel 'D1'; its channels are A1, A2, ")


def test_channel_of_a_sheet(tmp_path):
    book = Workbook()
    for title, sign in [("left", 1), ("right", -1)]:
        sheet = book.create_sheet(title)
        sheet.append(["Time (ms)", "Laser (V)"])
        for t, v in zip(TIME, theta(0), strict=True):
            sheet.append([1000 * t, sign * v])
    book.save(tmp_path / "a.xlsx")
    dataset = read_record(tmp_path / "a.xlsx", "right/Laser")
    np.testing.assert_allclose(dataset["right/Laser"], -theta(0), atol=1e-15)
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
    assert refusal(tmp_path / "a.xlsx", "Laser").startswith(
        "no channel 'Laser'; its channels are left/Laser, right/Laser; "
    )


def test_what_is_taken_for_granted_is_told(tmp_path):
    dataset = read_record(save(tmp_path / "a.xlsx", *zip(TIME, theta(0), strict=True)))
    assert dataset.attrs["reading"] == (
        "sheet 'tests': column 1 rises steadily and is taken for time; "
        "time has no unit and is taken for seconds"
    )


def test_empty_cells_are_missing_samples(tmp_path):
    rows = [[t, v] for t, v in zip(TIME, theta(0), strict=True)]
    rows[7][1] = None
    dataset = read_record(save(tmp_path / "a.xlsx", ["time [s]", "theta [rad]"], *rows))
    assert np.flatnonzero(np.isnan(dataset["theta"])).tolist() == [7]


def test_a_cell_that_is_no_number(tmp_path):
    rows = [[t, v] for t, v in zip(TIME, theta(0), strict=True)]
    rows[7][1] = "#REF!"
    path = save(tmp_path / "a.xlsx", ["time [s]", "theta [rad]"], *rows)
    assert refusal(path) == (
        "sheet 'tests': cell B9 holds '#REF!', not a number; "
        "correct the cell, or move what is below the table"
    )


def test_a_sheet_with_a_fault_is_passed_over(tmp_path):
    book = Workbook()
    for title, tail in [("good", 1.0), ("bad", "end")]:
        sheet = book.create_sheet(title)
        sheet.append(["time [s]", f"theta {title} [rad]"])
        for t in (0, 1, 2, 3):
            sheet.append([t, 0.5])
        sheet.append([4, tail])
    book.save(tmp_path / "a.xlsx")
    dataset = read_record(tmp_path / "a.xlsx")
    assert list(dataset.data_vars) == ["theta good"]
    assert dataset.attrs["reading"] == "sheet 'bad' passed over: cell B6 holds 'end', not a number"


def test_line_breaks_in_headings(tmp_path):
    rows = [["time\n[s]", "laser\nleft", "laser \n right [V]"], *zip(TIME, theta(1), theta(2), strict=True)]
    dataset = read_record(save(tmp_path / "a.xlsx", *rows))
    assert {name: data.units for name, data in dataset.data_vars.items()} == {
        "laser left": "",
        "laser right": "V",
    }


def test_a_stated_sampling_rate_of_no_known_unit(tmp_path):
    rows = [["Sampling rate", "2 kN"], ["left [V]", "right [V]"], *zip(theta(1), theta(2), strict=True)]
    message = "Sampling rate is in 'kN'; give it in Hz, kHz, MHz or samples/s"
    assert refusal(save(tmp_path / "a.xlsx", *rows)) == f"sheet 'tests': {message}"


def test_stated_sampling_rate(tmp_path):
    rows = [["Sampling rate [Hz]", 250], ["left [V]", "right [V]"], *zip(theta(1), theta(2), strict=True)]
    dataset = read_record(save(tmp_path / "a.xlsx", *rows))
    assert dataset.attrs["sampling_rate_hz"] == 250
    assert [dataset[name].attrs["units"] for name in ("left", "right")] == ["V", "V"]


@pytest.mark.parametrize(("cells", "rate"), [([2, "kHz"], 2000), ([2.5, "Samples"], 2.5)])
def test_unit_of_a_stated_sampling_rate_in_the_next_cell(tmp_path, cells, rate):
    rows = [["Sampling rate", *cells], ["left [V]", "right [V]"], *zip(theta(1), theta(2), strict=True)]
    assert read_record(save(tmp_path / "a.xlsx", *rows)).attrs["sampling_rate_hz"] == rate


def test_no_time(tmp_path):
    path = save(tmp_path / "a.xlsx", ["a", "b"], *zip(theta(1), theta(2), strict=True))
    assert refusal(path) == (
        "sheet 'tests': no column of time and no sampling rate; "
        "head the column of time with time [s], or state the sampling rate"
    )


def test_no_table(tmp_path):
    assert refusal(save(tmp_path / "a.xlsx", ["dear diary"], ["it is", 3, "o'clock"])) == (
        "no sheet holds a table of numbers; "
        "export columns of numbers under headings, the time in seconds among them"
    )


def test_an_archive_that_swells(tmp_path):
    path = save(tmp_path / "a.xlsx", ["time [s]", "theta [rad]"], *zip(TIME, theta(0), strict=True))
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/sharedStrings.xml", b" " * 200_000_000)
    assert refusal(path).startswith("the file declares 2e+08 bytes of data, more than its ")


def test_rows_without_end(tmp_path):
    path = save(tmp_path / "a.xlsx", ["time [s]", "theta [rad]"], *zip(TIME, theta(0), strict=True))
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    sheet = "xl/worksheets/sheet1.xml"
    parts[sheet] = parts[sheet].replace(b'<row r="40"', b'<row r="4000000000"')
    with zipfile.ZipFile(path, "w") as archive:
        for name, part in parts.items():
            archive.writestr(name, part)
    assert refusal(path) == (
        "sheet 'tests' has more than 1048576 rows; copy it again from the acquisition computer"
    )


def test_not_a_workbook(tmp_path):
    path = tmp_path / "a.xlsx"
    path.write_text("time;volts\n0;1\n")
    assert refusal(path) == (
        "not a readable Excel file (BadZipFile: File is not a zip file); "
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
    assert refusal(path).startswith("sheet 'tests': cell A7 holds 'soon', not a time; ")


def changed(path, part, old, new):
    """The workbook with a text of one of its parts replaced."""
    with zipfile.ZipFile(path) as book:
        parts = {name: book.read(name) for name in book.namelist()}
    assert old in parts[part]
    parts[part] = parts[part].replace(old, new, 1)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        for name, content in parts.items():
            book.writestr(name, content)
    return path


SHEET, STYLES = "xl/worksheets/sheet1.xml", "xl/styles.xml"
ENTITY = b'<!DOCTYPE worksheet [<!ENTITY a "%s">]><worksheet' % (b"<row><c><v>1</v></c></row>" * 3000)
WORK = {
    "entities": (
        SHEET,
        b"<worksheet",
        ENTITY,
        "the workbook declares XML entities, which Excel never writes",
    ),
    "cells": (
        *(SHEET, b"</sheetData>", b"<row>" + b"<c/>" * 1_100_000 + b"</row></sheetData>"),
        "has more than 1000000 cells, or 100000 other elements",
    ),
    "fonts": (
        *(STYLES, b"</fonts>", b"<font/>" * 110_000 + b"</fonts>"),
        "has more than 1000000 cells, or 100000 other elements",
    ),
    "wide rows": (
        *(
            SHEET,
            b"</sheetData>",
            b"".join(b'<row r="%d"><c r="XFD%d"/></row>' % (n, n) for n in range(900, 3900)),
        ),
        "sheet 'tests' has more than 33554432 cells, empty ones included",
    ),
}


@pytest.mark.parametrize("work", WORK)
def test_a_small_workbook_makes_no_great_work(tmp_path, work):
    part, old, new, what = WORK[work]
    new += old if work == "wide rows" else b""
    path = save(tmp_path / "book.xlsx", ["time [s]", "V"], *([n / 100, n] for n in range(20)))
    changed(path, part, old, new)
    assert path.stat().st_size < 100_000
    began = time.process_time()
    assert refusal(path).startswith(what)
    assert time.process_time() - began < 10
