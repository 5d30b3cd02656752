"""The one table of columns: what is written has them, and the site is made from it."""

import pytest
from fabricated import campaign, tidy_tables

from freerock.columns import columns, columns_of
from freerock_bench import datasets


def test_tidy_tables_have_their_columns_in_order():
    for name, frame in tidy_tables(*campaign()).items():
        assert list(frame) == columns_of(name), name


def test_a_name_has_one_meaning_in_a_table():
    for table in datasets.DESCRIBED["rows"]:
        names = columns_of(table)
        assert len(names) == len(set(names)), table
    assert {file for each in columns() for file in each.files} == set(datasets.DESCRIBED["rows"])
    with pytest.raises(KeyError):
        columns_of("no_table")


def test_the_site_has_every_column():
    page = datasets.columns()
    assert all(f"| `{each.name}` | " in page and each.meaning in page for each in columns())
