"""What a person changed in a campaign's CSV at the review desk, or looked at there: who, when, what and why.

The log stands beside the CSV, `NAME.review.csv`: one line each, which is read by itself. A damaged one hides
no other.
"""

import csv
import getpass
import io
import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from freerock.files import read_bytes

CELLS_BY_HAND = ("exclude", "override", "reason")  # cells that say which runs there are
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
    """The log, oldest first; empty where there is none. A damaged line is left out."""
    return changes_in(read_bytes(path)) if Path(path).exists() else []


def changes_in(content: bytes) -> list[Change]:
    """The entries of a log by its bytes."""
    rows = csv.reader(content.decode("utf-8-sig", "replace").splitlines()[1:])
    return [Change(*row) for row in rows if len(row) == len(Change._fields)]


def appended(content: bytes, changes: Sequence[Change]) -> bytes:
    """The bytes of a log with further entries, each in one line."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    if not content:
        rows.writerow(Change._fields)
    rows.writerows([re.sub(r"[\r\n]+", " ", cell) for cell in change] for change in changes)
    end = b"" if not content or content.endswith(b"\n") else b"\n"
    return content + end + text.getvalue().encode()


def looked_at(changes: Sequence[Change]) -> dict[tuple[str, str], Change]:
    """Who looked at which run, by test and number: a later correction of the record requires another look."""
    found: dict[tuple[str, str], Change] = {}
    for change in changes:
        if change.cell == LOOKED_AT and change.after:
            found[change.test, change.run] = change
        elif change.cell == LOOKED_AT:
            found.pop((change.test, change.run), None)
        elif change.cell in CELLS_BY_HAND:
            found = {key: each for key, each in found.items() if key[0] != change.test}
    return found
