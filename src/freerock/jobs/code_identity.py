"""Checksum of the code that a step runs.

`whole_or_rerun` compares it, the settings and the inputs of the step with the ledger, and decides whether the
step runs again.
"""

import ast
import hashlib
import json
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from itertools import chain
from pathlib import Path

from freerock.errors import FreerockError
from freerock.files import read_json, sha256, write_text
from freerock.jobs.home import PACKAGE, PACKED

MEANINGS = Path(".snakemake/freerock.code.json")  # by SHA-256 of a file's bytes; without it all are parsed
SCOPES = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)  # begin with docstrings
IMPORT = re.compile(r"^ *+(?:from ([\w.]+) import (\([^)]*\)|.*)|import (.*))", re.M)
FOR_TYPES = re.compile(r"\nif TYPE_CHECKING: *\n(?:(?: .*)?\n)+")


@cache
def code_checksum(script: str | Path, *modules: str) -> str:
    """SHA-256 of the code a script runs, with the names of its files: not of their times or where they lie.

    Comments, docstrings, layout and line numbers of Python files don't count, see `meaning`. As a parameter
    of a step it makes an edited module rerun the steps that use it, and no other.

    Parameters
    ----------
    script : path
        A Python file.
    *modules : str
        Dotted names of modules of freerock, or of a package beside it whose name begins so, that it imports
        by a name found at run time.

    Returns
    -------
    str
        64 hexadecimal digits.

    Raises
    ------
    FreerockError
        One of the files can't be read.
    """
    lines = "".join(sorted(map(_line, code(script, *modules))))
    return hashlib.sha256(lines.encode()).hexdigest()


@cache
def _line(path: str) -> str:
    """Name and checksum of a file; modules are shared by many steps."""
    packed = Path(path).is_relative_to(PACKED)  # a script of a wheel, named as in a checkout
    ours = Path(path).is_relative_to(PACKAGE.parent) and not packed
    inside = Path(path).relative_to(PACKAGE.parent) if ours else Path(Path(path).name)
    return f"{inside.as_posix()} {meaning(path)}\n"


@cache
def meaning(path: str) -> str:
    """SHA-256 of a Python file's syntax tree without docstrings; of any other file, of its bytes.

    Trees of all files take seconds, so what an earlier run wrote down of the same bytes counts.
    """
    told = sha256(path)
    if not path.endswith(".py"):
        return told
    if told not in _meanings():
        text = Path(path).read_bytes()
        with suppress(SyntaxError, ValueError):  # the step will say so
            _meanings()[told] = hashlib.sha256("".join(_parts(ast.parse(text))).encode()).hexdigest()
    return _meanings().get(told, told)


def _parts(node: object) -> Iterator[str]:
    """The words of a syntax tree; no empty field, of which Python's versions have different ones."""
    if isinstance(node, ast.AST):
        yield f"({type(node).__name__}"
        for name, value in ast.iter_fields(node):
            if value is None and isinstance(node, ast.Constant):
                yield " None"
            if value is None or value == [] or name in ("ctx", "kind", "type_comment"):
                continue
            if name == "body" and isinstance(node, SCOPES):
                value = value[ast.get_docstring(node, clean=False) is not None :]
            yield f" {name}="
            yield from _parts(value)
        yield ")"
    elif isinstance(node, list):
        yield "["
        for each in node:
            yield from _parts(each)
        yield "]"
    else:
        yield f"{type(node).__name__} {node!r};"


@cache
def _meanings() -> dict[str, str]:
    """Checksum of the syntax tree by that of the bytes, as an earlier run wrote them down."""
    with suppress(FreerockError):
        read = read_json(MEANINGS, "delete it")
        if isinstance(read, dict) and all(isinstance(each, str) for each in read.values()):
            return dict(read)
    return {}


def note_meanings() -> None:
    """Write down the meanings that were found, for the next run."""
    told = json.dumps(_meanings(), indent=1, sort_keys=True)
    if not MEANINGS.is_file() or MEANINGS.read_text(encoding="utf-8") != told:
        write_text(MEANINGS, told)


def code(script: str | Path, *modules: str) -> list[str]:
    """Files a script runs: itself, every freerock module it imports, directly or not, and their data files.

    Imports inside functions count, those for type checkers don't. A module of the package that imports
    `import_module` is taken to import every module beside it. Parameters as in `code_checksum`.

    Returns
    -------
    list of str
        Absolute paths, sorted.
    """
    found: set[str] = set()
    new = {str(script)}.union(*map(_files, modules))
    while new:
        found |= new
        new = {path for file in new for path in _imported(file)} - found
    return sorted(found)


@cache
def _imported(path: str) -> frozenset[str]:
    """The files of freerock that the lines of a file import, with the packages that hold them.

    Found by pattern: syntax trees of all files take 0.26 s instead of 0.02 s whenever Snakemake starts, and
    it may write no cache when the workflow is only read.
    """
    if not path.endswith(".py"):
        return frozenset()
    names: set[str] = set()
    text = "\n" + re.sub("#.*", "", Path(path).read_text(encoding="utf-8"))
    for module, members, modules in IMPORT.findall(FOR_TYPES.sub("\n", text)):
        names |= {module, *re.findall(r"[\w.]+", modules)}
        names |= {f"{module}.{member}" for member in re.findall(r"\w+", members)}
    found: set[str] = set()
    beside = Path(path).is_relative_to(PACKAGE) and not Path(path).is_relative_to(PACKED)
    if "importlib.import_module" in names and beside:
        found |= set(map(str, Path(path).parent.glob("*.py")))
    return frozenset(found.union(*map(_files, names)))


def _files(name: str) -> set[str]:
    """The files that importing a dotted name runs, as far as they are freerock's, with their data files."""
    parts = name.split(".")
    if not parts[0].startswith(PACKAGE.name):
        return set()
    above = (".".join(parts[:n]) for n in range(1, len(parts) + 1))
    return {path for each in above for path in _package().get(each, [])}


@cache
def _package() -> dict[str, list[str]]:
    """Files of freerock and of `freerock_*` beside it, by dotted name; a room's are its door and its data."""
    found: dict[str, list[str]] = {}
    tops = sorted(PACKAGE.parent.glob(f"{PACKAGE.name}*/__init__.py"))
    for folder, _, files in chain.from_iterable(os.walk(top.parent) for top in tops):
        name = ".".join(Path(folder).relative_to(PACKAGE.parent).parts)
        if "__init__.py" in files:
            data = [file for file in files if file[0] != "." and not file.endswith(".py")]
            inside = ["__init__.py", *(data if Path(folder).parent != PACKAGE.parent else [])]
            found[name] = [os.path.join(folder, file) for file in inside]
            modules = {file.removesuffix(".py") for file in files if file.endswith(".py")}
            found |= {f"{name}.{module}": [os.path.join(folder, f"{module}.py")] for module in modules}
    return found
