"""Returns what makes a step rerun when code changes: the checksum of the modules that it imports.

Snakemake compares the rest. Files: `input:` in `workflow/rules/*.smk`. Settings: `params:` there, which
`config.step_settings` fills.
"""

import ast
import atexit
import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from freerock.errors import FreerockError
from freerock.files import write_text
from freerock.jobs.home import PACKAGE

NOTES = Path(".snakemake/freerock_code.json")  # what was found of each file, by its time and size
SOURCES = PACKAGE.parent
STATEMENTS = (ast.stmt, ast.ExceptHandler, ast.match_case)  # among whose children imports stand


@cache
def code_checksum(script: Path, *modules: str) -> str:
    """SHA-256 of a script and of all modules of freerock that it imports.

    Comments, docstrings and layout do not count, and neither do times and folders of the files.

    Parameters
    ----------
    script : Path
        A Python file.
    *modules : str
        Dotted names of modules that the script imports by a name found at run time.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    named = {f"{name} {_known(path)[0]}" for name, path in code_files(script, *modules).items()}
    return hashlib.sha256("\n".join(sorted(named)).encode()).hexdigest()


def code_files(script: Path, *modules: str) -> dict[str, str]:
    """Paths, by short names, of a script, of all modules that it imports, and of their data files."""
    found: set[str] = set()
    new = {str(script)}.union(*map(_files_of, modules))
    while new:
        found |= new
        new = {file for path in new for name in _known(path)[1] for file in _files_of(name)} - found
    return {script.name if each == str(script) else _short(each): each for each in found}


@cache
def _files_of(name: str) -> frozenset[str]:
    """The files that importing one of our dotted names runs or lays beside a module."""
    folder, found = str(SOURCES), set[str]()
    for n, part in enumerate(name.split(".")):
        if f"{part}.py" in _files_in(folder):
            found |= {f"{folder}/{each}" for each in _files_in(folder) if each.startswith(f"{part}.")}
            break
        folder = f"{folder}/{part}"
        if "__init__.py" in _files_in(folder):
            data = {each for each in _files_in(folder) if n and not each.endswith((".py", ".md"))}
            found |= {f"{folder}/{each}" for each in {"__init__.py", *data}}
    return frozenset(found)


@cache
def _files_in(folder: str) -> frozenset[str]:
    """Names of the files in a folder that is there, without hidden and compiled ones."""
    if not os.path.isdir(folder):
        return frozenset()
    with os.scandir(folder) as found:
        return frozenset(
            each.name for each in found if each.name[0] != "." and each.name[-4:] != ".pyc" and each.is_file()
        )


def _short(path: str) -> str:
    """A path as seen from the folder of our packages."""
    return path.removeprefix(f"{SOURCES}/")


@cache
def _known(path: str) -> tuple[str, list[str]]:
    """Checksum of a file's code and our dotted names that it imports; noted for the next start."""
    seen, notes = os.stat(path), _notes()
    name, look = _short(path), [seen.st_mtime_ns, seen.st_size]
    if notes.get(name, [None])[0] != look:
        notes[name] = [look, *_read(path)]
    return notes[name][1], notes[name][2]


def _read(path: str) -> tuple[str, list[str]]:
    content = Path(path).read_bytes()
    if not path.endswith(".py"):
        return hashlib.sha256(content).hexdigest(), []
    statements = [*_statements(tree := ast.parse(content))]
    names = sorted({name for each in statements for name in _imported(each)})
    if "importlib.import_module" in names and path.startswith(str(PACKAGE)):  # of modules beside it
        room = os.path.relpath(os.path.dirname(path), SOURCES).replace(os.sep, ".")
        names += [f"{room}.{each.stem}" for each in Path(path).parent.glob("*.py")]
    for each in statements:
        if isinstance(each, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(each):
            del each.body[0]
    ours = [name for name in names if name.startswith("freerock")]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), ours


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """A node and all statements in it; those for type checkers do not count."""
    yield node
    for each in ast.iter_child_nodes(node):
        if isinstance(each, STATEMENTS) and not (
            isinstance(each, ast.If) and ast.unparse(each.test) == "TYPE_CHECKING"
        ):
            yield from _statements(each)


def _imported(statement: ast.AST) -> Iterator[str]:
    """Dotted names that a statement imports."""
    if isinstance(statement, ast.Import):
        yield from (alias.name for alias in statement.names)
    elif isinstance(statement, ast.ImportFrom):
        yield from (f"{statement.module}.{alias.name}" for alias in statement.names)


@cache
def _notes() -> dict[str, list[Any]]:
    """What an earlier start noted, and what this one adds, which is written at its end."""
    notes: dict[str, list[Any]] = {}
    with suppress(OSError, ValueError):
        notes = json.loads(NOTES.read_text(encoding="utf-8"))
    atexit.register(_write, notes, dict(notes))
    return notes


def _write(notes: dict[str, list[Any]], before: dict[str, list[Any]]) -> None:
    if notes != before:
        with suppress(FreerockError):  # not writable: the next start reads all files again
            write_text(NOTES, json.dumps(notes))
