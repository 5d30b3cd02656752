"""Excel workbooks, through openpyxl: sheets of columns of numbers, or of pairs (time, signal)."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import timedelta
from functools import lru_cache
from pathlib import Path
from typing import Any

import pandas as pd
from openpyxl import load_workbook
from openpyxl.utils import get_column_letter

from freerock.errors import FreerockError
from freerock.records.channels import Channel, Contents
from freerock.records.table import Table, channels_of, layout_of

HEAD = 100  # rows in which the table begins


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an Excel workbook.

    Tables are found below their rows of headings, on every sheet; the values of formulas are those that Excel
    saved. A channel is named "channel" or "sheet/channel"; columns may end in empty cells.
    """
    state = path.stat()
    channels, notes, above, faults = list[Channel](), list[str](), list[str](), list[FreerockError]()
    for title, table in _tables(path, state.st_ino, state.st_size, state.st_mtime_ns).items():
        if table is None:
            notes.append(f"sheet {title!r} holds no table of numbers")
            continue
        try:
            found, lines = channels_of(table, notes, title)
        except FreerockError as fault:
            faults.append(fault)
            notes.append(f"sheet {title!r} passed over: {fault.what}")
            continue
        channels += found
        above += [f"sheet {title!r}, {line}" for line in lines]
    if not channels:
        none = FreerockError(path, "no sheet holds a table of numbers", "export columns of numbers")
        raise faults[0] if faults else none
    yield Contents(channels, "Excel", notes, above=above)


@lru_cache(maxsize=1)  # the records of one workbook are read one after the other
def _tables(path: Path, *state: int) -> dict[str, Table | None]:
    """The table of each sheet of a workbook in a `state` of its file."""
    tables = {}
    with closing(load_workbook(path, read_only=True, data_only=True, keep_links=False)) as book:
        for sheet in book.worksheets:
            sheet.reset_dimensions()
            rows = [[*map(_text, row)] for row in sheet.values]
            tables[sheet.title] = _table(f"{path}: sheet {sheet.title!r}", rows)
    return tables


def _table(where: str, rows: list[list[str]]) -> Table | None:
    """The table of a sheet, given as texts; None where it holds none."""
    width = max(map(len, rows), default=0)
    cells = {n: row + [""] * (width - len(row)) for n, row in enumerate(rows, start=1)}
    layout = layout_of(cells, ".,", _place)
    if layout is None or layout.begin > HEAD:
        return None
    lines = [";".join(cell.replace(";", ",") for cell in cells[n + 1]) for n in range(layout.begin)]
    frame = pd.DataFrame.from_dict(cells, "index", dtype="str").iloc[layout.begin :].replace("", None)
    return Table(where, lines, ";", layout.decimal, layout.kinds, frame, _place)


def _text(cell: Any) -> str:
    """A cell as it would stand in a text."""
    if isinstance(cell, timedelta):
        return str(pd.Timedelta(cell))
    return "" if cell is None else " ".join(str(cell).split())


def _place(n: int, i: int) -> str:
    return f"cell {get_column_letter(i + 1)}{n}" if n else f"column {get_column_letter(i + 1)}"
