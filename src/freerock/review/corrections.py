"""What a person sets by hand in a record, as the page has it and as the cells of the CSV hold it."""

from collections.abc import Mapping
from typing import Any

from freerock.config.mistakes import validate
from freerock.config.override import Override, read_overrides, written_overrides
from freerock.config.record import Record
from freerock.errors import FreerockError

COLUMNS = ("exclude", "override", "reason", "note")


def correction_of(line: Record) -> dict[str, Any]:
    """What is set by hand in a record.

    Returns
    -------
    dict
        JSON: overrides, a list of run, release_s, end_s, hold_s (two instants or None) [s]; exclude, "record"
        or a list of runs; reason; note.
    """
    return {
        "overrides": [each._asdict() for each in read_overrides(line.override)],
        "exclude": "record" if line.excluded else [run for run, _ in line.exclusions],
        "reason": line.reason,
        "note": line.note,
    }


def cells_of(correction: Mapping[str, Any], line: Record) -> dict[str, str]:
    """The cells that a correction changes in a record, by column; a cell that says the same stays as it is.

    Raises
    ------
    FreerockError
        The correction has another form, or the configuration would refuse a cell.
    """
    try:
        overrides = [_override(each) for each in correction["overrides"]]
        exclude = correction["exclude"]
        runs = sorted({int(run) for run in exclude}) if exclude != "record" else []
        texts = {key: " ".join(str(correction[key]).split()) for key in ("reason", "note")}
    except (ArithmeticError, KeyError, TypeError, ValueError) as error:
        raise FreerockError(line.test, f"is no correction ({error})", "correct the fields") from error
    now = correction_of(line)
    cells = {"override": line.override, "exclude": line.exclude, **texts}
    if overrides != list(read_overrides(line.override)):
        cells["override"] = written_overrides(overrides)
    if (exclude == "record") != line.excluded or (
        exclude != "record" and runs != sorted(set(now["exclude"]))
    ):
        cells["exclude"] = "record" if exclude == "record" else ";".join(map(str, runs))
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


def _override(each: Mapping[str, Any]) -> Override:
    hold = each["hold_s"]
    hold_s = (_instant(hold[0]), _instant(hold[1])) if hold else None
    return Override(int(each["run"]), _instant(each["release_s"]), _instant(each["end_s"]), hold_s)


def _instant(time_s: Any) -> float:
    """An instant to the microsecond [s]."""
    return round(float(time_s), 6)
