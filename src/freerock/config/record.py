"""A record: one line of a campaign's CSV file, and the reading of that file."""

import csv
from collections.abc import Iterator, Mapping, Sequence, Sized
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationInfo, field_validator

from freerock.config.correction_cells import EXCLUDED, WHOLE_RECORD, read_exclusions, read_overrides
from freerock.config.mistakes import FILL_IN, validate
from freerock.config.values import Inside, Invalid, Key, Name, Section, Text, closest, did_you_mean, key
from freerock.config.yaml_lines import read_text, text_of
from freerock.errors import FreerockError, attempt, number_of


def rows_in(text: str, path: str | Path) -> list[tuple[int, list[str]]]:
    """Number and cells of each line of a CSV file; empty lines and lines that start with # are left out.

    Raises
    ------
    FreerockError
        A quote is not closed, or text follows a closed one.
    """
    rows = []
    for number, line in enumerate(text.split("\n"), 1):
        if not line.lstrip().startswith("#"):
            try:
                cells = [cell.strip() for cell in next(csv.reader([line], strict=True), [])]
            except csv.Error as error:
                raise FreerockError(f"{path}:{number}", str(error), "check the quotes") from None
            rows += [(number, cells)] if any(cells) else []
    return rows


def wrong_length(path: str | Path, line: int, cells: Sized, header: Sized) -> FreerockError:
    """The error of a row that has not one cell for each column."""
    what = f"has {number_of(len(cells), 'cell')}, the first line has {len(header)}"
    remedy = "put texts that hold a comma in quotes"
    if len(cells) < len(header):
        remedy = "give the missing ones, even if empty"
    return FreerockError(f"{path}:{line}", what, remedy)


class Scene(NamedTuple):
    """What records share: the block, the foundation and the lasers."""

    block: str
    foundation: str
    lasers: tuple[str, ...]


class Record(Section):
    """A record: one line of config/campaigns/<name>.csv."""

    test: Name = key("the name of the record: letters, digits and _")
    file: Inside = key("the record file, inside the raw folder")
    channel: str = key(
        "the channel of the laser, or of two lasers as a;b; empty if the file has only one",
        "",
    )
    block: str = key("the name of a block")
    foundation: str = key("the name of a foundation")
    laser: str = key("the name of a laser, or of two lasers as a;b")
    exclude: str = key(EXCLUDED, "")
    override: str = key(
        "release and end of a run in seconds, and optionally its hold, as 2@12.310:19.800 hold "
        "10.000:12.200; several separated by ;",
        "",
    )
    reason: Text = key(
        "the reason of an exclusion or override; compulsory with either", "", validate_default=True
    )
    note: Text = key("a remark", "")

    @field_validator("exclude", "override")
    @classmethod
    def _understood(cls, cell: Any, info: ValidationInfo) -> Any:
        {"exclude": read_exclusions, "override": read_overrides}[str(info.field_name)](cell)
        return cell

    @field_validator("reason")
    @classmethod
    def _reason_given(cls, reason: Any, info: ValidationInfo) -> Any:
        if not reason and (info.data.get("exclude") or info.data.get("override")):
            raise Invalid("exclude or override is given without a reason", "say why")
        return reason

    @field_validator("laser")
    @classmethod
    def _a_channel_for_each(cls, laser: Any, info: ValidationInfo) -> Any:
        lasers = laser.split(";")
        channels = [name.strip() for name in info.data.get("channel", "").split(";")]
        remedy = "name a channel for each, as a;b in both columns"
        if len(lasers) > 2:
            raise Invalid(f"{laser!r} names more than two lasers", "name one or two")
        if len(channels) != len(lasers):
            raise Invalid(f"{len(lasers)} for {number_of(len(channels), 'channel')}", remedy)
        if len(set(channels)) < len(channels):
            raise Invalid(f"both are given channel {channels[0]!r}", remedy)
        return laser

    @property
    def lasers(self) -> tuple[str, ...]:
        """Name of the laser, or of the two."""
        return tuple(name.strip() for name in self.laser.split(";"))

    @property
    def scene(self) -> Scene:
        """The block, the foundation and the lasers of the record."""
        return Scene(self.block, self.foundation, self.lasers)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel of each laser, "" for the only one of the file."""
        return tuple(name.strip() for name in self.channel.split(";"))

    @property
    def excluded(self) -> bool:
        """Whether the whole record is left out."""
        return self.exclude == WHOLE_RECORD

    @property
    def exclusions(self) -> tuple[tuple[int, str], ...]:
        """(run, reason) of each run left out."""
        return tuple((run, self.reason) for run in read_exclusions(self.exclude).runs)

    @property
    def stretches(self) -> tuple[tuple[float, float, str], ...]:
        """(from [s], to [s], reason) of each stretch left out."""
        return tuple((*each, self.reason) for each in read_exclusions(self.exclude).stretches)

    @property
    def overrides(self) -> tuple[tuple[int, float, float, str, tuple[float, float] | None], ...]:
        """(run, release [s], end [s], reason, hold [s] or None) of each run set by hand."""
        return tuple((*each._replace(reason=self.reason),) for each in read_overrides(self.override))


def read_records(
    path: Path,
    names: Mapping[str, Any],
    yaml_path: Path,
    problems: list[FreerockError],
    content: bytes | None = None,
) -> list[tuple[int, Record]]:
    """The records of a CSV file with their lines; `names` are the blocks, foundations, lasers of the YAML.

    `content` counts in place of what the file holds.
    """

    table = attempt(_read_table, path, content)
    if isinstance(table, FreerockError):
        problems.append(table)
        return []
    (header_line, header), *rows = table
    faults = [FreerockError(f"{path}:{header_line}: {at}", *why) for at, *why in _header_faults(header)]
    problems += faults
    records: list[tuple[int, Record]] = []
    first_lines: dict[str, int] = {}
    for line, row in rows if not faults else ():
        if len(row) != len(header):
            problems.append(wrong_length(path, line, row, header))
            continue
        cells = dict(zip(header, row, strict=True))
        record = validate(Record, cells, partial(_in_line, f"{path}:{line}"), problems)
        records += [(line, record)] if record else []
        for column, known in names.items():
            for cell in cells[column].split(";") if column == "laser" else [cells[column]]:
                if isinstance(known, dict) and cell.strip() not in (*known, FILL_IN):
                    remedy = did_you_mean(cell, known) or f"use one of {', '.join(map(str, known))}"
                    what = f"{cell!r} is not a {column} of {yaml_path}"
                    problems.append(FreerockError(f"{path}:{line}: {column}", what, remedy))
        first = first_lines.setdefault(cells["test"].casefold(), line)
        if first != line:
            what, remedy = f"{cells['test']!r} is on line {first} already", "give each record its own name"
            problems.append(FreerockError(f"{path}:{line}: test", what, remedy))
    return records


def _in_line(line: str, loc: Key) -> str:
    """file:line: key, of a line of the CSV file."""
    return f"{line}: {'.'.join(loc)}"


def _read_table(path: Path, content: bytes | None) -> list[tuple[int, list[str]]]:
    """Number and cells of each line of a CSV file, the line of names first."""
    written = content is not None or path.exists()
    text = read_text(path) if written and content is None else text_of(content or b"", path)
    table, names = rows_in(text, path), ",".join(Record.model_fields)
    if table and not any(cell.lower() in Record.model_fields for cell in table[0][1]):
        remedy = f"begin with a line of their names, separated by commas: {names}"
        raise FreerockError(f"{path}:{table[0][0]}", "names no columns", remedy)
    if len(table) < 2:
        what = "has no record" if written else "is missing"
        raise FreerockError(path, what, f"write the line {names} and a line per record")
    return table


def _header_faults(header: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Column, what is wrong with it and what to do."""
    columns, meant = Record.model_fields, []
    for column in dict.fromkeys(header):
        if column not in columns:
            meant += closest(column, columns)
            yield column, "unknown column", did_you_mean(column, columns) or f"use {', '.join(columns)}"
        elif header.count(column) > 1:
            yield column, "column given twice", "keep one"
    for column, field in columns.items():
        if field.is_required() and column not in (*header, *meant):
            yield column, "column is missing", f"add it: {field.description}"
