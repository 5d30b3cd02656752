"""The one table of columns: what is written has them."""

import pytest
from fabricated import campaign, tidy_tables

from freerock.columns import columns, columns_of


def test_tidy_tables_have_their_columns_in_order():
    for name, frame in tidy_tables(*campaign()).items():
        assert list(frame) == columns_of(name), name


def test_a_name_has_one_meaning_in_a_table():
    for table in {file for each in columns() for file in each.files}:
        names = columns_of(table)
        assert len(names) == len(set(names)), table
    with pytest.raises(KeyError):
        columns_of("no_table")
