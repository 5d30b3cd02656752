"""Excel workbooks, through openpyxl: sheets of columns of numbers, or of pairs (time, signal)."""

from array import array
from dataclasses import replace
from datetime import date, datetime, time
from itertools import chain, islice
from math import nan
from zipfile import ZipFile

import numpy as np
from openpyxl import load_workbook
from openpyxl.utils import get_column_letter

from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN, Even, check_declared, dataset
from freerock.records.headings import columns, headed, rises, states_rate

FORMAT = "Excel"
MAX_ROWS = 1 << 20  # of a sheet
HEAD = 100  # rows in which the table begins
ROWS_ALIKE = 3
WANTED = {"n": "a number", "c": "a time"}  # kinds of cells of a table
DENSEST_SHEET = 110  # a sheet's XML can't shrink more than that many times


def read(path, channel=None):
    """Read an Excel workbook; arguments, result and errors as of `freerock.records.read.read_record`.

    Tables are found below their rows of headings, on every sheet; the values of formulas are those that Excel
    saved. A column of time belongs to the columns at its right. A channel is named "channel" or
    "sheet/channel"; columns may end in empty cells.
    """
    with ZipFile(path) as archive:
        check_declared(path, sum(part.file_size for part in archive.infolist()), DENSEST_SHEET)
    book = load_workbook(path, read_only=True, data_only=True, keep_links=False)
    tables, channels, notes, faults = {}, [], [], []
    try:
        for sheet in book.worksheets:
            try:
                above, tables[sheet.title], clocks = _table(path, sheet)
                found, told = _channels(path, sheet.title, above, tables[sheet.title], clocks)
            except FreerockError as error:
                faults.append(error)
                continue
            channels += found
            notes += [f"sheet {sheet.title!r}: {note}" for note in told]
    finally:
        book.close()
    if not channels:
        remedy = "export columns of numbers under headings, the time in seconds among them"
        raise faults[0] if faults else FreerockError(path, "no sheet holds a table of numbers", remedy)
    notes += [f"{str(error.where).removeprefix(f'{path}: ')} passed over: {error.what}" for error in faults]

    def read_columns(wanted):
        return {(sheet, i): np.array(tables[sheet][i]) for sheet, i in wanted}

    return dataset(path, channels, channel, read_columns, {"format": FORMAT}, notes)


def _channels(path, title, above, numbers, clocks):
    """Channels of a sheet, none of an empty table; their columns are named (sheet, column)."""
    numeric = [i for i in numbers if i not in clocks]
    if not numeric:
        return [], []
    stated = [_stated(row) for row in above]
    rows = [row for row, values in zip(above, stated, strict=True) if not states_rate(values)]
    headings = headed(rows, max(numbers) + 1)
    first = rises(numbers[numeric[0]])
    by_name = {name: value for values in stated for name, value in values.items()}
    found, notes = columns(f"{path}: sheet {title!r}", headings, numeric, clocks, first, by_name)

    def of_sheet(part):
        return part if isinstance(part, Even) else replace(part, column=(title, part.column))

    return [replace(of_sheet(c), group=title, clock=of_sheet(c.clock)) for c in found], notes


def _stated(row):
    """Value by name that a row above a table states, with what the cell behind it says."""
    if len(row) < 2 or not isinstance(row[1], int | float | str):
        return {}
    return {str(row[0]): f"{row[1]};{row[2]}" if len(row) > 2 and isinstance(row[2], str) else row[1]}


def _table(path, sheet):
    """Rows of headings of a sheet, its columns of numbers, and which of them are times of a clock."""
    sheet.reset_dimensions()
    rows = sheet.iter_rows(values_only=True)
    head = list(islice(rows, HEAD))
    kinds = [[_kind(cell) for cell in row] for row in head]
    begin = next((n for n in range(len(head)) if _is_table(kinds[n : n + ROWS_ALIKE])), len(head))
    wanted = {
        i: kind for row in kinds[begin : begin + ROWS_ALIKE] for i, kind in enumerate(row) if kind in WANTED
    }
    numbers = {i: array("d") for i in sorted(wanted)}
    first = {}
    for n, row in enumerate(chain(head[begin:], rows), start=begin + 1):
        if n > MAX_ROWS:
            raise FreerockError(path, f"sheet {sheet.title!r} has more than {MAX_ROWS} rows", COPY_AGAIN)
        for i, values in numbers.items():
            cell = row[i] if i < len(row) else None
            if _kind(cell) not in ("", wanted[i]):
                where = f"{path}: sheet {sheet.title!r}"
                what = f"cell {get_column_letter(i + 1)}{n} holds {str(cell)[:40]!r}, not {WANTED[wanted[i]]}"
                raise FreerockError(where, what, "correct the cell, or move what is below the table")
            if _kind(cell) == "c":
                cell = _moment(cell)
                cell = (cell - first.setdefault(i, cell)).total_seconds()
            values.append(nan if cell is None or cell == "" else cell)
    return [["" if cell is None else cell for cell in row] for row in head[:begin]], numbers, sorted(first)


def _kind(cell):
    """n for a number, c for a clock's time, t for anything else, nothing for an empty cell."""
    if cell is None or cell == "":
        return ""
    if isinstance(cell, datetime | time):
        return "c"
    return "n" if isinstance(cell, int | float) and not isinstance(cell, bool) else "t"


def _moment(cell):
    return cell if isinstance(cell, datetime) else datetime.combine(date.min, cell)


def _is_table(rows):
    """Whether rows begin a table: time or a number first, a number next, and the same columns in all."""
    filled = [kind for kind in rows[0] if kind]
    return filled[:2] in (["n", "n"], ["c", "n"]) and all(
        not a or not b or a == b for row in rows for a, b in zip(rows[0], row, strict=False)
    )
