"""Excel workbooks, through openpyxl: sheets of columns of numbers, or of pairs (time, signal)."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from datetime import date, datetime, time, timedelta
from functools import lru_cache
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from openpyxl import load_workbook
from openpyxl.utils import get_column_letter

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.cells import kind_of, mark
from freerock.records.channels import Channel, Contents
from freerock.records.table import ROWS_ALIKE, begins_table, columns, head_of, kinds_of
from freerock.records.times import seconds, unwrapped

FORMAT = "Excel"
HEAD = 100  # rows in which the table begins

Row = tuple[Any, ...]


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an Excel workbook.

    Tables are found below their rows of headings, on every sheet; the values of formulas are those that Excel
    saved. A column of time belongs to the columns at its right. A channel is named "channel" or
    "sheet/channel"; columns may end in empty cells.
    """
    known = path.stat()
    tables, channels, notes, above = _parsed(path, known.st_ino, known.st_size, known.st_mtime_ns)
    notes = [*notes]

    def read(wanted: Sequence[tuple[str, int]]) -> dict[tuple[str, int], Floats]:
        found = {}
        for sheet, i in wanted:
            rows, kinds = tables[sheet]
            cells = [row[i] if i < len(row) else None for row in rows]
            where = f"{path}: sheet {sheet!r}, column {get_column_letter(i + 1)}"
            found[sheet, i], told = (_numbers if kinds[i] == "n" else _times)(where, cells)
            notes.extend(f"sheet {sheet!r}, column {get_column_letter(i + 1)}: {note}" for note in told)
        return found

    yield Contents([*channels], read, FORMAT, notes, above=above)


@lru_cache(maxsize=1)  # the records of one workbook are read one after the other
def _parsed(
    path: Path, *state: int
) -> tuple[dict[str, tuple[list[Row], dict[int, str]]], list[Channel], list[str], list[str]]:
    """Tables by sheet, channels, notes and rows above the numbers of a workbook in a `state` of its file."""
    tables: dict[str, tuple[list[Row], dict[int, str]]] = {}
    channels: list[Channel] = []
    notes: list[str] = []
    above: list[str] = []
    faults: list[FreerockError] = []
    with closing(load_workbook(path, read_only=True, data_only=True, keep_links=False)) as book:
        for sheet in book.worksheets:
            sheet.reset_dimensions()
            where = f"{path}: sheet {sheet.title!r}"
            try:
                found = _table(where, [*sheet.iter_rows(values_only=True)])
                if found is None:
                    notes.append(f"sheet {sheet.title!r} holds no table of numbers")
                    continue
                begin, rows, kinds = found
                lines = [";".join(_text(cell).replace(";", ",") for cell in row) for row in rows[:begin]]
                head = head_of(where, lines, ";", kinds, "row")
                first = rows[begin : begin + HEAD]
                numbers = {
                    i: _numbers(where, [_at(r, i) for r in first])[0] for i, k in kinds.items() if k == "n"
                }
                channels += columns(where, head, kinds, numbers, group=sheet.title)
            except FreerockError as error:
                faults.append(error)
                continue
            tables[sheet.title] = rows[begin:], kinds
            above += [f"sheet {sheet.title!r}, {line}" for line in head.above]
    if not channels:
        remedy = "export columns of numbers under headings, the time in seconds among them"
        raise faults[0] if faults else FreerockError(path, "no sheet holds a table of numbers", remedy)
    notes += [f"{str(error.where).removeprefix(f'{path}: ')} passed over: {error.what}" for error in faults]
    return tables, channels, notes, above


def _table(where: str, rows: list[Row]) -> tuple[int, list[Row], dict[int, str]] | None:
    """Where a table begins, all rows, and what its columns hold; None of a sheet without a table."""
    width = max(map(len, rows), default=0)
    rows = [(*row, *[None] * (width - len(row))) for row in rows]
    kinds = [[_kind(cell) for cell in row] for row in rows]
    starts = (n for n in range(min(HEAD, len(rows))) if begins_table(kinds[n : n + ROWS_ALIKE]))
    begin = next((n for n in starts if len({*kinds[n]} - {""}) and sum(map(bool, kinds[n])) > 1), None)
    if begin is None:
        return None
    texts = [(n + 1, [_text(cell) for cell in rows[n]], kinds[n]) for n in range(begin, len(rows))]
    return begin, rows, kinds_of(where, texts, lambda n, i: f"cell {get_column_letter(i + 1)}{n}")


def _at(row: Row, i: int) -> Any:
    return row[i] if i < len(row) else None


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell).strip()


def _kind(cell: Any) -> str:
    """What a cell holds, as `cells.kind_of` names it."""
    if isinstance(cell, datetime | time | timedelta):
        return "c"
    if isinstance(cell, int | float) and not isinstance(cell, bool):
        return "n"
    return "t" if isinstance(cell, bool) else kind_of(_text(cell), ".")


def _numbers(where: str, cells: Sequence[Any]) -> tuple[Floats, list[str]]:
    """Cells as numbers, marks among them, and what was found out."""
    values = np.empty(len(cells))
    texts, marks = 0, 0
    for n, cell in enumerate(cells):
        if isinstance(cell, str) and cell.strip():
            value = mark(cell)
            texts, marks = texts + (value is None), marks + (value is not None)
            values[n] = float(cell) if value is None else value
        else:
            values[n] = nan if cell is None or isinstance(cell, str) else cell
    told = [f"{texts} numbers are stored as text"] if texts else []
    return values, told + ([f"{marks} cells are marks of missing samples"] if marks else [])


def _times(where: str, cells: Sequence[Any]) -> tuple[Floats, list[str]]:
    """Cells as seconds since the first, and what was found out."""
    if all(cell is None or isinstance(cell, str) for cell in cells):
        return seconds(where, pd.Series(cells, dtype="str"))
    moments = [None if cell is None or cell == "" else _moment(cell) for cell in cells]
    odd = next((cell for cell, m in zip(cells, moments, strict=True) if isinstance(m, str)), None)
    if odd is not None:
        raise FreerockError(where, f"{odd!r} is a text among times", "enter the times as Excel's own")
    first = next(moment for moment in moments if moment is not None)
    found = np.array([nan if m is None else (m - first).total_seconds() for m in moments])
    return (found, []) if first.year > 1 else unwrapped(found)


def _moment(cell: datetime | time | timedelta | str) -> Any:
    if isinstance(cell, timedelta):
        return datetime.min + cell
    return datetime.combine(date.min, cell) if isinstance(cell, time) else cell
