"""Single cells of a campaign's CSV file are changed; all else stays as it is, byte for byte.

The bytes that are no cell to be changed are never taken apart and put together again: order, quotes,
comments, line ends, a mark of the byte order and further columns stay as a person or a program wrote them.
"""

import fcntl
import hashlib
import os
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from freerock.errors import FreerockError
from freerock.files import regular, replace_together

KEY = "test"  # the column that names a record
SEPARATORS = ",;\t"
MARK = "\ufeff"
READ_AGAIN = "read the file again; what was not saved is kept"


class Edit(NamedTuple):
    """A cell and what it is to hold."""

    test: str
    column: str
    value: str


class CsvCell(NamedTuple):
    """A cell of a text: where it begins and ends, and what it holds without quotes and spaces around."""

    start: int
    end: int
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

    def column(self, name: str) -> int | None:
        """Index of a column, None where there is none."""
        names = [cell.value for cell in self.header]
        return names.index(name) if name in names else None

    def value(self, test: str, column: str) -> str:
        """What a cell holds; "" where the file has no such column."""
        index = self.column(column)
        return self.rows[test][index].value if index is not None else ""


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
    table: list[tuple[int, list[CsvCell]]] = []
    separators = []
    for line, separator, cells in _rows(text, path):
        if any(cell.value for cell in cells) and not cells[0].value.startswith("#"):
            table.append((line, cells))
            separators.append(separator)
    names = [cell.value for cell in table[0][1]] if table else []
    if KEY not in names:
        raise FreerockError(path, f"has no column {KEY}", "write the line of column names first")
    found = CsvText(text, separators[0], table[0][1])
    for line, cells in table[1:]:
        if len(cells) != len(names):
            what = f"has {len(cells)} cells, the first line has {len(names)}"
            raise FreerockError(f"{path}:{line}", what, "put texts that hold a comma in quotes")
        test = cells[names.index(KEY)].value
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
    added = list(dict.fromkeys(column for _, column in wanted if table.column(column) is None))
    changes: list[tuple[int, int, str]] = []
    for (test, column), value in wanted.items():
        index = table.column(column)
        if index is None:
            continue
        cell = table.rows[test][index]
        if value != cell.value:
            changes.append((cell.start, cell.end, _written(value, table, cell)))
    if added:
        every = table.separator
        changes.append((table.header[-1].end, table.header[-1].end, every + every.join(added)))
        for test, cells in table.rows.items():
            tail = every.join(_quoted(wanted.get((test, column), ""), every) for column in added)
            changes.append((cells[-1].end, cells[-1].end, every + tail))
        if table.twice:
            raise FreerockError(path, f"{min(table.twice)!r} is there twice", "give each record its own name")
    text, end = table.text, len(table.text)
    parts: list[str] = []
    for first, last, value in sorted(changes, reverse=True):
        parts += [text[last:end], value]
        end = first
    made = "".join(reversed([*parts, text[:end]])).encode("utf-8", "surrogateescape")
    _check(table, parsed(made, path), wanted, path)
    return made


def save_edits(
    path: str | Path,
    known: str,
    edits: Sequence[Edit],
    back_to: bytes | None = None,
    beside: Callable[[bytes], Mapping[Path, bytes]] = lambda made: {},
) -> bytes:
    """Change cells of a CSV file, and what is beside it, all or none; returns its new content.

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
        replace_together({path: made, **beside(made)})
    return made


@contextmanager
def locked(path: Path) -> Iterator[bytes]:
    """The content of a file that no other desk changes meanwhile: its folder is locked, which stays.

    Raises
    ------
    FreerockError
        It can't be read.
    """
    try:
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            fcntl.flock(folder, fcntl.LOCK_EX)
            with open(path, "rb", opener=regular) as file:
                content = file.read()
        except OSError:
            os.close(folder)
            raise
    except OSError as error:
        remedy = "put it back, then read the file again"
        raise FreerockError(path, f"can't be read ({error.strerror})", remedy) from error
    try:
        yield content
    finally:
        os.close(folder)


def _rows(text: str, path: str | Path) -> Iterator[tuple[int, str, list[CsvCell]]]:
    """Line number, separator and cells of each row that is no comment, as the configuration reads them."""
    at, line, separator = len(MARK) if text.startswith(MARK) else 0, 1, ""
    while at < len(text):
        start, end = at, _line_end(text, at)
        if not text[start:end].lstrip().startswith("#"):
            if text[start:end].strip():
                separator = separator or next((each for each in SEPARATORS if each in text[start:end]), ",")
            cells = list(_cells(text, start, separator or ",", f"{path}:{line}"))
            end = cells[-1].end
            yield line, separator or ",", cells
        at = end + (2 if text[end : end + 2] == "\r\n" else 1)
        line += text.count("\n", start, at) + text.count("\r", start, at) - text.count("\r\n", start, at)


def _line_end(text: str, start: int) -> int:
    ends = [end for end in (text.find("\n", start), text.find("\r", start)) if end >= 0]
    return min(ends, default=len(text))


def _cells(text: str, at: int, separator: str, where: str) -> Iterator[CsvCell]:
    """The cells of the row that begins there; a quote counts only where a cell begins with it."""
    while True:
        first = at
        if text.startswith('"', at):
            at = text.find('"', at + 1)
            while at >= 0 and text.startswith('""', at):
                at = text.find('"', at + 2)
            after = text[at + 1 : at + 2]
            if at < 0 or (after and after not in f"{separator}\r\n"):
                what = "a quote is not closed" if at < 0 else "text follows a closed quote"
                raise FreerockError(where, what, "check the quotes")
            value = text[first + 1 : at].replace('""', '"')
            at += 1
        else:
            found = text.find(separator, at, _line_end(text, at))
            at = _line_end(text, at) if found < 0 else found
            value = text[first:at]
        yield CsvCell(first, at, value.strip())
        if not text.startswith(separator, at):
            return
        at += 1


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
    if old.startswith('"'):
        return '"' + value.replace('"', '""') + '"'
    quoted = _quoted(value, table.separator)
    if quoted != value or not (value and cell.value):
        return quoted
    before = old[: len(old) - len(old.lstrip())]
    return before + value + old[len(old.rstrip()) :]


def _quoted(value: str, separator: str) -> str:
    """A value as a cell of its own; a # at its beginning would make a comment of a line."""
    if value.startswith("#") or '"' in value or separator in value:
        return '"' + value.replace('"', '""') + '"'
    return value


def _check(old: CsvText, new: CsvText, wanted: Mapping[tuple[str, str], str], path: str | Path) -> None:
    """Refuse to write a file that would not be read as it was but for the cells that were to change."""
    columns = [cell.value for cell in new.header]
    for test in old.rows:
        expected = [wanted.get((test, column), old.value(test, column)) for column in columns]
        if [cell.value for cell in new.rows.get(test, ())] != expected:
            raise FreerockError(path, f"the line of {test} can't be changed safely", "edit it by hand")
    if list(old.rows) != list(new.rows):
        raise FreerockError(path, "can't be changed safely", "edit it by hand")
