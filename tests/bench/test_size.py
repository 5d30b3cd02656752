"""The measures of the code, on a package of which all are known."""

import pytest

from freerock_bench.size import FITTING, one_identification, passed_by, rooms

SMALL = {
    "__init__.py": '"""A door."""\n\n__all__ = ["upper"]\n',
    "lower.py": '"""Words\nof two lines."""\n\nA, B = 1, 2  # two names\nC: int = 3\nlower = 4\n',
    "middle.py": 'from package.selection.lower import A\n\n\ndef double():\n    """Twice."""\n\n'
    "    # a comment\n    return (\n        2 * A\n    )\n",
    "upper.py": "from package.selection import middle\n\nx = middle.double()\n",
}


@pytest.fixture
def found(tmp_path):
    folder = tmp_path / "package/selection"
    folder.mkdir(parents=True)
    for name, text in SMALL.items():
        (folder / name).write_text(text, encoding="utf-8")
    return rooms(tmp_path / "package").set_index("room")


def test_rooms_are_measured(found):
    assert found.loc["selection"].to_dict() == {
        "files": 4,
        "code_lines": 1 + 3 + 5 + 2,
        "constants": 3,
        "longest_file": 10,
        "longest_function": 7,
        "import_chain": 3,
    }
    assert found.loc["fitting"].equals(found.loc["selection"])


def test_modules_that_a_call_passes():
    from freerock.models.block import Block
    from freerock.models.simulate import simulate

    def fall():
        simulate("housner", Block(1.0, 0.2, 1.0), {"r": 0.9}, [0.0, 0.1], theta0=0.1)

    passed = passed_by(fall)
    assert passed["models.housner"] >= 1 and "models.simulate" in passed
    assert not {name for name in passed if name.startswith("identification")}


@pytest.mark.slow
def test_one_identification_passes_the_search_and_the_fit():
    passed = passed_by(one_identification)
    assert {"identification.fit", "identification.problem"} <= {*passed}
    assert {name.partition(".")[0] for name in passed} & {*FITTING} == {"identification", "selection"}
