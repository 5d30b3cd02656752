"""How large the code is, room by room.

`python -m freerock_bench.size` prints it. With the folder of a package it prints the rooms of that package:
one script measures two states.
"""

import ast
import sys
import tokenize
from functools import cache
from pathlib import Path

import pandas as pd

import freerock

PACKAGE = Path(freerock.__file__).parent
GENERATED = ("models/series_sums.py",)  # what a program writes is not counted
NO_CODE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
DOCUMENTED = (ast.Module, ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
COLUMNS = ["room", "files", "code_lines", "longest_file", "longest_function"]


def rooms(package: Path = PACKAGE) -> pd.DataFrame:
    """Size of each room of a package.

    Returns
    -------
    pandas.DataFrame
        A row per room, and "." of the modules beside the rooms: files, with the room's `__init__.py`;
        code_lines, without docstrings, comments and blanks; longest_file and
        longest_function, lines with all that is in them.
    """
    paths: dict[str, list[Path]] = {}
    for path in sorted(
        {*package.rglob("*.py"), *package.rglob("*.pyi")} - {package / each for each in GENERATED}
    ):
        inside = path.relative_to(package)
        paths.setdefault(inside.parts[0] if len(inside.parts) > 1 else ".", []).append(path)
    rows = [
        (
            room,
            len(own),
            sum(map(code_lines, own)),
            max(len(path.read_text(encoding="utf-8").splitlines()) for path in own),
            max(map(longest_function, own)),
        )
        for room, own in paths.items()
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def code_lines(path: Path) -> int:
    """How many lines of a file hold code."""
    return len(lines_of_code(path))


@cache
def lines_of_code(path: Path) -> set[int]:
    """Numbers of the lines of a file that hold code."""
    texts = set[int]()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            texts.update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    lines = set[int]()
    with tokenize.open(path) as file:
        for token in tokenize.generate_tokens(file.readline):
            if token.type not in NO_CODE and token.string:
                lines.update(range(token.start[0], token.end[0] + 1))
    return lines - texts


def longest_function(path: Path) -> int:
    """Lines of a file's longest function, with its docstring; 0 without any."""
    functions = (node for node in ast.walk(ast.parse(path.read_bytes())) if isinstance(node, DOCUMENTED[1:3]))
    return max(((node.end_lineno or 0) - node.lineno + 1 for node in functions), default=0)


if __name__ == "__main__":
    found = rooms(Path(sys.argv[1]) if sys.argv[1:] else PACKAGE)
    print(found.to_string(index=False))
    print("all:", *(f"{name} {found[name].sum()}" for name in ("files", "code_lines")))
