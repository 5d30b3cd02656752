"""LabVIEW measurement files (LVM): text with a header for the file and one for each segment.

The headers are parsed here, the rows of numbers as in any other text.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.cells import NUMBER, numbers
from freerock.records.channels import COPY_AGAIN, Channel, Contents, Even, Stamps, unfit
from freerock.records.table import cells_of
from freerock.records.text import frame_of, layout_in_words, lines_of

MAGIC = "LabVIEW Measurement"
X = "X_Value"
Fields = dict[str, list[str]]  # cells of a header by key
NO_CHANNELS = (X, "Comment", "")
LOOK = 100  # rows in which the decimal comma is looked for
UNSET = ("1903", "1904")  # years of LabVIEW's epoch


@dataclass(frozen=True)
class Segment:
    """One writing: names of its columns, cells of its header by key, its rows, their decimal mark."""

    names: list[str]
    fields: Fields
    rows: pd.DataFrame
    decimal: str

    def cell(self, key: str, column: int) -> str:
        """A cell of the header, "" where it gives none."""
        return dict(enumerate(self.fields.get(key, []))).get(column, "")

    def value(self, key: str, column: int) -> float:
        """A number of the header, NaN where it gives none."""
        cell = self.cell(key, column).replace(",", ".")
        return float(cell) if NUMBER.fullmatch(cell) else np.nan

    def values(self, path: Path, column: int) -> Floats:
        """A column as numbers."""
        place = f"column {column + 1}"
        return numbers(path, self.rows[column], self.decimal, lambda n: f"line {n}, {place}")[0]

    def started(self) -> pd.Timestamp:
        """Its start by Date and Time, in the zone of the laboratory; NaT where it gives none."""
        date, time = self.cell("Date", 1).replace("/", "-"), self.cell("Time", 1).replace(",", ".")
        return pd.to_datetime(f"{date}T{time}", errors="coerce", format="ISO8601")


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an LVM file.

    Time is the column X_Value left of a channel, where it is filled in, else X0 and Delta_X. Segments whose X
    starts again are joined by their dates and times. A file with fewer rows than a segment's Samples is
    truncated.
    """
    lines, encoding = lines_of(path)
    segments, delimiter = _segments(path, lines)
    first = segments[0]
    if any(each.names != first.names for each in segments):
        raise FreerockError(path, "its segments hold different channels", "split it, one file per segment")
    notes = [layout_in_words(delimiter, first.decimal, encoding)]
    signals = [i for i, name in enumerate(first.names) if i and name not in NO_CHANNELS]
    channels = [_channel(path, segments, i) for i in signals]
    samples = first.value("Samples", signals[0]) if signals else 0
    if len(segments) == 1 and len(first.rows) > samples:
        notes.append(f"{len(first.rows)} rows under a header of {samples:.0f} samples are one recording")
    start = first.started()
    yield Contents(channels, "LVM", notes, "" if pd.isna(start) else start.isoformat(timespec="milliseconds"))


def _segments(path: Path, lines: Sequence[str]) -> tuple[list[Segment], str]:
    """The segments of a file, which stand between blank lines, and the delimiter of their columns."""
    if not lines[0].startswith(MAGIC):
        raise FreerockError(path, f"its first line is not {MAGIC!r}", "correct the ending of its name")
    parts = groupby(enumerate(lines), key=lambda each: bool(each[1].strip()))
    blocks = [dict(part) for filled, part in parts if filled]
    header, _ = _header(path, blocks[0], "\t", "the file")
    delimiter = next((key[9:10] for key in header if key.startswith("Separator")), "") or "\t"
    segments = []
    for n, block in enumerate(blocks[1:], start=1):
        fields, below = _header(path, block, delimiter, f"segment {n}")
        names, *first = [cells_of(line, delimiter) for line in below[: LOOK + 1]] or [[]]
        if names[:1] != [X] or not first:
            raise FreerockError(path, f"the file is truncated: segment {n} holds no data", COPY_AGAIN)
        names += [""] * (len(first[0]) - len(names))
        found = [cell for row in first for cell in row if delimiter != "," and "," in cell]
        comma = any(NUMBER.fullmatch(cell.replace(",", ".")) for cell in found)
        layout = delimiter, "," if comma else "."
        at = max(block) + 2 - len(below)
        texts = {i: name in ("Comment", "") for i, name in enumerate(names)}
        frame = frame_of(path, lines[at : max(block) + 2], at, layout, texts)
        segments.append(Segment(names, fields, frame, layout[1]))
    if not segments:
        raise FreerockError(path, "the file is truncated: no segment follows its header", COPY_AGAIN)
    return segments, delimiter


def _header(path: Path, block: Mapping[int, str], delimiter: str, where: str) -> tuple[Fields, list[str]]:
    """Cells of a header by key, and the lines below it."""
    lines = [*block.values()]
    fields: Fields = {}
    special = False
    for n, line in enumerate(lines, start=1):
        cells = cells_of(line, delimiter)
        if cells[0].startswith("***End_of_Header"):
            return fields, lines[n:]
        special = cells[0] == "***Start_Special***" or (special and cells[0] != "***End_Special***")
        if not special:
            fields[cells[0]] = cells
    raise FreerockError(path, f"the file is truncated: the header of {where} has no end", COPY_AGAIN)


def _channel(path: Path, segments: Sequence[Segment], column: int) -> Channel:
    """A channel over all segments, with its clock or why it can't be read."""
    first = segments[0]
    name, step = first.names[column], first.value("Delta_X", column)
    if not first.rows[column].notna().any():
        return unfit(name, "is empty")
    left = [i for i in range(column) if first.names[i] == X and first.rows[i].notna().any()]
    if len(segments) > 1 or (left and (left[-1] or step == first.value("Delta_X", 1))):
        clock: Even | Stamps = Stamps(X, partial(_time, path, segments, left[-1] if left else column), "s")
    elif not step > 0 or (step == 1 and first.cell("Date", column)[:4] in UNSET):
        clock = Even(np.nan, unknown=f"{name!r} has no {X} and no sampling rate (Delta_X is {step:g})")
    else:
        clock = Even(step, float(np.nan_to_num(first.value("X0", column))))
    also = (Even(step),) if step > 0 and step != 1 else ()  # LabVIEW writes 1 where it knows none
    load = partial(_samples, path, segments, column)
    return Channel(name, first.cell("Y_Unit_Label", column), load, clock, also=also)


def _samples(path: Path, segments: Sequence[Segment], column: int) -> Floats:
    """Samples of a channel over all segments."""
    for n, segment in enumerate(segments, start=1):
        samples, rows = segment.value("Samples", column), len(segment.rows)
        if rows < samples:
            what = f"channel {segment.names[column]!r} holds {rows} of {samples:.0f} samples in segment {n}"
            raise FreerockError(path, f"the file is truncated: {what}", COPY_AGAIN)
    return np.concatenate([segment.values(path, column) for segment in segments])


def _time(path: Path, segments: Sequence[Segment], column: int) -> Floats:
    """Time of several segments [s]: as written where it goes on, else by the segments' dates."""
    times: list[Floats] = []
    for each in segments:
        start, step = np.nan_to_num(each.value("X0", column)), each.value("Delta_X", column)
        written = each.names[column] == X
        times.append(each.values(path, column) if written else start + step * np.arange(len(each.rows)))
    starts = [each.started() for each in segments]
    if all(after[0] > before[-1] for before, after in pairwise(times)):
        return np.concatenate(times)
    if any(map(pd.isna, starts)):
        raise FreerockError(path, f"{X} starts again, and segments give no date", "split it by segments")
    since = [(start - starts[0]) / pd.Timedelta(1, "s") for start in starts]
    return np.concatenate([time + begun for time, begun in zip(times, since, strict=True)])
