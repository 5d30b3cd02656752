"""The rooms of the package: others use what a room's door names; no circles within a room."""

import ast
import re
from collections import Counter
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src/freerock"
BENCH = PACKAGE.with_name("freerock_bench")
ROOMS = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
INSIDE = re.compile(
    "damage|fuzz|scale|speed_of_"
)  # of the bench: what measures and damages looks behind doors
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
        looks_inside = path.parent == BENCH and INSIDE.match(path.stem)
        if name_of(path) == "freerock" or f"{name_of(path)}.".startswith(f"{inside}.") or looks_inside:
            continue
        used = {name.split(".")[2] for name in imported(path) if name.startswith(f"{inside}.")}
        assert used <= {*door(PACKAGE / room)}, path.relative_to(PACKAGE.parent)


def test_modules_import_no_circle():
    TopologicalSorter({name: imported(path) - {name} for name, path in MODULES.items()}).prepare()


# Names that each module of a kind has: a subcommand, a figure, a reader of a format, a program for an engine.
PROTOCOLS = {"run", "add_arguments", "draw", "caption", "contents", "prepare"}


def test_one_name_is_one_thing():
    """A public function or class, and a file, is found by its name alone."""
    files = [file for file in PACKAGE.rglob("*.py") if not file.stem.startswith("__")]
    nodes = [node for file in files for node in ast.parse(file.read_text(encoding="utf-8")).body]
    names = Counter(node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef))
    shared = {name for name, n in names.items() if n > 1 and not name.startswith("_")}
    assert shared <= PROTOCOLS
    assert len({file.stem for file in files}) == len(files)


def test_a_constant_that_is_imported_is_one_thing():
    """Of compiled modules alone two have codes of outcomes and contacts of their own."""
    bound, taken = Counter(), set()
    for file in PACKAGE.rglob("*.py"):
        name = name_of(file)
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = (
                    each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)
                )
                bound.update({each for each in names if each.isupper()})
            elif isinstance(node, ast.ImportFrom) and not name.startswith("freerock.models."):
                taken |= {each.name for each in node.names if each.name.isupper()}
    assert {each for each in taken if bound[each] > 1} == set()
