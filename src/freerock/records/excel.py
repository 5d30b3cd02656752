"""Excel workbooks, through openpyxl: sheets of columns of numbers, or of pairs (time, signal)."""

from array import array
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import date, datetime, time
from functools import lru_cache
from itertools import chain, islice
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
from openpyxl import load_workbook
from openpyxl.utils import get_column_letter

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import Channel, Contents
from freerock.records.headings import WANTED, columns, headed, rises, states_rate

FORMAT = "Excel"
HEAD = 100  # rows in which the table begins
ROWS_ALIKE = 3


Cell = str | bool | int | float | datetime | time | None


@dataclass(frozen=True)
class Table:
    """A table of a sheet: the rows above it, its columns by place, which of them hold times."""

    above: list[list[Cell]]
    columns: "dict[int, array[float]]"
    clocks: list[int]


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an Excel workbook.

    Tables are found below their rows of headings, on every sheet; the values of formulas are those that Excel
    saved. A column of time belongs to the columns at its right. A channel is named "channel" or
    "sheet/channel"; columns may end in empty cells.
    """
    known = path.stat()
    tables, channels, notes = _parsed(path, known.st_ino, known.st_size, known.st_mtime_ns)

    def read(wanted: Sequence[tuple[str, int]]) -> dict[tuple[str, int], Floats]:
        return {(sheet, i): np.array(tables[sheet].columns[i]) for sheet, i in wanted}

    yield Contents([*channels], read, FORMAT, [*notes])


@lru_cache(maxsize=1)  # the records of one workbook are read one after the other
def _parsed(path: Path, *state: int) -> tuple[dict[str, Table], list[Channel], list[str]]:
    """Tables by sheet, channels and notes of a workbook in a `state` of its file."""
    tables: dict[str, Table] = {}
    channels: list[Channel] = []
    notes: list[str] = []
    faults: list[FreerockError] = []
    with closing(load_workbook(path, read_only=True, data_only=True, keep_links=False)) as book:
        for sheet in book.worksheets:
            try:
                tables[sheet.title] = _table(path, sheet)
                found, of_sheet = _channels(path, sheet.title, tables[sheet.title])
            except FreerockError as error:
                faults.append(error)
                continue
            channels += found
            notes += [f"sheet {sheet.title!r}: {note}" for note in of_sheet]
    if not channels:
        remedy = "export columns of numbers under headings, the time in seconds among them"
        raise faults[0] if faults else FreerockError(path, "no sheet holds a table of numbers", remedy)
    notes += [f"{str(error.where).removeprefix(f'{path}: ')} passed over: {error.what}" for error in faults]
    return tables, channels, notes


def _channels(path: Path, title: str, table: Table) -> tuple[list[Channel], list[str]]:
    """Channels of a sheet and notes, none of an empty table; their columns are named (sheet, column)."""
    numeric = [i for i in table.columns if i not in table.clocks]
    if not numeric:
        return [], []
    stated = [_stated(row) for row in table.above]
    rows = [row for row, values in zip(table.above, stated, strict=True) if not states_rate(values)]
    headings = headed(rows, max(table.columns) + 1)
    first = rises(table.columns[numeric[0]])
    by_name = {name: value for values in stated for name, value in values.items()}
    return columns(f"{path}: sheet {title!r}", headings, numeric, table.clocks, first, by_name, title)


def _stated(row: Sequence[Cell]) -> dict[str, str | float]:
    """Value by name that a row above a table states, with what the cell behind it says."""
    if len(row) < 2 or not isinstance(row[1], int | float | str):
        return {}
    return {str(row[0]): f"{row[1]};{row[2]}" if len(row) > 2 and isinstance(row[2], str) else row[1]}


def _table(path: Path, sheet: Any) -> Table:
    sheet.reset_dimensions()
    rows = sheet.iter_rows(values_only=True)
    head = list(islice(rows, HEAD))
    kinds = [[_kind(cell) for cell in row] for row in head]
    begin = next((n for n in range(len(head)) if _is_table(kinds[n : n + ROWS_ALIKE])), len(head))
    first_rows = kinds[begin : begin + ROWS_ALIKE]
    wanted = {i: kind for row in first_rows for i, kind in enumerate(row) if kind in WANTED}
    numbers = {i: array("d") for i in sorted(wanted)}
    first: dict[int, datetime] = {}
    for n, row in enumerate(chain(head[begin:], rows), start=begin + 1):
        for i, values in numbers.items():
            cell = row[i] if i < len(row) else None
            if _kind(cell) not in ("", wanted[i]):
                where = f"{path}: sheet {sheet.title!r}"
                what = f"cell {get_column_letter(i + 1)}{n} holds {str(cell)[:40]!r}, not {WANTED[wanted[i]]}"
                raise FreerockError(where, what, "correct the cell, or move what is below the table")
            if isinstance(cell, datetime | time):
                moment = _moment(cell)
                values.append((moment - first.setdefault(i, moment)).total_seconds())
            else:
                values.append(nan if cell is None or cell == "" else cell)
    above = [["" if cell is None else cell for cell in row] for row in head[:begin]]
    return Table(above, numbers, sorted(first))


def _kind(cell: Cell) -> str:
    """n for a number, c for a clock's time, t for anything else, nothing for an empty cell."""
    if cell is None or cell == "":
        return ""
    if isinstance(cell, datetime | time):
        return "c"
    return "n" if isinstance(cell, int | float) and not isinstance(cell, bool) else "t"


def _moment(cell: datetime | time) -> datetime:
    return cell if isinstance(cell, datetime) else datetime.combine(date.min, cell)


def _is_table(rows: Sequence[Sequence[str]]) -> bool:
    """Whether rows begin a table: time or a number first, a number next, and the same columns in all."""
    filled = [kind for kind in rows[0] if kind]
    return filled[:2] in (["n", "n"], ["c", "n"]) and all(
        not a or not b or a == b for row in rows for a, b in zip(rows[0], row, strict=False)
    )
