"""Single cells of a campaign's CSV file are changed; all else stays as it is, byte for byte.

The bytes that are no cell to be changed are never taken apart and put together again: order, quotes,
comments, line ends, a mark of the byte order and further columns stay as a person or a program wrote them.
"""

import fcntl
import hashlib
import os
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from freerock.config.record import CsvCell, rows_in, wrong_length
from freerock.errors import FreerockError
from freerock.files import write_bytes

KEY = "test"  # the column that names a record
READ_AGAIN = "read the file again; what was not saved is kept"


class Edit(NamedTuple):
    """A cell and what it is to hold."""

    test: str
    column: str
    value: str


@dataclass(frozen=True)
class CsvText:
    """A CSV file taken apart.

    Parameters
    ----------
    text : str
        All of it; bytes that are no UTF-8 as lone surrogates, so that they come back as they were.
    separator : str
        Between cells.
    header : list of CsvCell
    rows : dict of str to list of CsvCell
        The cells of each record by its test; of a name that is given twice, the first.
    twice : set of str
        Names that are given twice.
    """

    text: str
    separator: str
    header: list[CsvCell]
    rows: dict[str, list[CsvCell]] = field(default_factory=dict)
    twice: set[str] = field(default_factory=set)

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return [cell.value for cell in self.header]

    def cell(self, test: str, column: str) -> CsvCell | None:
        """A cell; None where the file has no such column."""
        return self.rows[test][self.names.index(column)] if column in self.names else None

    def value(self, test: str, column: str) -> str:
        """What a cell holds; "" where the file has no such column."""
        cell = self.cell(test, column)
        return cell.value if cell else ""


def digest(content: bytes) -> str:
    """By which a file is known again."""
    return hashlib.sha256(content).hexdigest()


def parsed(content: bytes, path: str | Path = "CSV") -> CsvText:
    """The cells of a CSV file and where they stand.

    Raises
    ------
    FreerockError
        Quotes are not closed; no column "test"; a record has more or fewer cells than the first line.
    """
    text = content.decode("utf-8", "surrogateescape")
    separator, rows = rows_in(text, path)
    found = CsvText(text, separator, rows[0][1] if rows else [])
    if KEY not in found.names:
        raise FreerockError(path, f"has no column {KEY}", "write the line of column names first")
    for line, cells in rows[1:]:
        if len(cells) != len(found.header):
            raise wrong_length(path, line, cells, found.header)
        test = cells[found.names.index(KEY)].value
        if test in found.rows:
            found.twice.add(test)
        found.rows.setdefault(test, cells)
    return found


def edited(content: bytes, edits: Sequence[Edit], path: str | Path = "CSV") -> bytes:
    """The file with some cells changed; a column that it lacks is added at the end of each record.

    Parameters
    ----------
    content : bytes
        The file.
    edits : sequence of Edit
        Of two for one cell the later counts.
    path : path, optional
        For errors.

    Raises
    ------
    FreerockError
        A test that is not there or is there twice; a value that is no line of text; as `parsed`.
    """
    table = parsed(content, path)
    wanted = {(edit.test, edit.column): _plain(edit, path) for edit in edits}
    for test, _ in wanted:
        if test not in table.rows or test in table.twice:
            what = f"{test!r} is there twice" if test in table.twice else f"there is no record {test!r}"
            raise FreerockError(path, what, "read the file again and choose another record")
    added = list(dict.fromkeys(column for _, column in wanted if column not in table.names))
    if added and table.twice:
        raise FreerockError(path, f"{min(table.twice)!r} is there twice", "give each record its own name")
    changes: list[tuple[int, int, str]] = []
    for (test, column), value in wanted.items():
        cell = table.cell(test, column)
        if cell and value != cell.value:
            changes.append((cell.start, cell.end, _written(value, table, cell)))
    if added:
        ends = {table.header[-1].end: added}
        for test, cells in table.rows.items():
            ends[cells[-1].end] = [wanted.get((test, column), "") for column in added]
        for end, values in ends.items():
            further = "".join(table.separator + _quoted(value, table.separator) for value in values)
            changes.append((end, end, further))
    parts, done = list[str](), 0
    for start, end, value in sorted(changes, key=itemgetter(0, 1)):
        parts += [table.text[done:start], value]
        done = end
    made = "".join([*parts, table.text[done:]]).encode("utf-8", "surrogateescape")
    _check(table, parsed(made, path), wanted, path)
    return made


def save_edits(
    path: str | Path,
    known: str,
    edits: Sequence[Edit],
    back_to: bytes | None = None,
    beside: Callable[[bytes], Mapping[Path, bytes]] = lambda made: {},
) -> bytes:
    """Change cells of a CSV file after what is beside it; returns its new content.

    Parameters
    ----------
    path : path
        The file.
    known : str
        `digest` of its content as it was read: nobody may have changed it since.
    edits : sequence of Edit
    back_to : bytes, optional
        What the file held before: written instead, so that what is undone is as it was, quotes included.
    beside : callable
        Gives what other files will hold, by the new content; what it raises, nothing is written after.

    Raises
    ------
    FreerockError
        The file was changed since; one can't be read or written; as `edited`.
    """
    path = Path(os.path.realpath(path))  # a link stays one
    with locked(path) as content:
        if digest(content) != known:
            raise FreerockError(path, "was changed by someone else since it was read", READ_AGAIN)
        made = edited(content, edits, path) if back_to is None else back_to
        for each, content in {**beside(made), path: made}.items():
            write_bytes(each, content)
    return made


@contextmanager
def locked(path: Path) -> Iterator[bytes]:
    """The content of a file that no other desk changes meanwhile: its folder is locked, which stays.

    Raises
    ------
    FreerockError
        It can't be read.
    """
    with ExitStack() as stack:
        try:
            folder = os.open(path.parent, os.O_RDONLY)
            stack.callback(os.close, folder)
            fcntl.flock(folder, fcntl.LOCK_EX)
            content = path.read_bytes()
        except OSError as error:
            remedy = "put it back, then read the file again"
            raise FreerockError(path, f"can't be read ({error.strerror})", remedy) from error
        yield content


def _plain(edit: Edit, path: str | Path) -> str:
    """A value without spaces around it; refused where it is no line of text."""
    value = edit.value.strip()
    if any(unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp") for letter in value):
        what = f"the {edit.column} of {edit.test} would hold a line break or another control character"
        raise FreerockError(path, what, "write it in one line")
    return value


def _written(value: str, table: CsvText, cell: CsvCell) -> str:
    """A value as a cell: in quotes where it needs them or had them, else between its old spaces."""
    old = table.text[cell.start : cell.end]
    quoted = _quoted(value, table.separator, always=old.startswith('"'))
    if quoted != value or not (value and cell.value):
        return quoted
    return old.replace(cell.value, value, 1)


def _quoted(value: str, separator: str, always: bool = False) -> str:
    """A value as a cell of its own; a # at its beginning would make a comment of a line."""
    if always or value.startswith("#") or '"' in value or separator in value:
        return '"' + value.replace('"', '""') + '"'
    return value


def _check(old: CsvText, new: CsvText, wanted: Mapping[tuple[str, str], str], path: str | Path) -> None:
    """Refuse to write a file that would not be read as it was but for the cells that were to change."""
    for test in old.rows:
        expected = [wanted.get((test, column), old.value(test, column)) for column in new.names]
        if [cell.value for cell in new.rows.get(test, ())] != expected:
            raise FreerockError(path, f"the line of {test} can't be changed safely", "edit it by hand")
    if list(old.rows) != list(new.rows):
        raise FreerockError(path, "can't be changed safely", "edit it by hand")
