"""Tables of numbers in text: CSV, TSV and the like, their delimiter and decimal mark found out."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records import lvm, table
from freerock.records.channels import Contents
from freerock.records.dates import CLOCK, start
from freerock.records.headings import columns, headed, rises, states_rate
from freerock.records.table import Layout

FORMAT = "text"
ROWS_ALIKE = 3  # rows of numbers in a row that begin the table


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a table of numbers in text.

    A column of time is recognised by its heading, by its clock times (09:30:00.125, after a date or not), or
    because it is the first one and rises steadily; else the lines above the table must state the sampling
    rate ("sampling rate: 2000 Hz", "dt = 0.0005"), whose unit may stand in the next cell. Of several columns
    of time, each belongs to the columns at its right.
    """
    encoding = table.encoding_of(path)
    with open(path, encoding=encoding, errors="replace") as file:
        lines = file.read(table.HEAD).split("\n")
        complete = not file.read(1)
    if lines[0].startswith(lvm.MAGIC):
        with lvm.contents(path) as of_labview:
            yield of_labview
        return
    if not complete and len(lines) > 1:
        lines.pop()
    layout = _layout(path, lines)
    headings = _headings(lines, layout)
    sample = [table.cells_of(line, layout.delimiter) for line in lines[layout.first :] if line.strip()]
    first = [_number(row[layout.numeric[0]], layout.decimal) for row in sample if len(row) == layout.width]
    stated = _stated(lines[: layout.first])
    channels, notes = columns(path, headings, layout.numeric, layout.clocks, rises(first), stated)

    def read(wanted: Sequence[tuple[str, int]]) -> dict[tuple[str, int], Floats]:
        (found,) = table.tables(path, encoding, [layout])
        return {place: found[place[1]] for place in wanted}

    dated = [start(row[i] for row in sample if len(row) == layout.width) for i in layout.clocks]
    begun, of_dates = next((each for each in dated if any(each)), ("", ""))
    notes = [table.layout_in_words(layout, encoding), *notes, *([of_dates] if of_dates else [])]
    yield Contents(channels, read, FORMAT, notes, begun)


def _layout(path: Path, lines: Sequence[str]) -> Layout:
    found = [
        layout
        for delimiter in table.DELIMITERS
        for decimal in table.DECIMALS
        if delimiter != decimal and (layout := _table(lines, delimiter, decimal))
    ]
    if not found:
        remedy = "export rows of numbers between tabs, semicolons or commas"
        raise FreerockError(path, "no table of numbers in its first lines", remedy)
    wide = [layout for layout in found if layout.width > 1]
    layout = min(wide or found, key=lambda layout: (layout.texts, layout.first))
    _refuse_another_mark_above(path, layout, found)
    if layout.delimiter == "," and layout.width % 2 == 0:
        _refuse_ambiguous(path, lines, layout)
    return layout


def _refuse_another_mark_above(path: Path, layout: Layout, found: Sequence[Layout]) -> None:
    """Refuse rows of numbers above the table, alike but for their decimal mark: they would be lost."""
    for other in found:
        if other.first < layout.first and (other.delimiter, other.width) == (layout.delimiter, layout.width):
            marks = f"from decimal {table.DECIMALS[other.decimal]} to {table.DECIMALS[layout.decimal]}"
            what = f"the numbers change {marks} at line {layout.first + 1}"
            raise FreerockError(path, what, "export the file again, in one go")


def _refuse_ambiguous(path: Path, lines: Sequence[str], layout: Layout) -> None:
    """Refuse whole numbers between commas under half as many headings, or none: maybe decimal commas."""
    row = next(line for line in lines[layout.first :] if line.strip())
    whole = all(re.fullmatch(r"[-+]?\d*", cell) or _whole_second(cell) for cell in table.cells_of(row, ","))
    above = lines[layout.first - 1] if layout.first else ""
    headings = len(table.cells_of(above, ",")) if above.strip() else 0
    if whole and headings in (0, layout.width // 2):
        what = f"line {layout.first + 1} may hold {layout.width} columns, or decimal commas"
        raise FreerockError(
            path, what, "export with tabs or semicolons between the columns, or decimal points"
        )


def _whole_second(cell: str) -> bool:
    return bool(CLOCK.fullmatch(cell)) and not re.search(r":\d\d[.,]", cell)


def _table(lines: Sequence[str], delimiter: str, decimal: str) -> Layout | None:
    """Layout of the first rows of numbers alike, if there are any."""
    rows = [(n, table.cells_of(line, delimiter)) for n, line in enumerate(lines) if line.strip()]
    kinds = [[table.kind_of(cell, decimal) for cell in cells] for _, cells in rows]
    for n, (line, cells) in enumerate(rows):
        here = kinds[n : n + ROWS_ALIKE]
        if not all(_alike(here[0], kind) for kind in here):
            continue
        body = list(zip(*(kind for kind in kinds[n:] if len(kind) == len(cells)), strict=True))
        numeric, clocks = (
            tuple(i for i, column in enumerate(body) if kind in column and here[0][i] in ("", kind))
            for kind in "nc"
        )
        texts = sum("t" in column for column in body)
        return Layout(delimiter, decimal, line, len(cells), numeric, clocks=clocks, texts=texts)
    return None


def _alike(first: Sequence[str], other: Sequence[str]) -> bool:
    """Whether two rows can be of one table of numbers: texts only beyond the first column."""
    return (
        first[0] != "t"
        and "n" in first
        and len(first) == len(other)
        and all(not a or not b or a == b for a, b in zip(first, other, strict=True))
    )


def _number(cell: str, decimal: str) -> float:
    return float(cell.replace(decimal, ".")) if table.kind_of(cell, decimal) == "n" else np.nan


def _headings(lines: Sequence[str], layout: Layout) -> list[tuple[str, str]]:
    """Names and units of the columns."""
    first = layout.first
    rows: list[list[str]] = []
    while first and lines[first - 1].strip() and (layout.width > 1 or not rows):
        line = lines[first - 1].lstrip("#%/ ")
        cells = table.cells_of(line, layout.delimiter)
        values = any(table.kind_of(cell, layout.decimal) in ("n", "c") for cell in cells)
        if len(cells) != layout.width or values or states_rate(_stated([line])):
            break
        rows.insert(0, cells)
        first -= 1
    return headed(rows, layout.width)


def _stated(lines: Iterable[str]) -> dict[str, str]:
    """Values by name from lines such as "Sampling rate: 2000 Hz"."""
    stated = (re.split(r"[:=;\t,]", line.lstrip("#%/ "), maxsplit=1) for line in lines)
    return {pair[0].strip(): pair[1].strip() for pair in stated if len(pair) == 2}
