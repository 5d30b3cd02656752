"""What a cell of a table says: a number, a mark of a missing sample, a time, a date, or text."""

import re
from collections.abc import Callable
from math import inf, nan
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.times import is_clock, is_date
from freerock.records.words import WORDS

NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?", re.IGNORECASE | re.ASCII)
THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:([.,'’ \N{NO-BREAK SPACE}\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d+)?")
_OVER = [sign + word for word in WORDS["marks"]["over"].split() for sign in ("", "+")]
MARKS = {
    **dict.fromkeys(WORDS["marks"]["missing"].split(), nan),
    **dict.fromkeys(_OVER, inf),
    **dict.fromkeys(WORDS["marks"]["under"].split(), -inf),
}
MARKS |= {mark.replace("_", " "): value for mark, value in MARKS.items()}
OVERLOAD = 9.9e37  # instruments write it, or a little more, for a sample out of range

Samples = tuple[Floats, list[str]]  # and what was found out


def mark(cell: str) -> float | None:
    """inf or −inf for a mark of a sample out of range, NaN for one of a missing sample, else None."""
    plain = cell.strip().casefold()
    if plain[:1] in "+-" and plain[1:].startswith(("nan", "1.#qnan", "1.#ind")):
        plain = plain[1:]
    return nan if plain and not plain.strip("#") else MARKS.get(plain)


def kind_of(cell: str, decimal: str) -> str:
    """n for a number, m for a mark, c for a time, d for a date alone, t for other text, "" where empty."""
    if not cell:
        return ""
    if (decimal == "." or "." not in cell) and NUMBER.fullmatch(cell.replace(decimal, ".")):
        return "n"
    if NUMBER.fullmatch(cell):
        return "t"
    if mark(cell) is not None:
        return "m"
    if is_date(cell):
        return "d"
    return "c" if is_clock(cell) else "t"


def numbers(where: object, cells: "pd.Series[Any]", decimal: str, place: Callable[[int], str]) -> Samples:
    """Cells as numbers, inf for a sample out of range, NaN for a missing one; and a note on each mark.

    Parameters
    ----------
    where : object
        The file, for errors.
    cells : pandas.Series
        Numbers, or texts; its index numbers the rows.
    decimal : str
        The decimal mark.
    place : callable
        How a cell is named, by its row's number.

    Raises
    ------
    FreerockError
        A cell that is neither a number nor a mark.
    """
    if cells.dtype.kind in "iuf":
        return cells.to_numpy(float), []
    text = cells.str.strip().replace("", None)
    plain = text
    if decimal != ".":
        plain = text.where(~text.str.contains(".", regex=False, na=False)).str.replace(decimal, ".")
    values = pd.to_numeric(plain, errors="coerce").to_numpy(float, copy=True)
    odd = text[np.isnan(values) & text.notna().to_numpy()]
    marked = {cell: mark(cell) for cell in odd.unique()}
    for row, cell in odd.items():
        if marked[cell] is None:
            raise wrong_cell(where, place(row), cell, "n")
    values[cells.index.get_indexer(odd.index)] = odd.map(marked).to_numpy(float)
    return values, [
        f"{n} cells marked {cell!r} are missing samples" for cell, n in odd.value_counts().items()
    ]


def wrong_cell(where: object, place: str, cell: str, kind: str) -> FreerockError:
    """The refusal of a cell that is no number (n) or no time (c)."""
    why = why_no_number(cell) if kind == "n" else f"{cell[:40]!r} is not a time"
    return FreerockError(where, f"{place}: {why}", "correct the line, or export the file again")


def why_no_number(cell: str) -> str:
    """What is wrong with a cell that should hold a number, in words."""
    if THOUSANDS.fullmatch(cell):
        return f"{cell[:40]!r} has a mark between thousands, or another decimal mark than the file"
    return f"{cell[:40]!r} is not a number"
