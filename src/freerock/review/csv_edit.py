"""Cells of a campaign's CSV file are changed; a line without a changed cell stays, byte for byte."""

import csv
import fcntl
import hashlib
import io
import os
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from freerock.config.record import rows_in, wrong_length
from freerock.config.yaml_lines import text_of
from freerock.errors import FreerockError
from freerock.files import write_bytes

KEY = "test"  # the column that names a record
READ_AGAIN = "read the file again; what was not saved is kept"


def digest(content: bytes) -> str:
    """By which a file is known again."""
    return hashlib.sha256(content).hexdigest()


def edited(content: bytes, edits: Sequence[tuple[str, str, str]], path: str | Path = "CSV") -> bytes:
    """The file with some cells changed; a column that it lacks is added at the end of each record.

    Parameters
    ----------
    content : bytes
        The file, in UTF-8.
    edits : sequence of (str, str, str)
        Test, column and value of each; of two for one cell the later counts.
    path : path, optional
        For errors.

    Raises
    ------
    FreerockError
        A test that is not there or is there twice; a value that is no line of text; quotes that are not
        closed; a record with more or fewer cells than the first line.
    """
    wanted: dict[str, dict[str, str]] = {}
    for test, column, value in edits:
        wanted.setdefault(test, {})[column] = _plain(test, column, value, path)
    rows, lines = rows_in(text_of(content, Path(path)), path), content.decode().split("\n")
    header = rows[0][1] if rows else []
    if KEY not in header:
        raise FreerockError(path, f"has no column {KEY}", "write the line of column names first")
    for number, cells in rows:
        if len(cells) != len(header):
            raise wrong_length(path, number, cells, header)
    tests = [cells[header.index(KEY)] for _, cells in rows[1:]]
    for test in wanted:
        if tests.count(test) != 1:
            what = f"{test!r} is there twice" if test in tests else f"there is no record {test!r}"
            raise FreerockError(path, what, "read the file again and choose another record")
    added = [column for column in dict.fromkeys(column for _, column, _ in edits) if column not in header]
    for number, cells in rows:
        own = wanted.get(cells[header.index(KEY)], {})
        made = [own.get(column, cell) for column, cell in zip(header, cells, strict=True)]
        made += added if cells is header else [own.get(column, "") for column in added]
        if made != cells:
            old = lines[number - 1]
            mark, end = "\ufeff" * old.startswith("\ufeff"), "\r" * old.endswith("\r")
            lines[number - 1] = f"{mark}{_line(made)}{end}"
    return "\n".join(lines).encode()


def save_edits(
    path: str | Path,
    known: str,
    edits: Sequence[tuple[str, str, str]],
    beside: Callable[[bytes], Mapping[Path, bytes]] = lambda made: {},
) -> bytes:
    """Change cells of a CSV file after what is beside it; returns its new content.

    Parameters
    ----------
    path : path
        The file.
    known : str
        `digest` of its content as it was read: nobody may have changed it since.
    edits : sequence of (str, str, str)
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
        made = edited(content, edits, path)
        for each, new in {**beside(made), path: made}.items():
            write_bytes(each, new)
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


def _plain(test: str, column: str, text: str, path: str | Path) -> str:
    """A value without spaces around it; refused where it is no line of text."""
    value = text.strip()
    if any(unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp") for letter in value):
        what = f"the {column} of {test} would hold a line break or another control character"
        raise FreerockError(path, what, "write it in one line")
    return value


def _line(cells: Sequence[str]) -> str:
    """Cells as a line; a # at its beginning would make a comment of it."""
    out = io.StringIO(newline="")
    csv.writer(out, lineterminator="").writerow(cells)
    line = out.getvalue()
    return f'"{cells[0]}"{line[len(cells[0]) :]}' if line.startswith("#") else line
