"""The one table of columns: what is written has them."""

import pandas as pd
import pytest
from fabricated import campaign, tidy_tables

from freerock import columns as module
from freerock.columns import columns, columns_of, table_of

WRITTEN = (
    "runs",
    "reasons",
    "parameters",
    "epsilon",
    "paper",
    "choice",
    "restitution",
    "populations",
    "budget",
)


def test_tidy_tables_have_their_columns_in_order():
    for name, frame in tidy_tables(*campaign()).items():
        assert list(frame) == columns_of(name), name


def test_a_name_has_one_meaning_in_a_table():
    for table in {file for each in columns() for file in each.files}:
        names = columns_of(table)
        assert len(names) == len(set(names)), table
    with pytest.raises(KeyError):
        columns_of("no_table")


@pytest.mark.parametrize("name", WRITTEN)
def test_a_column_that_is_renamed_in_the_list_alone_is_refused(monkeypatch, name):
    old = columns_of(name)[-1]
    listed = [
        each._replace(name="another") if name in each.files and each.name == old else each
        for each in columns()
    ]
    assert len(tidy_tables(*campaign())[name])
    monkeypatch.setattr(module, "columns", lambda: listed)
    with pytest.raises(ValueError, match=rf"{name}\.csv: .*\['{old}'\].*\['another'\]"):
        tidy_tables(*campaign())


def test_rows_have_the_columns_that_are_listed_no_more_and_no_fewer():
    row = {name: i for i, name in enumerate(columns_of("table3"))}
    table = table_of("table3", [dict(reversed(row.items()))])
    assert list(table) == list(row) and list(table.iloc[0]) == [*row.values()]
    row.pop("origin")
    for rows in ([row], pd.DataFrame([row])):
        assert list(table_of("table3", rows, but="origin")) == list(row)
        with pytest.raises(ValueError, match="origin"):
            table_of("table3", rows)
    with pytest.raises(ValueError, match="more"):
        table_of("table3", [row, row | {"more": 1}], but="origin")
    assert list(table_of("table3", [], but="origin")) == list(row)
