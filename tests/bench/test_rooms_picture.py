"""The picture of the rooms is drawn from their imports."""

from pathlib import Path

import numpy as np

from freerock_bench.rooms import imports, main, rooms

ROOT = Path(__file__).parents[2]


def test_a_room_imports_only_those_before_it_and_knows_what_it_needs():
    found = imports()
    assert list(found) == rooms() and rooms().index("models") < rooms().index("runs") < rooms().index("cli")
    assert not np.triu(found.to_numpy()).any()
    assert found.loc["runs", "rotation"] > 0 and found.loc["models"].drop(["errors", "arrays"]).sum() == 0


def test_the_picture_of_the_documentation_is_that_of_the_imports(tmp_path):
    main(str(tmp_path / "rooms.svg"))
    drawn = (tmp_path / "rooms.svg").read_bytes()
    assert drawn == (ROOT / "docs/images/rooms.svg").read_bytes() and b"virtual_lab" in drawn
