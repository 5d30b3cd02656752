"""Tables of numbers in text: CSV, TSV and the like, their delimiter and decimal mark found out."""

import codecs
import io
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.cells import SPECIAL, kind_of, mark, with_plain_marks
from freerock.records.channels import COPY_AGAIN, Contents
from freerock.records.table import ROWS_ALIKE, begins_table, cells_of, columns, head_of, kinds_of, wrong_cell
from freerock.records.times import seconds, start

FORMAT = "text"
LABVIEW = b"LabVIEW Measurement"
HEAD = 1 << 16  # characters in which encoding and layout are found
DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "spaces"}
DECIMALS = {".": "point", ",": "comma"}
LINES_AT_ONCE = 4096
BEGINS = 1000  # lines in which the table begins
OTHERS = {b"|CF,": "imc FAMOS", b"DIAEXTENDED": "DIAdem", b"\xd0\xcf\x11\xe0": "Excel 97", b"PK\3\4": "zip"}


@dataclass(frozen=True)
class Layout:
    """How a table is written.

    Parameters
    ----------
    delimiter, decimal : str
        Between the columns, and in its numbers.
    first, rows : int
        Number of lines before the table, and of its own; None for all to the end.
    kinds : mapping
        Of the columns by place: n for numbers, c for times, else why the column is left out.
    """

    delimiter: str
    decimal: str
    first: int
    kinds: Mapping[int, str]
    rows: int | None = None


def is_labview(path: Path) -> bool:
    """Whether a text has the header of a LabVIEW measurement file."""
    with open(path, "rb") as file:
        return file.read(len(LABVIEW)) == LABVIEW


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a table of numbers in text.

    A column of time is recognised by its heading or by its times (09:30:00.125, after a date or not); else
    the lines above the table must state the sampling rate ("sampling rate: 2000 Hz", "dt = 0.0005").
    """
    encoding = encoding_of(path)
    with open(path, encoding=encoding, errors="replace") as file:
        lines = file.read(HEAD).split("\n")
        complete = not file.read(1)
    if not complete and len(lines) > 1:
        lines.pop()
    layout = _layout(path, lines)
    head = head_of(path, lines[: layout.first], layout.delimiter, layout.kinds, "line")
    sample = [cells_of(line, layout.delimiter) for line in lines[layout.first :] if line.strip()]
    sample = [row for row in sample if len(row) == len(layout.kinds)]
    point = layout.decimal if any(layout.decimal in cell for row in sample for cell in row) else ""
    numbers = {
        i: [_number(row[i], layout.decimal) for row in sample] for i, k in layout.kinds.items() if k == "n"
    }
    channels = columns(path, head, layout.kinds, numbers, point)
    notes = [layout_in_words(layout, encoding)]

    def read(wanted: Sequence[tuple[str, int]]) -> dict[tuple[str, int], Floats]:
        (found,) = tables(path, encoding, [layout], notes)
        return {place: found[place[1]] for place in wanted}

    dated = (start(row[i] for row in sample) for i, kind in layout.kinds.items() if kind == "c")
    yield Contents(channels, read, FORMAT, notes, next(filter(None, dated), ""), head.above)


def layout_in_words(layout: Layout, encoding: str) -> str:
    """What was found out about a table, in words."""
    delimiter = DELIMITERS.get(layout.delimiter, repr(layout.delimiter))
    return f"columns between {delimiter}, decimal {DECIMALS[layout.decimal]}, {encoding}"


def encoding_of(path: Path) -> str:
    """Encoding by the byte order mark, else UTF-8 where the head of the file is, else Windows-1252.

    Raises
    ------
    FreerockError
        The file is no text.
    """
    with open(path, "rb") as file:
        head = file.read(HEAD)
    for mark_, name in [
        (codecs.BOM_UTF8, "utf-8-sig"),
        (codecs.BOM_UTF16_LE, "utf-16"),
        (codecs.BOM_UTF16_BE, "utf-16"),
    ]:
        if head.startswith(mark_):
            return name
    if program := next((name for magic, name in OTHERS.items() if head.startswith(magic)), ""):
        raise FreerockError(path, f"the file is of {program}, not a text", "export it as CSV, TDMS or .xlsx")
    if b"\0" in head:
        raise FreerockError(path, "the file is binary, not a text", "export it as CSV, TDMS or .xlsx")
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"


def tables(
    path: Path, encoding: str, layouts: Iterable[Layout], notes: list[str]
) -> Iterator[dict[int, Floats]]:
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
            lines = _Lines(islice(file, layout.rows), layout.delimiter)
            yield _numbers(path, encoding, layout, lines, notes)
            at = layout.first + (layout.rows or 0)
            for cell, often in lines.marks.items():
                notes.append(f"{often} cells marked {cell!r} are missing samples")


class _Lines(io.TextIOBase):
    """Lines as the file that pandas wants, with plain marks."""

    def __init__(self, lines: Iterator[str], delimiter: str) -> None:
        self.lines, self.delimiter = lines, delimiter
        self.marks: dict[str, int] = {}

    def read(self, size: int | None = -1) -> str:
        text = "".join(islice(self.lines, LINES_AT_ONCE))
        if SPECIAL.search(text):
            text, marks = with_plain_marks(text, self.delimiter)
            self.marks |= {cell: self.marks.get(cell, 0) + n for cell, n in marks.items()}
        return text


def _numbers(path: Path, encoding: str, layout: Layout, lines: _Lines, notes: list[str]) -> dict[int, Floats]:
    numeric = [i for i, kind in layout.kinds.items() if kind == "n"]
    try:
        table = pd.read_csv(
            lines,
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            decimal=layout.decimal,
            names=range(len(layout.kinds)),
            index_col=False,
            dtype={i: float if kind == "n" else str for i, kind in layout.kinds.items()},
            skipinitialspace=True,
        )
    except (ValueError, pd.errors.ParserError) as error:
        raise _fault(path, encoding, layout) or error from None
    found = {i: table[i].to_numpy() for i in numeric}
    for i in (i for i, kind in layout.kinds.items() if kind == "c"):
        found[i], told = seconds(f"{path}: column {i + 1}", table[i])
        notes += told
    unended, short = _cut(path) if layout.rows is None else (False, False)
    if unended and table.iloc[-1, numeric].isna().any():
        raise FreerockError(path, "the file is truncated: its last line is incomplete", COPY_AGAIN)
    return {i: column[: len(table) - (unended and short)] for i, column in found.items()}


def _fault(path: Path, encoding: str, layout: Layout) -> FreerockError | None:
    """The first line that breaks the table, as an error."""
    wanted = {i: kind for i, kind in layout.kinds.items() if kind in ("n", "c")}
    with open(path, encoding=encoding, errors="replace") as file:
        end = layout.rows and layout.first + layout.rows
        for n, line in enumerate(islice(file, layout.first, end), start=layout.first + 1):
            cells = cells_of(line, layout.delimiter)
            for i, kind in wanted.items():
                if i < len(cells) and kind_of(cells[i], layout.decimal) not in ("", "m", kind):
                    return wrong_cell(path, _place(n, i), cells[i], kind)
            if len(cells) > len(layout.kinds):
                what = f"line {n} has {len(cells)} cells instead of {len(layout.kinds)}"
                return FreerockError(path, what, "correct the line, or export the file again")
    return None


def _cut(path: Path) -> tuple[bool, bool]:
    """Whether the last line does not end, and whether it is shorter than the one above."""
    with open(path, "rb") as file:
        file.seek(max(0, file.seek(0, 2) - HEAD))
        end = file.read().rstrip(b"\0")  # of a line's end in two bytes
    above, last = ([b"", b"", *(line for line in re.split(rb"[\r\n]+", end) if line)])[-2:]
    return not end.endswith((b"\r", b"\n")), len(last) < len(above)


def _layout(path: Path, lines: Sequence[str]) -> Layout:
    """How the table is written whose columns of text are fewest, and which begins first.

    Raises
    ------
    FreerockError
        No table, one whose decimal mark changes, or is not told by whole numbers between commas.
    """
    found: list[tuple[bool, int, int, Layout]] = []
    faults: list[tuple[int, str, FreerockError]] = []
    for delimiter in DELIMITERS:
        split = [(n + 1, cells_of(line, delimiter)) for n, line in enumerate(lines) if line.strip()]
        for decimal in [m for m in DECIMALS if m != delimiter or any('"' in line for line in lines)]:
            head = [[kind_of(cell, decimal) for cell in cells] for _, cells in split[:BEGINS]]
            n = next((n for n in range(len(head)) if begins_table(head[n : n + ROWS_ALIKE])), None)
            if n is None:
                continue
            first, width = split[n][0] - 1, len(head[n])
            rows = ((number, cells) for number, cells in split[n:] if len(cells) == width)
            try:
                kinds = kinds_of(
                    path, [(m, cells, [kind_of(c, decimal) for c in cells]) for m, cells in rows], _place
                )
            except FreerockError as error:
                faults.append((first, delimiter, error))
                continue
            texts = sum("no numbers" in kind for kind in kinds.values())
            found.append((width == 1, texts, first, Layout(delimiter, decimal, first, kinds)))
    if not found:
        remedy = "export rows of numbers between tabs, semicolons or commas"
        raise (
            faults[0][2] if faults else FreerockError(path, "no table of numbers in its first lines", remedy)
        )
    layout = min(found, key=lambda each: each[:3])[3]
    for first, delimiter, fault in faults:
        if first < layout.first and delimiter == layout.delimiter:  # rows that would be lost
            raise fault
    if layout.delimiter == "," and len(layout.kinds) % 2 == 0:
        _refuse_ambiguous(path, lines, layout)
    return layout


def _refuse_ambiguous(path: Path, lines: Sequence[str], layout: Layout) -> None:
    """Refuse whole numbers between commas under half as many headings, or none: maybe decimal commas."""
    row = next(line for line in lines[layout.first :] if line.strip())
    whole = all(re.fullmatch(r"[-+]?\d*|(?:.* )?\d\d?:\d\d:\d\d", cell) for cell in cells_of(row, ","))
    above = lines[layout.first - 1] if layout.first else ""
    headings = len(cells_of(above, ",")) if above.strip() else 0
    if whole and '"' not in row and headings in (0, len(layout.kinds) // 2):
        what = f"line {layout.first + 1} may hold {len(layout.kinds)} columns, or decimal commas"
        remedy = "export with tabs or semicolons between the columns, or decimal points"
        raise FreerockError(path, what, remedy)


def _place(n: int, i: int) -> str:
    return f"line {n}, column {i + 1}"


def _number(cell: str, decimal: str) -> float:
    if kind_of(cell, decimal) == "n":
        return float(cell.replace(decimal, "."))
    value = mark(cell)
    return np.nan if value is None else value
