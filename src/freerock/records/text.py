"""Tables of numbers in text: CSV, TSV and the like, their delimiter and decimal mark found out."""

import codecs
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import pandas as pd

from freerock.errors import FreerockError, number_of
from freerock.records.cells import seconds
from freerock.records.channels import COPY_AGAIN, Contents
from freerock.records.table import Layout, Table, cells_of, channels_of, layout_of

HEAD = 1000  # lines in which the table begins and its layout is found
DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "spaces"}
DECIMALS = {".": "point", ",": "comma"}
MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
OTHERS = {b"|CF,": "imc FAMOS", b"DIAEXTENDED": "DIAdem", b"\xd0\xcf\x11\xe0": "Excel 97", b"PK\3\4": "zip"}


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a table of numbers in text.

    A column of time is recognised by its heading or by its times (09:30:00.125, after a date or not); else
    the lines above the table must state the sampling rate ("sampling rate: 2000 Hz", "dt = 0.0005").
    """
    lines, encoding = lines_of(path)
    table = _table(path, lines)
    notes = [layout_in_words(table.delimiter, table.decimal, encoding)]
    channels, above = channels_of(table, notes)
    clocks = [table.cells[i].head(HEAD) for i, kind in table.kinds.items() if kind == "c"]
    dated = (seconds(path, column)[2] for column in clocks)
    yield Contents(channels, "text", notes, next(filter(None, dated), ""), above)


def layout_in_words(delimiter: str, decimal: str, encoding: str) -> str:
    """What was found out about a table, in words."""
    between = DELIMITERS.get(delimiter, repr(delimiter))
    return f"columns between {between}, decimal {DECIMALS[decimal]}, {encoding}"


def lines_of(path: Path) -> tuple[list[str], str]:
    """Lines of a text, the last one empty where the text ends a line; and its encoding.

    The encoding is told by the byte order mark; else it is UTF-8 where the text is, else Windows-1252.

    Raises
    ------
    FreerockError
        The file is no text.
    """
    content = path.read_bytes()
    encoding = next((name for mark, name in MARKS.items() if content.startswith(mark)), "utf-8")
    binary = "binary" if b"\0" in content and encoding != "utf-16" else ""
    if kind := next((f"of {name}" for magic, name in OTHERS.items() if content.startswith(magic)), binary):
        raise FreerockError(path, f"the file is {kind}, not a text", "export it as CSV, TDMS or .xlsx")
    try:
        content.decode(encoding)
    except UnicodeDecodeError:
        encoding = "cp1252" if encoding == "utf-8" else encoding
    text = content.decode(encoding, "replace")
    return re.split("\r\n|\r|\n", text.replace("\N{MINUS SIGN}", "-")), encoding


def frame_of(
    path: Path, lines: Sequence[str], first: int, layout: tuple[str, str], texts: Mapping[int, bool]
) -> pd.DataFrame:
    """Cells of a table: columns of numbers, and of texts where numbers are not all they hold.

    A last line that does not end and is shorter than the one above is left out: its number may be cut.

    Parameters
    ----------
    path : path-like
        The file, for errors.
    lines : sequence of str
        Of the table; blank ones don't count. The last is empty, or the file does not end it.
    first : int
        How many lines of the file are above these.
    layout : (str, str)
        Delimiter and decimal mark.
    texts : mapping
        Whether a column stays as text, for each one by place.

    Returns
    -------
    pandas.DataFrame
        Columns by place; the index numbers the lines of the file from 1.

    Raises
    ------
    FreerockError
        A line with more cells than columns; a last line that is cut off.
    """
    numbered = {n: line for n, line in enumerate(lines, first + 1) if line.strip()}
    rows = io.StringIO("\n".join(numbered.values()))
    try:
        cells = pd.read_csv(
            rows,
            sep=r"\s+" if layout[0] == " " else layout[0],
            decimal=layout[1],
            names=list(texts),
            dtype={i: str for i, text in texts.items() if text},
            keep_default_na=False,
            na_values=[""],
            index_col=False,
            skipinitialspace=True,
            low_memory=False,
        ).set_index(pd.Index([*numbered]))
    except pd.errors.ParserError as error:
        wide = next((n for n, line in numbered.items() if len(cells_of(line, layout[0])) > len(texts)), 0)
        what = f"line {wide} has more than {number_of(len(texts), 'cell')}" if wide else str(error)
        raise FreerockError(path, what, "correct the line, or export the file again") from None
    if lines[-1] and len(cells) > 1:
        if (cells.iloc[-1].isna() & cells.iloc[-2].notna()).any():
            raise FreerockError(path, "the file is truncated: its last line is incomplete", COPY_AGAIN)
        return cells[:-1] if len(lines[-1]) < len(lines[-2]) else cells
    return cells


def _table(path: Path, lines: Sequence[str]) -> Table:
    """The table of which least is lost, and which begins first.

    Raises
    ------
    FreerockError
        No table, or one whose decimal mark is not told by whole numbers between commas.
    """
    numbered = {n: line for n, line in enumerate(lines[:HEAD], start=1) if line.strip()}
    quoted = any('"' in line for line in numbered.values())
    found: dict[tuple[bool, int, int], tuple[str, Layout]] = {}
    for delimiter in DELIMITERS:
        rows = {n: cells_of(line, delimiter) for n, line in numbered.items()}
        if layout := layout_of(rows, [d for d in DECIMALS if d != delimiter or quoted], _place):
            found.setdefault((len(layout.kinds) == 1, layout.lost, layout.begin), (delimiter, layout))
    if not found:
        raise FreerockError(path, "no table of numbers in its first lines", "export columns of numbers")
    delimiter, layout = found[min(found)]
    first = [*numbered][layout.begin] - 1
    _refuse_ambiguous(path, lines, first, delimiter)
    kinds = layout.kinds
    texts = {i: kind != "n" for i, kind in kinds.items()}
    cells = frame_of(path, lines[first:], first, (delimiter, layout.decimal), texts)
    for i in [i for i, kind in kinds.items() if kind == "is empty" and cells[i].notna().any()]:
        kinds[i] = f"is empty in the first {HEAD} lines"
    return Table(path, lines[:first], delimiter, layout.decimal, kinds, cells, _place)


def _refuse_ambiguous(path: Path, lines: Sequence[str], first: int, delimiter: str) -> None:
    """Refuse whole numbers between commas under half as many headings, or none: maybe decimal commas."""
    row = next(line for line in lines[first:] if line.strip())
    cells = cells_of(row, ",")
    whole = all(re.fullmatch(r"[-+]?\d*|(?:.* )?\d\d?:\d\d:\d\d", cell) for cell in cells)
    above = lines[first - 1] if first else ""
    headings = len(cells_of(above, ",")) if above.strip() else 0
    if delimiter == "," and whole and '"' not in row and headings * 2 in (0, len(cells)):
        what = f"line {first + 1} may hold {len(cells)} columns, or decimal commas"
        raise FreerockError(path, what, "export with tabs or semicolons between the columns")


def _place(n: int, i: int) -> str:
    return f"line {n}, column {i + 1}" if n else f"column {i + 1}"
