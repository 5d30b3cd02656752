"""docs/datasets.md has every column of every CSV table, as the code gives them."""

from pathlib import Path

import pytest
from test_glossary import columns

from freerock_bench.columns import COMMON, MARK, MEANINGS, OWN, ROWS, markdown, row, tables

PAGE = Path(__file__).parents[2] / "docs/datasets.md"


def test_the_page_is_up_to_date():
    assert PAGE.read_text(encoding="utf-8").split(MARK[0])[1].split(MARK[1])[0] == markdown()


def test_every_column_of_the_code_has_its_place():
    assert columns() <= {name for names in tables().values() for name in names}


def test_nothing_else_is_described():
    named = {(table, name) for table, names in tables().items() for name in names}
    assert set(OWN) <= named and set(ROWS) == set(tables())
    assert set(MEANINGS) | set(COMMON) == {name for _, name in named}


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
    assert row(table, name, "") == f"| `{name}` | {unit} |  |"
