"""docs/datasets.md has the tables of variables that the code gives, and every variable in them."""

from pathlib import Path

from freerock.products.names import VARIABLES
from freerock_bench.variables import MARK, WHERE, markdown


def test_the_page_is_up_to_date():
    page = (Path(__file__).parents[2] / "docs/datasets.md").read_text(encoding="utf-8")
    assert page.split(MARK[0])[1].split(MARK[1])[0] == markdown()


def test_every_variable_has_its_place():
    placed = {name for groups in WHERE.values() for names in groups.values() for name in names.split()}
    assert placed == set(VARIABLES)
