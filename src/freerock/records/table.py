"""Rows of numbers in a text file, parsed by pandas: what `text` and `lvm` share.

A row with too many cells, or a cell that is no number, is an error; an empty cell is a missing sample.
"""

import codecs
import csv
import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN
from freerock.records.dates import CLOCK, DATE_PATTERN, seconds
from freerock.records.headings import NUMBER, WANTED

HEAD = 1 << 16  # characters in which encoding and layout are found
DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "spaces"}
LINES_AT_ONCE = 4096
DECIMALS = {".": "point", ",": "comma"}


@dataclass(frozen=True)
class Layout:
    """How a table is written.

    Parameters
    ----------
    delimiter, decimal : str
        Between the columns, and in its numbers.
    first, rows : int
        Number of lines before the table, and of its own; None for all to the end.
    width : int
        Number of columns.
    numeric, clocks : tuple of int
        The columns of numbers, and those of times, with or without dates.
    texts : int
        Number of columns of anything else.
    """

    delimiter: str
    decimal: str
    first: int
    width: int
    numeric: tuple[int, ...]
    rows: int | None = None
    clocks: tuple[int, ...] = ()
    texts: int = 0


def layout_in_words(layout: Layout, encoding: str) -> str:
    """What was found out about a table, in words."""
    delimiter = DELIMITERS.get(layout.delimiter, repr(layout.delimiter))
    return f"columns between {delimiter}, decimal {DECIMALS[layout.decimal]}, {encoding}"


def encoding_of(path: Path) -> str:
    """Encoding by the byte order mark, else UTF-8 where the head of the file is, else Windows-1252."""
    with open(path, "rb") as file:
        head = file.read(HEAD)
    for mark, name in [
        (codecs.BOM_UTF8, "utf-8-sig"),
        (codecs.BOM_UTF16_LE, "utf-16"),
        (codecs.BOM_UTF16_BE, "utf-16"),
    ]:
        if head.startswith(mark):
            return name
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"


def cells_of(line: str, delimiter: str) -> list[str]:
    """Cells of a line, less their blanks and quotation marks."""
    if delimiter == " ":
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    return [cell.strip() for row in csv.reader([line], delimiter=delimiter) for cell in row]


def tables(path: Path, encoding: str, layouts: Iterable[Layout]) -> Iterator[dict[int, Floats]]:
    """Yield the columns of numbers of each table of a file, in one pass.

    A last line that does not end and is shorter than the one above is left out: its number may be cut.

    Raises
    ------
    FreerockError
        A cell that is no number, a row with too many cells, a last line that is cut off.
    """
    with open(path, encoding=encoding, errors="replace") as file:
        at = 0
        for layout in layouts:
            for _ in islice(file, layout.first - at):
                pass
            yield _numbers(path, encoding, layout, _Lines(islice(file, layout.rows)))
            at = layout.first + (layout.rows or 0)


class _Lines(io.TextIOBase):
    """Lines as the file that pandas wants."""

    def __init__(self, lines: Iterator[str]) -> None:
        self.lines = lines

    def read(self, size: int | None = -1) -> str:
        return "".join(islice(self.lines, LINES_AT_ONCE))


def _numbers(path: Path, encoding: str, layout: Layout, lines: _Lines) -> dict[int, Floats]:
    try:
        table = pd.read_csv(
            lines,
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            decimal=layout.decimal,
            names=range(layout.width),
            index_col=False,
            dtype={i: float if i in layout.numeric else str for i in range(layout.width)},
            skipinitialspace=True,
        )
        clocks = {i: seconds(f"{path}: column {i + 1}", table[i]) for i in layout.clocks}
    except (ValueError, pd.errors.ParserError) as error:
        raise _fault(path, encoding, layout) or error from None
    n, last = len(table), table.iloc[-1, list(layout.numeric)]
    unended, short = _cut(path) if layout.rows is None else (False, False)
    if unended and last.isna().any():
        raise FreerockError(path, "the file is truncated: its last line is incomplete", COPY_AGAIN)
    n -= unended and short
    return {i: table[i].to_numpy()[:n] for i in layout.numeric} | {i: each[:n] for i, each in clocks.items()}


def kind_of(cell: str, decimal: str) -> str:
    """n for a number, c for a clock's time, t for other text, nothing for an empty cell or a date alone."""
    if not cell or DATE_PATTERN.fullmatch(cell):
        return ""
    if CLOCK.fullmatch(cell):
        return "c"
    right = decimal == "." or "." not in cell
    return "n" if right and NUMBER.fullmatch(cell.replace(decimal, ".")) else "t"


def _fault(path: Path, encoding: str, layout: Layout) -> FreerockError | None:
    """The first line that breaks the table, as an error."""
    wanted = dict.fromkeys(layout.numeric, "n") | dict.fromkeys(layout.clocks, "c")
    with open(path, encoding=encoding, errors="replace") as file:
        end = layout.rows and layout.first + layout.rows
        for n, line in enumerate(islice(file, layout.first, end), start=layout.first + 1):
            cells = cells_of(line, layout.delimiter)
            for i, kind in wanted.items():
                if i < len(cells) and kind_of(cells[i], layout.decimal) not in ("", kind):
                    what = f"line {n}, column {i + 1}: {cells[i][:40]!r} is not {WANTED[kind]}"
                    return FreerockError(path, what, "correct the line, or export the file again")
            if len(cells) > layout.width:
                what = f"line {n} has {len(cells)} cells instead of {layout.width}"
                return FreerockError(path, what, "correct the line, or export the file again")
    return None


def _cut(path: Path) -> tuple[bool, bool]:
    """Whether the last line does not end, and whether it is shorter than the one above."""
    with open(path, "rb") as file:
        file.seek(max(0, file.seek(0, 2) - HEAD))
        end = file.read().rstrip(b"\0")  # of a line's end in two bytes
    above, last = ([b"", b"", *(line for line in re.split(rb"[\r\n]+", end) if line)])[-2:]
    return not end.endswith((b"\r", b"\n")), len(last) < len(above)
