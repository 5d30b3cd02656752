"""The cells of a campaign's CSV file, and where they stand in its text: for reading and for changing it."""

import re
from collections.abc import Sized
from pathlib import Path
from typing import NamedTuple

from freerock.errors import FreerockError

SEPARATORS = ",;\t"
MARK = "\ufeff"
NEW_LINE = r"\r\n|\r|\n"
LINE = re.compile(rf"([^\r\n]*)(?:{NEW_LINE}|\Z)")
IN_QUOTES = r'"(?:[^"]|"")*+"'


class CsvCell(NamedTuple):
    """A cell of a text: where it begins and ends, and what it holds without quotes and spaces around."""

    start: int
    end: int
    value: str


def rows_in(text: str, path: str | Path) -> tuple[str, list[tuple[int, list[CsvCell]]]]:
    """What separates the cells of a text; of each row the number of its first line, and its cells.

    Comments and empty rows are left out. A comment begins with # and ends with its line, and its quotes do
    not count.

    Raises
    ------
    FreerockError
        A quote is not closed, or text follows a closed one.
    """
    separator, rows, number = "", list[tuple[int, list[CsvCell]]](), 1
    at = len(MARK) if text.startswith(MARK) else 0
    while at < len(text) and (line := LINE.match(text, at)):
        begin, at = at, line.end()
        if line[1].strip() and not line[1].lstrip().startswith("#"):
            separator = separator or next((each for each in SEPARATORS if each in line[1]), ",")
            cells, at = _row(text, begin, separator, f"{path}:{number}")
            if any(cell.value for cell in cells) and not cells[0].value.startswith("#"):
                rows.append((number, cells))
        number += len(re.findall(NEW_LINE, text[begin:at]))
    return separator, rows


def _row(text: str, at: int, separator: str, where: str) -> tuple[list[CsvCell], int]:
    """The cells of the row that begins there, and where the next row does.

    A quote counts only where a cell begins with it.
    """
    cells = list[CsvCell]()
    cell = re.compile(rf'(?P<cell>{IN_QUOTES}|(?!")[^{separator}\r\n]*)(?P<end>{separator}|{NEW_LINE}|\Z)')
    while found := cell.match(text, at):
        value = found["cell"]
        if value.startswith('"'):
            value = value[1:-1].replace('""', '"')
        cells.append(CsvCell(*found.span("cell"), value.strip()))
        at = found.end()
        if found["end"] != separator:
            return cells, at
    what = "text follows a closed quote" if re.match(IN_QUOTES, text[at:]) else "a quote is not closed"
    raise FreerockError(where, what, "check the quotes")


def wrong_length(path: str | Path, line: int, cells: Sized, header: Sized) -> FreerockError:
    """The error of a row that has not one cell for each column."""
    what = f"has {len(cells)} cells, the first line has {len(header)}"
    remedy = "put texts that hold a comma in quotes"
    if len(cells) < len(header):
        remedy = "give the missing ones, even if empty"
    return FreerockError(f"{path}:{line}", what, remedy)
