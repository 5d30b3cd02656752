"""The table in a text or on a sheet: its headings, what stands above them, and its channels."""

import csv
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice, pairwise

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError, number_of
from freerock.records import headings
from freerock.records.cells import Samples, kind_of, numbers, seconds, why_no_number
from freerock.records.channels import Channel, Even, Stamps, unfit
from freerock.records.headings import HEADINGS, SECOND_UNITS

ROWS_ALIKE = 3  # rows of numbers in a row that begin the table
ROWS_COUNTED = 100  # in which a column must count to be a counter
COMMENT = re.compile(r"^\s*(?:#|%|//|!)+\s*")
KEYED = re.compile(r"[^:=]+[:=]")  # a line such as Operator: N. N.
BESIDE = HEADINGS["steps"] | HEADINGS["start"]  # names that may stand right of the headings
RULE = re.compile(r"[\s\-=_*+|;,.#%/]*")  # a blank line, or one of dashes
WIDE = re.compile(r"\s+(?=[\[(])")  # between a name and its unit
BETWEEN = ("\t", ";", ",", " ")

Place = Callable[[int, int], str]  # how a cell is named, by its row's number and its column


def cells_of(line: str, delimiter: str) -> list[str]:
    """Cells of a line, less their blanks and quotation marks."""
    if delimiter == " ":
        return WIDE.sub("", line).replace('"', "").split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    return [cell.strip() for row in csv.reader([line], delimiter=delimiter) for cell in row]


@dataclass(frozen=True)
class Layout:
    """How a table is written.

    Parameters
    ----------
    begin : int
        Place of its first row.
    lost : int
        Number of cells of another kind than the rest of their column, and of columns of text.
    decimal : str
        The decimal mark.
    kinds : dict
        Of the columns by place: n for numbers, c for times, else why the column is left out.
    """

    begin: int
    lost: int
    decimal: str
    kinds: dict[int, str]


def layout_of(rows: Mapping[int, Sequence[str]], decimals: Iterable[str], place: Place) -> Layout | None:
    """How the table in some rows, by their numbers, is written; None where there is none.

    Of several decimal marks it is that with which the table begins first, and least is lost.
    """
    found = []
    for decimal in decimals:
        kinds = {n: [kind_of(cell, decimal) for cell in cells] for n, cells in rows.items()}
        every = [*kinds.values()]
        begin = next((k for k in range(len(every)) if _begins(every[k : k + ROWS_ALIKE])), None)
        if begin is not None:
            width = len(every[begin])
            table = [n for n in islice(kinds, begin, None) if len(kinds[n]) == width]
            columns = [_kind({n: (rows[n][i], kinds[n][i]) for n in table}) for i in range(width)]
            told = {i: f"{kind} {place(n, i)})" if n else kind for i, (kind, _, n) in enumerate(columns)}
            found.append(Layout(begin, sum(lost for _, lost, _ in columns), decimal, told))
    return min(found, key=lambda layout: (layout.begin, layout.lost), default=None)


def _kind(column: Mapping[int, tuple[str, str]]) -> tuple[str, int, int]:
    """What a column holds, what is lost of it, and the row that shows it; 0 where none needs to."""
    counted = Counter(kind for _, kind in column.values() if kind)
    marks = counted.pop("m", 0)
    usual, often = counted.most_common(1)[0] if counted else ("n" if marks else "", 0)
    odd = counted.total() - often
    if usual in ("n", "c", ""):
        return usual or "is empty", odd, 0
    row = next(n for n, (_, kind) in column.items() if kind == usual)
    cell = column[row][0]
    holds = f"dates ({cell!r}" if usual == "d" else f"no numbers ({why_no_number(cell)}"
    return f"holds {holds},", odd + (usual != "d"), row


def _begins(rows: Sequence[Sequence[str]]) -> bool:
    """Whether rows, given by the kinds of their cells, begin a table: texts only beyond the first column."""
    first = rows[0]
    if first[:1] == ["t"] or not ("n" in first or {"c", "m"} <= {*first}):
        return False
    if any(len(row) != len(first) for row in rows) or (len(first) > 1 == sum(map(bool, first))):
        return False
    columns = [{*kinds} - {""} for kinds in zip(*rows, strict=True)]
    return all(len(kinds) < 2 or kinds == {"n", "m"} for kinds in columns)


@dataclass(frozen=True)
class Table:
    """A table of numbers, and what stands above it.

    Parameters
    ----------
    where : object
        The file, or the file and its sheet.
    above : sequence of str
        The lines above the table.
    delimiter, decimal : str
        Between cells, and in numbers.
    kinds : mapping
        Of the columns by place: n for numbers, c for times, else why the column is left out.
    cells : pandas.DataFrame
        Columns of numbers or of texts; the index numbers the rows from 1, those above among them.
    place : callable
        How a cell is named, by its row's number and its column; 0 stands for the column.
    """

    where: object
    above: Sequence[str]
    delimiter: str
    decimal: str
    kinds: Mapping[int, str]
    cells: pd.DataFrame
    place: Place

    def values(self, i: int, rows: int | None = None) -> Samples:
        """A column as numbers, or as seconds since the first time; and what was found out."""
        cells = self.cells[i].head(rows) if rows else self.cells[i]
        if self.kinds[i] == "c":
            return seconds(f"{self.where}: {self.place(0, i)}", cells)[:2]
        return numbers(self.where, cells, self.decimal, lambda n: self.place(n, i))


def head_of(table: Table) -> tuple[list[tuple[str, str]], dict[str, str], list[str]]:
    """Names and units of the columns of a table, what is stated by name above it, and its other rows.

    Headings are found across blank lines, comments, dashes and what is stated by name.

    Raises
    ------
    FreerockError
        The row next above the numbers is neither of these nor names the columns; numbers above the table.
    """
    lines, kinds = table.above, table.kinds
    used = max(i for i, kind in kinds.items() if kind != "is empty") + 1
    rows: dict[int, list[str]] = {}
    crossed = False
    for n in reversed(range(len(lines))):
        if RULE.fullmatch(lines[n]):
            if not all(map(headings.of_units, rows.values())):
                break
            continue
        states = headings.states_rate(re.split("[:=;\t,]", lines[n])[0])
        cells = None if states else _fitting(lines[n], table, used)
        merged = all(map(headings.of_units, rows.values())) or len({*(cells or ())} - {""}) < used
        if cells and (not rows or (used > 1 and merged)):
            rows[n] = cells
        elif rows:
            break
        elif states or KEYED.match(lines[n]):
            crossed = True
        elif not COMMENT.match(lines[n]):
            if crossed:
                break
            sought = f"neither numbers nor {number_of(used, 'heading')}"
            what = f"line {n + 1} holds {sought}: {lines[n].strip()[:60]!r}"
            remedy = "give each column a heading, as Time [s]; Laser [V], or correct the cell"
            raise FreerockError(table.where, what, remedy)
    others = {n: line.strip() for n, line in enumerate(lines) if line.strip() and n not in rows}
    _refuse_numbers_above(table, others)
    above = [f"line {n + 1}: {line}" for n, line in others.items()]
    return headings.headed([*rows.values()][::-1], len(kinds)), stated_in(lines), above


def _refuse_numbers_above(table: Table, lines: Mapping[int, str]) -> None:
    """Refuse rows of numbers above a table, which would be lost."""
    numeric = [i for i, kind in table.kinds.items() if kind == "n"]
    for n, line in lines.items():
        here = [kind_of(cell, ".") for cell in cells_of(line, table.delimiter)]
        fits = len(here) > max(numeric, default=0) and {here[i] for i in numeric} <= {"n", "m", "c"}
        if len(numeric) > 1 and "n" in here and fits:
            raise FreerockError(table.where, f"line {n + 1} holds numbers above the table", "export it alone")


def _fitting(line: str, table: Table, used: int) -> list[str] | None:
    """The cells of a row of headings, one for each column in use; None where the row is none."""
    dates = [i for i, kind in table.kinds.items() if kind.startswith("holds dates")]
    remark = COMMENT.match(line)
    line = COMMENT.sub("", line)
    for between in dict.fromkeys([table.delimiter, *BETWEEN]):
        cells = cells_of(line, between)
        if len(cells) == used - len(dates):  # date and time, parted by a blank, under one heading
            for i in dates:
                cells.insert(i, "")
        more = cells[used:] if len(cells) > len(table.kinds) else []
        cells = cells[:used]
        if len(cells) < used or not any(cells):
            continue
        told = all(not c or "=" in c or kind_of(c, ".") == "n" or headings.plain(c) in BESIDE for c in more)
        if between != table.delimiter or (remark and between == " "):  # a remark may have as many words
            told = told and any(headings.is_time(cell) or headings.split_unit(cell)[1] for cell in cells)
        numbers = any(kind_of(cell, ".") in ("n", "c", "d") for cell in cells)
        if told and (headings.is_time(cells[0]) or not numbers):
            return cells
    return None


def stated_in(lines: Sequence[str]) -> dict[str, str]:
    """Values by name from lines such as "Sampling rate: 2000 Hz"; a value may stand below its name."""
    found: dict[str, str] = {}
    for line, below in pairwise([*lines, ""]):
        parts = re.split(r"([:=;\t,])", COMMENT.sub("", line))
        for k in range(0, len(parts), 2):
            name = parts[k].strip(' "')
            if headings.states_rate(name):
                value = "".join(parts[k + 2 :]).strip(' ":=;,\t')
                column = sum(part in ";\t," for part in parts[1:k:2])
                beneath = re.split(r"[;\t,]", below)[column : column + 1]
                found.setdefault(name, beneath[0].strip() if beneath and not value[:1].isdigit() else value)
    return found


def counts(name: str, unit: str, numbers: Floats, first: bool) -> bool:
    """Whether a column counts its samples: by its name, or without a name 0, 1, 2 …"""
    steps = np.diff(numbers)
    if numbers.size < 2 or not (steps == steps[0]).all() or steps[0] < 1 or (numbers % 1).any():
        return False
    named = {headings.plain(name), headings.plain(unit)}
    return bool(named & HEADINGS["counters"]) or (first and named == {""} and steps[0] == 1)


def channels_of(table: Table, notes: list[str], group: str = "") -> tuple[list[Channel], list[str]]:
    """Channels of a table, and the rows above it that are no headings.

    Each channel belongs to the column of time next to its left, else to the first; a sampling rate that is
    stated above counts where no column holds the time. Loading a channel adds to the notes.

    Raises
    ------
    FreerockError
        As of `head_of`; a sampling rate whose meaning is open; nothing but time.
    """
    heads, stated, above = head_of(table)
    kinds = {i: kind for i, kind in table.kinds.items() if kind != "is empty" or any(heads[i])}
    names = {i: heads[i][0] or f"column {i + 1}" for i in kinds}
    numeric = [i for i, kind in kinds.items() if kind == "n"]
    for i in numeric:
        if counts(*heads[i], table.values(i, ROWS_COUNTED)[0], first=i == numeric[0]):
            kinds[i] = "counts the samples"
    numeric = [i for i in numeric if kinds[i] == "n"]
    times = [i for i in kinds if kinds[i] == "c" or (i in numeric and headings.is_time_word(heads[i][0]))]
    if not times and len(numeric) > 1 and heads[numeric[0]][1].casefold() in SECOND_UNITS:
        times = numeric[:1]

    def load(i: int) -> Floats:
        found, told = table.values(i)
        notes.extend(told)
        return found

    clocks: dict[int, Stamps | Even] = {
        i: Stamps(names[i], partial(load, i), "s" if kinds[i] == "c" else heads[i][1]) for i in times
    }
    decimal = table.decimal if any(table.cells[i].dtype.kind != "i" for i in numeric) else ""
    also = headings.also_stated(table.where, stated, decimal) if times else ()
    if not times:
        left_out = "; ".join(f"{names[i]!r} {kind}" for i, kind in kinds.items() if kind != "n")
        none = f"no column of time and no sampling rate{left_out and f' ({left_out})'}"
        clocks[-1] = headings.stated_rate(table.where, stated, decimal) or Even(np.nan, unknown=none)
    channels = []
    for i in [i for i in kinds if i not in times]:
        clock = clocks[max((at for at in clocks if at < i), default=min(clocks))]
        own = Channel(names[i], heads[i][1], partial(load, i), clock, group, also)
        channels.append(own if kinds[i] == "n" else unfit(names[i], kinds[i], group))
    return channels, above
