"""The picture of the rooms is drawn from their imports."""

import numpy as np

from freerock_bench.rooms import imports, main, rooms


def test_a_room_imports_only_those_before_it_and_knows_what_it_needs():
    found = imports()
    assert list(found) == rooms() and rooms().index("models") < rooms().index("runs") < rooms().index("cli")
    assert not np.triu(found.to_numpy()).any()
    assert found.loc["runs", "rotation"] > 0 and found.loc["models"].drop(["errors", "arrays"]).sum() == 0


def test_the_same_imports_give_the_same_picture(tmp_path):
    for name in ("a.svg", "b.svg"):
        main(str(tmp_path / name))
    picture = (tmp_path / "a.svg").read_bytes()
    assert picture == (tmp_path / "b.svg").read_bytes() and b"virtual_lab" in picture
