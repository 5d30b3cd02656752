"""Corrections by hand: translated between the JSON of the review page and the cells of the campaign's CSV.

`csv_edit` writes the cells. `runs.hand_corrections` tells their way to the fit.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field

from freerock.config.correction_cells import (
    WHOLE_RECORD,
    Override,
    read_exclusions,
    read_overrides,
    written_exclusions,
    written_overrides,
)
from freerock.config.mistakes import validate
from freerock.config.record import Record
from freerock.config.values import Number, Section, Text, Whole, key
from freerock.errors import FreerockError

Run = Annotated[Whole, Field(ge=1, le=999_999)]
Seconds = Annotated[Number, Field(ge=-1e9, le=1e9), AfterValidator(lambda time_s: round(time_s, 6))]


Stretch = Annotated[list[Seconds], Field(min_length=2, max_length=2)]


class Sent(Section):
    """What a page sends: no value counts as one of another type."""

    model_config = ConfigDict(strict=True)


class SentOverride(Sent):
    """A run set by hand."""

    run: Run = key("the number of the run")
    release_s: Seconds = key("its release in seconds")
    end_s: Seconds = key("its end in seconds")
    hold_s: Stretch | None = key("from when to when it is held before, in seconds, or null")


class Correction(Sent):
    """What is set by hand in a record."""

    overrides: list[SentOverride] = key("runs set by hand")
    exclude: list[Run] | Literal["record"] = key('"record" or a list of runs')
    stretches: list[Stretch] = key("stretches left out, from when to when in seconds")
    reason: Text = key("why, as a text")
    note: Text = key("a text")


def correction_of(line: Record) -> dict[str, Any]:
    """What is set by hand in a record, as JSON of the form of `Correction`."""
    return {
        "overrides": [
            {name: getattr(each, name) for name in SentOverride.model_fields}
            for each in read_overrides(line.override)
        ],
        "exclude": WHOLE_RECORD if line.excluded else [run for run, _ in line.exclusions],
        "stretches": [[from_s, to_s] for from_s, to_s, _ in line.stretches],
        "reason": line.reason,
        "note": line.note,
    }


def corrected_cells(correction: Correction, line: Record) -> dict[str, str]:
    """The cells that a correction changes in a record, by column; a cell that says the same stays as it is.

    Raises
    ------
    FreerockError
        The configuration would refuse a cell.
    """
    overrides = [_override(each) for each in correction.overrides]
    stretches = [(from_s, to_s) for from_s, to_s in correction.stretches]
    exclude = (
        WHOLE_RECORD if correction.exclude == "record" else written_exclusions(correction.exclude, stretches)
    )
    cells = {"override": line.override, "exclude": line.exclude}
    cells |= {"reason": correction.reason, "note": correction.note}
    if overrides != list(read_overrides(line.override)):
        cells["override"] = written_overrides(overrides)
    if exclude != (WHOLE_RECORD if line.excluded else written_exclusions(*read_exclusions(line.exclude))):
        cells["exclude"] = exclude
    corrected(line, cells)
    return {key: value for key, value in cells.items() if value != getattr(line, key)}


def corrected(line: Record, cells: Mapping[str, str]) -> Record:
    """The record with other cells.

    Raises
    ------
    FreerockError
        The configuration would refuse one.
    """
    problems: list[FreerockError] = []
    held = {**line.model_dump(mode="python"), **cells}
    made = validate(Record, held, lambda loc: f"{line.test}: {'.'.join(map(str, loc))}", problems)
    if made is None or problems:
        raise problems[0]
    assert isinstance(made, Record)
    return made


def _override(each: SentOverride) -> Override:
    hold_s = (each.hold_s[0], each.hold_s[1]) if each.hold_s else None
    return Override(each.run, each.release_s, each.end_s, hold_s=hold_s)
