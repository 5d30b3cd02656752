"""What a person changed in a campaign's CSV at the review desk, or looked at there: who, when, what and why.

The log stands beside the CSV, `NAME.review.csv`. A line is written before the CSV is changed, so that no
change is without one; the cell shows a line whose change never came about: it holds something else.
"""

import csv
import fcntl
import getpass
import io
import os
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from freerock.config.yaml_lines import read_text
from freerock.errors import FreerockError

BY_HAND = ("exclude", "override", "reason")  # cells that say which runs there are
LOOKED_AT = "looked_at"  # in place of a column: the run was looked at


class Change(NamedTuple):
    """A line of the log.

    Parameters
    ----------
    time : str
        Local time with its offset, ISO 8601.
    login : str
        Who, by login name.
    test : str
    run : str
        Number of the run that was looked at; empty for a cell, which is of the record.
    cell : str
        Column of the CSV, or `LOOKED_AT`.
    before, after : str
        What it held, and what it holds since.
    why : str
    """

    time: str
    login: str
    test: str
    run: str
    cell: str
    before: str
    after: str
    why: str


def log_of(campaign_csv: str | Path) -> Path:
    """The log beside a campaign's CSV file."""
    return Path(campaign_csv).with_suffix(".review.csv")


def changed(test: str, cell: str, before: str, after: str, why: str, run: str = "") -> Change:
    """A line of the log, by this person and now."""
    now = datetime.now().astimezone().isoformat(timespec="seconds")
    return Change(now, login(), test, run, cell, before, after, why)


def login() -> str:
    """Login name of the person at this computer."""
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return "unknown"


def read_changes(path: str | Path) -> list[Change]:
    """The log, oldest first; empty where there is none.

    A line that was cut short, as by a lack of power, is left out.

    Raises
    ------
    FreerockError
        It can't be read, or has other columns.
    """
    path = Path(path)
    if not path.exists():
        return []
    rows = [row for row in csv.reader(io.StringIO(read_text(path))) if row]
    if rows and rows[0] != list(Change._fields):
        raise FreerockError(path, "has other columns", f"write {','.join(Change._fields)} first")
    return [Change(*row) for row in rows[1:] if len(row) == len(Change._fields)]


def append_changes(path: str | Path, changes: Sequence[Change]) -> None:
    """Add lines to the log, in one write that reaches the disk.

    Raises
    ------
    FreerockError
        The log can't be written.
    """
    text = io.StringIO()
    try:
        with open(path, "a+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            size = file.seek(0, os.SEEK_END)
            if size:
                file.seek(size - 1)
                text.write("" if file.read(1) == b"\n" else "\n")
            else:
                csv.writer(text, lineterminator="\n").writerow(Change._fields)
            csv.writer(text, lineterminator="\n").writerows(changes)
            file.write(text.getvalue().encode())
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        remedy = "free some space or allow writing to the folder"
        raise FreerockError(path, f"cannot be written ({error.strerror or error})", remedy) from error


def looked_at(changes: Sequence[Change]) -> dict[tuple[str, str], Change]:
    """Who looked at which run, by test and number: a later correction of the record requires another look."""
    found: dict[tuple[str, str], Change] = {}
    for change in changes:
        if change.cell == LOOKED_AT and change.after:
            found[change.test, change.run] = change
        elif change.cell == LOOKED_AT:
            found.pop((change.test, change.run), None)
        elif change.cell in BY_HAND:
            found = {key: each for key, each in found.items() if key[0] != change.test}
    return found
