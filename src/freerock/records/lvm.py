"""LabVIEW measurement files (LVM): text with a header for the file and one for each segment.

The headers are parsed here, the rows of numbers as in any other table (`table`).
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain, pairwise
from pathlib import Path

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.cells import NUMBER
from freerock.records.channels import COPY_AGAIN, Channel, Contents, Even, Stamps
from freerock.records.text import LABVIEW, Layout, encoding_of, layout_in_words, tables

FORMAT = "LVM"
MAGIC = LABVIEW.decode()
LOOK = 100  # rows in which the decimal comma is looked for
X = "X_Value"

Lines = Iterator[tuple[int, str]]  # with their numbers, from 0
Tables = Sequence[dict[int, Floats]]  # the columns of numbers of each segment


@dataclass(frozen=True)
class Segment:
    """One writing: names of its columns, cells of its header by key, layout and number of its rows."""

    names: Sequence[str]
    fields: dict[str, list[str]]
    layout: Layout
    n_rows: int

    def cell(self, key: str, column: int) -> str:
        cells = self.fields.get(key, [])
        return cells[column] if column < len(cells) else ""

    def value(self, key: str, column: int) -> float:
        """A number of the header, NaN where it gives none."""
        cell = self.cell(key, column).replace(",", ".")
        return float(cell) if NUMBER.fullmatch(cell) else np.nan

    def x_column(self, column: int) -> int | None:
        """The column of time of a channel."""
        left = [i for i in range(column) if self.names[i] == X and self.layout.kinds[i] == "n"]
        return left[-1] if left else None


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an LVM file.

    Time is the column X_Value left of a channel, where it is filled in, else X0 and Delta_X. Segments whose X
    starts again are joined by their dates and times. A file with fewer rows than a segment's Samples is
    truncated.
    """
    encoding = encoding_of(path)
    segments = _segments(path, encoding)
    first = segments[0]
    if any(s.names != first.names for s in segments):
        raise FreerockError(path, "its segments hold different channels", "split it, one file per segment")
    channels = [
        Channel(name, first.cell("Y_Unit_Label", i), i, _clock(path, segments, i), also=_stated(first, i))
        for i, name in enumerate(first.names)
        if i and name not in (X, "Comment", "")
    ]

    notes = [layout_in_words(first.layout, encoding), *_more_rows(channels, segments)]

    def read(columns: Sequence[int | tuple[str, int]]) -> dict[int | tuple[str, int], Floats]:
        parts = list(tables(path, encoding, (s.layout for s in segments), notes))
        arrays: dict[int | tuple[str, int], Floats] = {}
        for column in columns:
            if isinstance(column, tuple):
                arrays[column] = _joined_time(path, segments, parts, column[1])
            else:
                _refuse_short(path, segments, parts, column)
                arrays[column] = np.concatenate([part[column] for part in parts])
        return arrays

    yield Contents(channels, read, FORMAT, notes, _start_time(first))


def _segments(path: Path, encoding: str) -> list[Segment]:
    with open(path, encoding=encoding, errors="replace") as file:
        lines = enumerate(file)
        if not next(lines)[1].startswith(MAGIC):
            what = f"not an LVM file: its first line is not {MAGIC!r}"
            raise FreerockError(path, what, "correct the ending of its name, or copy it again")
        header = _header(path, lines, "\t", "the file")
        delimiter = next((key[9:10] for key in header if key.startswith("Separator")), "") or "\t"
        segments: list[Segment] = []
        for n, line in lines:
            if line.strip():
                where = f"segment {len(segments) + 1}"
                fields = _header(path, chain([(n, line)], lines), delimiter, where)
                segments.append(_segment(path, lines, fields, delimiter, where))
    if not segments:
        raise FreerockError(path, "the file is truncated: no segment follows its header", COPY_AGAIN)
    return segments


def _header(path: Path, lines: Lines, delimiter: str, where: str) -> dict[str, list[str]]:
    """Cells by key up to the end of a header, less its special blocks."""
    fields: dict[str, list[str]] = {}
    special = False
    for _, line in lines:
        cells = _cells(line, delimiter)
        if cells[0].startswith("***End_of_Header"):
            return fields
        special = cells[0] == "***Start_Special***" or (special and cells[0] != "***End_Special***")
        if not special:
            fields[cells[0]] = cells
    raise FreerockError(path, f"the file is truncated: the header of {where} has no end", COPY_AGAIN)


def _segment(path: Path, lines: Lines, fields: dict[str, list[str]], delimiter: str, where: str) -> Segment:
    """The rows under a segment's header, up to an empty line."""
    at, line = next(lines, (0, ""))
    names = _cells(line, delimiter)
    head, rows, more = [], 0, False
    for _, line in lines:
        more = not line.strip()
        if more:
            break
        rows += 1
        if rows <= LOOK:
            head.append(_cells(line, delimiter))
    if names[0] != X or not head:
        raise FreerockError(path, f"the file is truncated: {where} holds no data", COPY_AGAIN)
    width = max(len(names), len(head[0]))
    names += [""] * (width - len(names))
    filled = {i for row in head for i, cell in enumerate(row) if cell}
    kinds = {
        i: "n" if i in filled and name not in ("Comment", "") else "is empty" for i, name in enumerate(names)
    }
    numeric = [i for i, kind in kinds.items() if kind == "n"]
    comma = delimiter != "," and any("," in row[i] for row in head for i in numeric if i < len(row))
    layout = Layout(delimiter, "," if comma else ".", at + 1, kinds, rows if more else None)
    return Segment(tuple(names), fields, layout, rows)


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip() for cell in line.rstrip("\n").split(delimiter)]


def _clock(path: Path, segments: Sequence[Segment], column: int) -> Even | Stamps | str:
    """Clock of a channel, or why it can't be read."""
    first = segments[0]
    if first.layout.kinds[column] != "n":
        return "is empty"
    x = first.x_column(column)
    if len(segments) > 1:
        return Stamps(f"{X} of its segments", ("time", x if x is not None else column), "s")
    if x is not None and (x or first.value("Delta_X", column) == first.value("Delta_X", 1)):
        return Stamps(X, x, "s")
    step = first.value("Delta_X", column)
    if not step > 0 or (step == 1 and first.cell("Date", column)[:4] in ("1903", "1904")):
        what = f"channel {first.names[column]!r} gives no sampling rate (no {X}, and Delta_X is {step:g})"
        raise FreerockError(path, what, "write the file with one X column")
    start = first.value("X0", column)
    return Even(step, start if np.isfinite(start) else 0.0)


def _stated(segment: Segment, column: int) -> tuple[Even, ...]:
    """The interval that a header states; LabVIEW writes 1 where it knows none."""
    step = segment.value("Delta_X", column)
    return (Even(step),) if step > 0 and step != 1 else ()


def _refuse_short(path: Path, segments: Sequence[Segment], parts: Tables, column: int) -> None:
    for n, (segment, table) in enumerate(zip(segments, parts, strict=True), start=1):
        samples = segment.value("Samples", column)
        if len(table[column]) < samples:
            name, rows = segment.names[column], len(table[column])
            what = f"the file is truncated: channel {name!r} holds {rows} of {samples:.0f} samples"
            raise FreerockError(path, f"{what} in segment {n}", COPY_AGAIN)


def _more_rows(channels: Sequence[Channel], segments: Sequence[Segment]) -> list[str]:
    """A note where rows of several writings under one header, without X, are taken for one recording."""
    for c in channels:
        samples = segments[0].value("Samples", c.column)
        if isinstance(c.clock, Even) and segments[0].n_rows > samples:
            rows = segments[0].n_rows
            return [f"{rows} rows under a header of {samples:.0f} samples are taken for one recording"]
    return []


def _joined_time(path: Path, segments: Sequence[Segment], parts: Tables, column: int) -> Floats:
    """Time of several segments [s]: as written where it goes on, else by the segments' dates."""
    times: list[Floats] = []
    for segment, table in zip(segments, parts, strict=True):
        if segment.names[column] == X:
            times.append(table[column])
        else:
            start, step = np.nan_to_num(segment.value("X0", column)), segment.value("Delta_X", column)
            times.append(start + step * np.arange(len(table[column])))
    if all(after[0] > before[-1] for before, after in pairwise(times)):
        return np.concatenate(times)
    starts = [start for s in segments if (start := _started(s)) is not None]
    if len(starts) < len(segments):
        what = f"{X} starts again in its segments, and they give no date"
        raise FreerockError(path, what, "split it, one file per segment")
    return np.concatenate(
        [
            time + (start - starts[0]) / np.timedelta64(1, "s")
            for time, start in zip(times, starts, strict=True)
        ]
    )


def _started(segment: Segment) -> np.datetime64 | None:
    """Start of a segment by its Date and Time, to the nanosecond, in the zone of the laboratory."""
    date, time = segment.cell("Date", 1).replace("/", "-"), segment.cell("Time", 1).replace(",", ".")
    whole, _, fraction = time.partition(".")
    try:
        return np.datetime64(f"{date}T{whole}.{fraction[:9]:0<9}", "ns")
    except ValueError:
        return None


def _start_time(segment: Segment) -> str:
    start = _started(segment)
    return "" if start is None else str(np.datetime_as_string(start, "ms"))
