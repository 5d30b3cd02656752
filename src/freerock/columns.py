"""The columns of the CSV tables: their name, unit and meaning, and which tables have them.

`columns.csv` has a row per column, in the order in which a table has them. A name is changed there and where
its rows are written: `tables/`, `planning/`, `populations/`, and of a netCDF variable `products/`. `table_of`
refuses rows with other names.
`figures/`, `report/`, `review/` and the bench (`src/freerock_bench`) read some by name. Writers and readers
of a column: `git grep NAME`. Names of a parameter or a law, as `k_u` and `epsilon_housner`, are composed. The
site is made from `columns.csv`. The unit `unit` is that in the row's own column `unit`.
"""

import csv
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd


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


def table_of(name: str, rows: Sequence[Mapping[str, Any]] | pd.DataFrame, but: str = "") -> pd.DataFrame:
    """The rows of a table with its columns in order.

    Parameters
    ----------
    name : str
        The table, without `.csv`.
    rows : sequence of mapping, or pandas.DataFrame
        Each with all columns of the table, by name.
    but : str
        A column that is added later.

    Raises
    ------
    ValueError
        A row has a column that `columns.csv` does not list for this table, or lacks one that it lists.
    """
    listed = [each for each in columns_of(name) if each != but]
    for row in [rows] if isinstance(rows, pd.DataFrame) else rows:
        more, less = {*row} - {*listed}, {*listed} - {*row}
        if more or less:
            text = f"columns.csv does not list {sorted(more)}, a row does not have {sorted(less)}"
            raise ValueError(f"{name}.csv: {text}")
    return pd.DataFrame(rows, columns=listed)
