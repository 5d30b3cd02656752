"""How large the code is, room by room, and through how many modules one identification goes.

`python -m freerock_bench.size` prints both. With the folder of a package it prints the rooms of that package:
one script measures two states.
"""

import ast
import math
import sys
import tokenize
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pandas as pd

import freerock
from freerock.models.published import TABLE_2
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import identify_run
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.drawn import stated_laboratory
from freerock_bench.virtual_run import SEED, Truth, virtual_motion

PACKAGE = Path(freerock.__file__).parent
NO_CODE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
DOCUMENTED = (ast.Module, ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
FITTING = ("identification", "selection", "populations", "planning")
COLUMNS = ["room", "files", "code_lines", "constants", "longest_file", "longest_function", "import_chain"]


def rooms(package: Path = PACKAGE) -> pd.DataFrame:
    """Size of each room of a package.

    Returns
    -------
    pandas.DataFrame
        A row per room, "." of the modules beside the rooms, and one of the rooms of `FITTING` together:
        files, with the room's `__init__.py`; code_lines, without docstrings, comments and blanks; constants,
        names in capitals that modules bind; longest_file and longest_function, lines with all that is in
        them; import_chain, the most modules of which each imports the next.
    """
    paths: dict[str, list[Path]] = {}
    for path in sorted(package.rglob("*.py")):
        inside = path.relative_to(package)
        paths.setdefault(inside.parts[0] if len(inside.parts) > 1 else ".", []).append(path)
    paths["fitting"] = [path for room in FITTING for path in paths.get(room, [])]
    rows = [
        (
            room,
            len(own),
            sum(map(code_lines, own)),
            sum(map(constants, own)),
            max(len(path.read_text(encoding="utf-8").splitlines()) for path in own),
            max(map(longest_function, own)),
            import_chain(own, package.parent),
        )
        for room, own in paths.items()
        if own
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def code_lines(path: Path) -> int:
    """Lines of a file that hold code."""
    texts = set[int]()
    for node in ast.walk(_tree(path)):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            texts.update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    lines = set[int]()
    with tokenize.open(path) as file:
        for token in tokenize.generate_tokens(file.readline):
            if token.type not in NO_CODE and token.string:
                lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines - texts)


def constants(path: Path) -> int:
    """Names in capitals that a module binds."""
    found = set[str]()
    for node in _tree(path).body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = (each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name))
            found.update(name for name in names if name.isupper())
    return len(found)


def longest_function(path: Path) -> int:
    """Lines of a file's longest function, with its docstring; 0 without any."""
    functions = (node for node in ast.walk(_tree(path)) if isinstance(node, DOCUMENTED[1:3]))
    return max(((node.end_lineno or 0) - node.lineno + 1 for node in functions), default=0)


def import_chain(paths: Sequence[Path], root: Path) -> int:
    """The most modules of some below a root of which each imports the next; doors do not count."""
    names = {".".join(path.relative_to(root).with_suffix("").parts): path for path in paths}
    modules = {name: path for name, path in names.items() if path.stem != "__init__"}

    @cache
    def chain(name: str) -> int:
        imported = set[str]()
        for node in ast.walk(_tree(modules[name])):
            if isinstance(node, ast.ImportFrom) and node.module:
                imported |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
        return 1 + max((chain(each) for each in imported & {*modules} - {name}), default=0)

    return max(map(chain, modules), default=0)


def passed_by(call: Callable[[], Any], package: Path = PACKAGE) -> Mapping[str, int]:
    """How many functions of each module of a package a call runs through; those inside one are that one."""
    found = set[tuple[str, str]]()

    def note(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_code.co_name != "<module>":
            found.add((frame.f_code.co_filename, frame.f_code.co_qualname.partition(".<locals>")[0]))

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    inside = [(Path(file), name) for file, name in found if Path(file).is_relative_to(package)]
    files = sorted(file for file, _ in inside)
    return {
        ".".join(file.relative_to(package).with_suffix("").parts): files.count(file)
        for file in dict.fromkeys(files)
    }


def one_identification() -> None:
    """The main path: a run of a block on a level base under all hypotheses, its inputs known by calipers."""
    block, theta0, _ = CONFIGURATIONS["config2"]
    truth = Truth("hunt_crossley", block, TABLE_2["marble"]["hunt_crossley"], theta0, math.radians(0.005))
    motion = virtual_motion(truth, np.random.default_rng(SEED), still_s=(1.0, 1.0))
    assert motion is not None
    identify_run(block, replace(motion, laboratory=stated_laboratory("config2", "caliper")), BY_DEFAULT)


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    found = rooms(Path(sys.argv[1]) if sys.argv[1:] else PACKAGE)
    print(found.to_string(index=False))
    every = found[found["room"] != "fitting"]
    print("all:", *(f"{name} {every[name].sum()}" for name in ("files", "code_lines", "constants")))
    if not sys.argv[1:]:
        passed = passed_by(one_identification)
        print("one identification:", *(f"{module} {functions}" for module, functions in passed.items()))
        modules = [name for name in passed if name.partition(".")[0] in FITTING]
        print(f"modules of {', '.join(FITTING)}: {len(modules)}")
