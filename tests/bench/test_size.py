"""The measures of the code, on a package of which all are known."""

import pytest

from freerock_bench.size import rooms

SMALL = {
    "__init__.py": '"""A room."""\n\n__all__ = ["upper"]\n',
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
        "longest_file": 10,
        "longest_function": 7,
    }
