"""The rooms of the package: others use what a room's door names; no circles within a room."""

import ast
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src/freerock"
BENCH = PACKAGE.with_name("freerock_bench")
ROOMS = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
FILES = sorted([*PACKAGE.rglob("*.py"), *BENCH.rglob("*.py")])


def name_of(path):
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in FILES}


@cache
def imported(path):
    """The modules of both packages that a file imports, wherever in the file, for type hints too."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            members = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {member if member in MODULES else str(node.module) for member in members}
    return found & {*MODULES}


def door(folder):
    """The modules that a room's door names."""
    tree = ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))
    lists = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    ]
    return lists[0] if lists else None


@pytest.mark.parametrize("folder", [*(PACKAGE / room for room in ROOMS), BENCH], ids=lambda path: path.name)
def test_a_door_says_what_the_room_does_and_names_its_modules(folder):
    assert ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8")))
    named = door(folder)
    assert named == sorted(named)
    assert {f"{name_of(folder)}.{name}" for name in named} <= {*MODULES}


@pytest.mark.parametrize("room", ROOMS)
def test_others_import_what_the_door_names(room):
    """The package's own __init__ gives its public names from wherever they are."""
    inside = f"freerock.{room}"
    for path in FILES:
        if name_of(path) == "freerock" or f"{name_of(path)}.".startswith(f"{inside}."):
            continue
        used = {name.split(".")[2] for name in imported(path) if name.startswith(f"{inside}.")}
        assert used <= {*door(PACKAGE / room)}, path.relative_to(PACKAGE.parent)


def test_modules_import_no_circle():
    TopologicalSorter({name: imported(path) - {name} for name, path in MODULES.items()}).prepare()
