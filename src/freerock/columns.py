"""The columns of the CSV tables: their name, unit and meaning, and which tables have them.

`columns.csv` has a row per column, in the order in which a table has them. A name is changed there and where
its rows are written: `tables/`, `planning/`, `populations/`, and of a netCDF variable `products/`.
`figures/`, `report/`, `review/` and the bench (`src/freerock_bench`) read some by name. Writers and readers
of a column: `git grep NAME`. Names of a parameter or a law, as `k_u` and `epsilon_housner`, are composed. The
site is made from `columns.csv`. The unit `unit` is that in the row's own column `unit`.
"""

import csv
from functools import cache
from pathlib import Path
from typing import NamedTuple


class Column(NamedTuple):
    """A column of tables.

    Parameters
    ----------
    name : str
        Its head in the file.
    unit : str
        "" of texts and pure numbers.
    meaning : str
        What it holds.
    files : frozenset of str
        The tables that have it, without `.csv`.
    """

    name: str
    unit: str
    meaning: str
    files: frozenset[str]


@cache
def columns() -> tuple[Column, ...]:
    """Every column of every table, in order."""
    with open(Path(__file__).with_suffix(".csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    return tuple(Column(name, unit, meaning, frozenset(files.split())) for name, unit, meaning, files in rows)


def columns_of(table: str) -> list[str]:
    """The names of the columns of a table, in order.

    Raises
    ------
    KeyError
        There is no such table.
    """
    found = [column.name for column in columns() if table in column.files]
    if not found:
        raise KeyError(table)
    return found
