"""docs/datasets.md has every variable of the datasets and every column of every CSV table."""

from pathlib import Path

import pytest
from test_glossary import columns as columns_of_code

from freerock.products.names import VARIABLES
from freerock_bench.datasets import COMMON, DESCRIBED, ROWS, column, columns, tables, variables
from freerock_bench.document import marked

PAGE = Path(__file__).parents[2] / "docs/datasets.md"


@pytest.mark.parametrize("what, made", [("variables", variables), ("columns", columns)])
def test_the_page_is_up_to_date(what, made):
    assert marked(PAGE, what)[1] == made()


def test_every_variable_has_its_place():
    groups = DESCRIBED["variables"].values()
    assert {name for names in groups for each in names.values() for name in each.split()} == set(VARIABLES)


def test_every_column_of_the_code_has_its_place():
    assert columns_of_code() <= {name for names in tables().values() for name in names}


def test_nothing_else_is_described():
    named = {(table, name) for table, names in tables().items() for name in names}
    own = {(table, name) for table, names in DESCRIBED["own"].items() for name in names}
    assert own <= named and set(ROWS) == set(tables())
    assert set(DESCRIBED["meanings"]) | set(COMMON) == {name for _, name in named}


@pytest.mark.parametrize(
    "table, name, unit",
    [
        ("runs.csv", "theta0_deg", "°"),
        ("parameters.csv", "stderr", "`unit`"),
        ("candidates.csv", "c_n_s_m2", "N·s/m²"),
        ("table1.csv", "p_rad_s", "rad/s"),
        ("restitution_law.csv", "slope_s_m", "s/m"),
        ("restitution.csv", "r", ""),
    ],
)
def test_units(table, name, unit):
    assert column(table, name)[:2] == [f"`{name}`", unit]
