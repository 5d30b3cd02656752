"""The table in a text or on a sheet: its headings, what stands above them, and its channels."""

import csv
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freerock.errors import FreerockError
from freerock.records.cells import kind_of, why_no_number
from freerock.records.channels import Channel, Even, Stamps
from freerock.records.headings import (
    COUNTERS,
    KEY,
    NAMES_ITS_UNIT,
    STEPS,
    also_stated,
    headed,
    is_time,
    is_time_word,
    of_units,
    plain,
    split_unit,
    stated_rate,
    states_rate,
)
from freerock.records.times import SECOND_UNITS

ROWS_ALIKE = 3  # rows of numbers in a row that begin the table
COMMENT = re.compile(r"\s*(?:#|%|//|!)+\s*")
UNIT_ALONE = {(name, unit) for word, unit in NAMES_ITS_UNIT.items() for name in (word, word.title())}
KEYED = re.compile(r"[^:=]+[:=]")  # a line such as Operator: N. N.
STARTS = {"start", "xorigin", "xoffset", "t0"}
RULE = re.compile(r"[\s\-=_*+|;,.#%/]*")  # a blank line, or one of dashes
WIDE = re.compile(r"\s+(?=[\[(])")  # between a name and its unit
BETWEEN = ("\t", ";", ",", " ")

Row = tuple[int, Sequence[str], Sequence[str]]


def cells_of(line: str, delimiter: str) -> list[str]:
    """Cells of a line, less their blanks and quotation marks."""
    if delimiter == " ":
        return WIDE.sub("", line).replace('"', "").split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    return [cell.strip() for row in csv.reader([line], delimiter=delimiter) for cell in row]


def kinds_of(where: object, rows: Sequence[Row], place: Callable[[int, int], str]) -> dict[int, str]:
    """What the columns of a table hold: n for numbers, c for times, else why a column is left out.

    Parameters
    ----------
    where : object
        The file, for errors.
    rows : sequence of (int, sequence of str, sequence of str)
        Number, cells and their kinds.
    place : callable
        How a cell is named, by its row's number and its column.

    Raises
    ------
    FreerockError
        A cell that is neither a number nor a mark in a column of numbers, or no time in one of times.
    """
    found: dict[int, str] = {}
    for i in range(len(rows[0][1])):
        kinds = {kinds[i] for _, _, kinds in rows} - {""}
        usual = next((kind for kind in "nc" if kind in kinds), "n" if kinds == {"m"} else "")
        if not kinds:
            found[i] = "is empty"
        elif kinds <= {usual, "m"}:
            found[i] = usual
        elif not usual:
            n, cells, _ = next(row for row in rows if row[2][i] in ("t", "d"))
            why = (
                f"holds dates ({cells[i]!r}"
                if "d" in kinds
                else f"holds no numbers ({why_no_number(cells[i])}"
            )
            found[i] = f"{why}, {place(n, i)})"
        else:
            n, cells, _ = next(row for row in rows if row[2][i] not in ("", "m", usual))
            raise wrong_cell(where, place(n, i), cells[i], usual)
    return found


def wrong_cell(where: object, place: str, cell: str, kind: str) -> FreerockError:
    """The refusal of a cell that is no number (n) or no time (c)."""
    why = why_no_number(cell) if kind == "n" else f"{cell[:40]!r} is not a time"
    return FreerockError(where, f"{place}: {why}", "correct the line, or export the file again")


def begins_table(rows: Sequence[Sequence[str]]) -> bool:
    """Whether rows, given by the kinds of their cells, begin a table: texts only beyond the first column."""
    first = rows[0]
    return (
        first[:1] != ["t"]
        and ("n" in first or {"c", "m"} <= {*first})
        and all(len(row) == len(first) for row in rows)
        and all(
            len({*kinds} - {""} - ({"m"} if "n" in kinds else set())) < 2 for kinds in zip(*rows, strict=True)
        )
    )


@dataclass(frozen=True)
class Head:
    """What stands above a table: names and units of its columns, what is stated by name, other rows."""

    headings: list[tuple[str, str]]
    stated: dict[str, str]
    above: list[str]


def head_of(
    where: object, lines: Sequence[str], delimiter: str, kinds: Mapping[int, str], place: str
) -> Head:
    """The rows above a table.

    Headings are found across blank lines, comments, dashes and what is stated by name.

    Raises
    ------
    FreerockError
        The row next above the numbers is neither of these nor names the columns.
    """
    used = max(i for i, kind in kinds.items() if kind != "is empty") + 1
    dates = [i for i, kind in kinds.items() if kind.startswith("holds dates") and delimiter == " "]
    rows: list[list[str]] = []
    taken: list[int] = []
    crossed = False
    for n in reversed(range(len(lines))):
        if RULE.fullmatch(lines[n]):
            if rows and not all(of_units(row) for row in rows):
                break
            continue
        states = states_rate({re.split("[:=;\t,]", lines[n])[0]: 1.0})
        cells = None if states else _fitting(lines[n], delimiter, used, len(kinds), dates)
        shared = all(of_units(row) for row in rows) or len({*(cells or [])} - {""}) < used
        if cells is not None and (used > 1 or not rows) and shared:
            rows.insert(0, cells)
            taken.append(n)
        elif rows:
            break
        elif states or KEYED.match(lines[n]):
            crossed = True
        elif not COMMENT.match(lines[n]):
            if crossed:
                break
            kinds_here = [kind_of(cell, ".") for cell in cells_of(lines[n], delimiter)]
            if len(kinds_here) == len(kinds) and {"n", "t"} <= {*kinds_here}:
                bad = cells_of(lines[n], delimiter)[kinds_here.index("t")]
                raise wrong_cell(where, f"{place} {n + 1}, column {kinds_here.index('t') + 1}", bad, "n")
            shown = lines[n].strip()[:60]
            what = f"{place} {n + 1} is above the numbers and does not name {used} columns: {shown!r}"
            raise FreerockError(where, what, "give each column a heading, as Time [s]; Laser [V]")
    numeric = [i for i, kind in kinds.items() if kind == "n"]
    for n in {*range(len(lines))} - {*taken}:
        here = [kind_of(cell, ".") for cell in cells_of(lines[n], delimiter)]
        if (
            len(numeric) > 1
            and len(here) > max(numeric)
            and "n" in here
            and {here[i] for i in numeric} <= {"n", "m"}
        ):
            what = f"{place} {n + 1} holds numbers above the table that begins at {place} {len(lines) + 1}"
            raise FreerockError(where, what, "export the columns of numbers alone, under one row of headings")
    above = [
        f"{place} {n + 1}: {line.strip()}" for n, line in enumerate(lines) if line.strip() and n not in taken
    ]
    return Head(headed(rows, len(kinds)), stated_in(lines), above)


def _fitting(line: str, delimiter: str, used: int, width: int, dates: Sequence[int]) -> list[str] | None:
    """The cells of a row of headings, one for each column; None where the row is none."""
    comment = COMMENT.match(line)
    line = line[comment.end() :] if comment else line
    for between in dict.fromkeys([delimiter, *BETWEEN]):
        cells = cells_of(line, between)
        if len(cells) == used - len(dates):  # date and time, parted by a blank, under one heading
            for i in dates:
                cells.insert(i, "")
        if len(cells) < used:
            continue
        while len(cells) > used and not cells[-1]:
            cells.pop()
        more = [] if len(cells) <= width else cells[used:]
        told = all(not c or "=" in c or kind_of(c, ".") == "n" or plain(c) in STEPS | STARTS for c in more)
        numbers = any(kind_of(cell, ".") in ("n", "c", "d") for cell in cells[:used])
        words = between != delimiter or (comment and between == " ")  # a remark may have as many words
        told = told and (not words or any(is_time(cell) or split_unit(cell)[1] for cell in cells[:used]))
        if told and any(cells[:used]) and (is_time(cells[0]) or not numbers):
            return cells[:used]
    return None


def stated_in(lines: Sequence[str]) -> dict[str, str]:
    """Values by name from lines such as "Sampling rate: 2000 Hz"; a value may stand below its name."""
    found: dict[str, str] = {}
    for n, line in enumerate(lines):
        parts = re.split(r"([:=;\t,])", COMMENT.sub("", line, count=1) if COMMENT.match(line) else line)
        for k in range(0, len(parts) - 2, 2):
            name = parts[k].strip(' "')
            if states_rate({name: 1.0}):
                value = "".join(parts[k + 2 :]).strip(' "').lstrip(":=;,\t ")
                below = re.split(r"[;\t,]", lines[n + 1]) if n + 1 < len(lines) else []
                column = sum(part in ";\t," for part in parts[1 : k + 1 : 2])
                if not value[:1].isdigit() and column < len(below):
                    value = below[column].strip()
                found.setdefault(name, value)
    return found


def counts(name: str, unit: str, values: ArrayLike, first: bool) -> bool:
    """Whether a column counts its samples: by its name, or without a name 0, 1, 2 …"""
    numbers = np.asarray(values, float)
    steps = np.diff(numbers)
    if numbers.size < 2 or not (steps == steps[0]).all() or steps[0] < 1 or (numbers % 1).any():
        return False
    named = {plain(name), plain(unit)} & COUNTERS
    return bool(named) or (first and not name and not unit and steps[0] == 1)


def columns(
    path: object,
    head: Head,
    kinds: Mapping[int, str],
    numbers: Mapping[int, ArrayLike],
    decimal: str = ".",
    group: str = "",
) -> list[Channel]:
    """Channels of a table.

    Parameters
    ----------
    head : Head
        What stands above it; a sampling rate counts where no column holds the time.
    kinds : mapping
        Of columns by place: n for numbers, c for times, else why the column is left out.
    numbers : mapping
        The first numbers of these columns.
    decimal : str
        The decimal mark of the file; "" where it uses none.
    group : str
        Of these channels; their columns are named (group, column).

    Returns
    -------
    list of Channel
        Each belongs to the column of time next to its left, else to the first one.

    Raises
    ------
    FreerockError
        A sampling rate whose meaning is open; nothing but time.
    """
    headings, stated = head.headings, head.stated
    first_column = min(numbers, default=0)
    kinds = {
        i: "counts the samples"
        if kind == "n" and counts(*headings[i], numbers[i], i == first_column)
        else kind
        for i, kind in kinds.items()
    }
    numeric = [i for i, kind in kinds.items() if kind == "n"]
    clocks = [i for i, kind in kinds.items() if kind == "c"]
    times = sorted(
        [*clocks, *(i for i in numeric if is_time_word(headings[i][0]) or headings[i] in UNIT_ALONE)]
    )
    if not times and numeric and headings[numeric[0]][1].casefold() in SECOND_UNITS and len(numeric) > 1:
        times = numeric[:1]
    rate = None if times else stated_rate(path, stated, decimal)
    also = also_stated(path, stated, decimal) if times else ()
    kinds = {i: kind for i, kind in kinds.items() if kind != "is empty" or any(headings[i])}
    found: list[tuple[str, str, int, Stamps | str | None]] = []
    clock: Stamps | None = None
    for i in sorted(kinds):
        name, unit = headings[i]
        name = name or f"column {i + 1}"
        if i in times:
            clock = Stamps(name, (group, i), "s" if i in clocks else unit)
        else:
            found.append((name, unit, i, clock if kinds[i] == "n" else kinds[i]))
    first: Stamps | Even | None = (
        next((left for *_, left in found if isinstance(left, Stamps)), clock) or rate
    )
    if not any(kinds[i] == "n" for _, _, i, _ in found):
        left = "; ".join(f"{name!r} {kinds[i]}" for name, _, i, _ in found)
        raise FreerockError(
            path, "no channel beside the time" + f" ({left})" * bool(left), "export one as numbers"
        )
    if first is None:
        told = "; ".join(f"{name!r} {kinds[i]}" for name, _, i, _ in found if kinds[i] not in ("n", "c"))
        what = f"no column of time and no sampling rate{f' ({told})' * bool(told)}"
        first = Even(
            0.0, asked=(what, f"head the time as time [s], or state Sampling rate: 2000 Hz above{KEY}")
        )
    names = _distinct(name for name, *_ in found)
    return [
        Channel(name, unit, (group, i), left or first, group, also)
        for name, (_, unit, i, left) in zip(names, found, strict=True)
    ]


def _distinct(names: Iterable[str]) -> list[str]:
    """Names with (2), (3) … after repeated ones."""
    seen: dict[str, int] = {}
    distinct = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        distinct.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return distinct
