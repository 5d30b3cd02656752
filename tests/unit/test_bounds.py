"""Bounds of readers stand in one module, and docs/reliability.md prints them."""

import re
from pathlib import Path

import pytest

from freerock import bounds
from freerock_bench.bounds import markdown
from freerock_bench.document import marked

ROOT = Path(__file__).parents[2]
NAMES = [name for name in vars(bounds) if name.isupper()]
READERS = [ROOT / "src/freerock/files.py"]
READERS += [
    path for room in ("records", "config", "review") for path in (ROOT / "src/freerock" / room).glob("*.py")
]
BOUND = re.compile(r"^(?:MOST|MAX|LONGEST|SHORTEST|LARGEST|LEAST|DENSEST|DEEPEST)\w*\b.*= *[0-9]", re.M)


def test_the_page_is_up_to_date():
    assert marked(ROOT / "docs/reliability.md", "bounds")[1] == markdown()


def test_every_bound_has_a_row():
    assert len(markdown().splitlines()) == 2 + len(NAMES)


@pytest.mark.parametrize("path", READERS, ids=lambda path: path.stem)
def test_no_reader_has_a_bound_of_its_own(path):
    assert not BOUND.findall(path.read_text(encoding="utf-8"))
