"""Numbers of sentences that can be found again in the tables of the campaign."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple

import pandas as pd

from freerock.tables.number_text import printed_unit, quantity, value_text

KNOWN = "*"
"""Picks the rows in which a column is not empty."""
NOT = "!"
"""Before what a column must not hold."""
Where = Mapping[str, object]
USABLE: Where = MappingProxyType({"excluded": False, "verdict": f"{NOT}fail", "run": KNOWN})
"""Picks the rows of the table runs that sentences rest on."""
How = Literal["value", "above", "rows", "distinct", "lowest", "highest", "smallest", "largest"]
IN_WORDS = {"rows": "rows counted", "above": "lies above it, the value"}


class Number(NamedTuple):
    """A number of a sentence, and where it is found again.

    Parameters
    ----------
    text : str
        As printed.
    table : str
        Name of the table: tables/NAME.csv.
    columns : tuple of str
        Where it stands; that of its standard error follows. Of "distinct" the columns that are counted.
    where : mapping of str to object
        What the rows hold, by column, a tuple one of several; `KNOWN` picks those that hold something, `NOT`
        before a text those that hold another.
    how : str
        "value" of one row, which may lie "above" the number, number of "rows", of "distinct" entries,
        "lowest" or "highest" value, "smallest" or "largest" size.
    factor : float
        By which the printed number is larger than that of the table.
    """

    text: str
    table: str
    columns: tuple[str, ...] = ()
    where: Where = MappingProxyType({})
    how: How = "value"
    factor: float = 1.0

    @property
    def source(self) -> str:
        """Where it is found, in words."""
        of = f" of {', '.join(self.columns)}" if self.columns else ""
        return f"tables/{self.table}.csv: {IN_WORDS.get(self.how, self.how)}{of}"


Part = str | Number
Sentence = tuple[Part, ...]


def plain(sentence: Sentence) -> str:
    """A sentence as text."""
    return "".join(part if isinstance(part, str) else part.text for part in sentence)


def said(text: str, *parts: Part | Sequence[Part]) -> Sentence:
    """A sentence from a text, in which each {} stands for a part or a sentence."""
    found: list[Part] = []
    for words, part in zip(text.split("{}"), (*parts, ""), strict=True):
        for each in (words, *((part,) if isinstance(part, str | Number) else part)):
            if isinstance(each, str) and found and isinstance(found[-1], str):
                found[-1] += each
            elif each:
                found.append(each)
    return tuple(found)


def listed(items: Sequence[Sentence], word: str = "and") -> Sentence:
    """Items one after the other, the last after a word: "a, b and c"."""
    parts: list[Part] = []
    for i, item in enumerate(items):
        parts += [f" {word} " if i == len(items) - 1 else ", "] if i else []
        parts += item
    return tuple(parts)


class Tables(dict[str, pd.DataFrame]):
    """The tables of a campaign by name, which give numbers with their sources.

    They are as `freerock.tables.csvfile.read_csv` gives them.
    """

    def rows(self, table: str, where: Where) -> pd.DataFrame:
        """The rows of a table that hold something."""
        frame = self[table]
        for column, value in where.items():
            own = frame[column]
            if isinstance(value, tuple):
                frame = frame[own.isin(value)]
            elif str(value).startswith(NOT):
                frame = frame[own != str(value)[1:]]
            else:
                frame = frame[own.notna() if value == KNOWN else own == value]
        return frame

    def count(self, table: str, where: Where, *columns: str) -> Number:
        """How many rows, or how many distinct entries in some columns."""
        rows = self.rows(table, where)
        n = len(rows[list(columns)].drop_duplicates()) if columns else len(rows)
        return Number(str(n), table, columns, where, "distinct" if columns else "rows")

    def value(self, table: str, column: str, where: Where, stderr: str = "", digits: int = 3) -> Number:
        """The value of one row, with its standard error where a column of it is named, and its unit; a count
        as it is."""
        row = self.rows(table, where).iloc[0]
        if column.startswith("n_"):
            return Number(str(int(row[column])), table, (column,), where)
        unit = row.get("unit", "1")
        text = value_text(row[column], row[stderr] if stderr else math.nan, unit, digits)
        columns = (column, stderr) if stderr else (column,)
        return Number(text, table, columns, where, factor=printed_unit(unit)[1])

    def ends(
        self, table: str, column: str, where: Where, factor: float = 1.0, sizes: bool = False
    ) -> Sentence:
        """Lowest and highest value, or size, in a column, "6 to 20"; one number where they print alike."""
        values = self.rows(table, where)[column].dropna().astype(float)
        words: tuple[How, How] = ("smallest", "largest") if sizes else ("lowest", "highest")
        values = values.abs() if sizes else values
        ends = zip((values.min(), values.max()), words, strict=True)
        text = "{:.0f}".format if column.startswith("n_") else quantity
        low, high = (Number(text(factor * end), table, (column,), where, how, factor) for end, how in ends)
        return (low,) if low.text == high.text else (low, " to ", high)

    def most(self, table: str, column: str, where: Where, factor: float) -> Number:
        """The highest value of a column."""
        highest = factor * float(self.rows(table, where)[column].max())
        return Number(quantity(highest, digits=2), table, (column,), where, "highest", factor)
