"""What makes a step run again besides its inputs and settings: one checksum of the code that it runs."""

import hashlib
import os
import re
from functools import cache
from pathlib import Path

from freerock.files import sha256

PACKAGE = Path(__file__).parents[1]
IMPORT = re.compile(r"^ *+(?:from ([\w.]+) import (\([^)]*\)|.*)|import (.*))", re.M)
FOR_TYPES = re.compile(r"\nif TYPE_CHECKING: *\n(?:(?: .*)?\n)+")


@cache
def code_checksum(script: str | Path, *modules: str) -> str:
    """SHA-256 of the files a script runs, with their names: not of their times or of where they lie.

    As a parameter of a step it makes an edited module rerun the steps that use it, and no other.

    Parameters
    ----------
    script : path
        A Python file.
    *modules : str
        Dotted names of the modules of freerock that it imports by a name found at run time.

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
    inside = Path(path).relative_to(PACKAGE) if Path(path).is_relative_to(PACKAGE) else Path(Path(path).name)
    return f"{inside.as_posix()} {sha256(path)}\n"


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
    if "importlib.import_module" in names and Path(path).is_relative_to(PACKAGE):
        found |= set(map(str, Path(path).parent.glob("*.py")))
    return frozenset(found.union(*map(_files, names)))


def _files(name: str) -> set[str]:
    """The files that importing a dotted name runs, as far as they are freerock's, with their data files."""
    parts = name.split(".")
    if parts[0] != PACKAGE.name:
        return set()
    above = (".".join(parts[:n]) for n in range(1, len(parts) + 1))
    return {path for each in above for path in _package().get(each, [])}


@cache
def _package() -> dict[str, list[str]]:
    """The files of freerock by dotted name: a module's own, and those of a room's door and its data."""
    found: dict[str, list[str]] = {}
    for folder, _, files in os.walk(PACKAGE):
        name = ".".join(Path(folder).relative_to(PACKAGE.parent).parts)
        if "__init__.py" in files:
            data = [file for file in files if file[0] != "." and not file.endswith(".py")]
            inside = ["__init__.py", *(data if Path(folder) != PACKAGE else [])]
            found[name] = [os.path.join(folder, file) for file in inside]
            modules = {file.removesuffix(".py") for file in files if file.endswith(".py")}
            found |= {f"{name}.{module}": [os.path.join(folder, f"{module}.py")] for module in modules}
    return found
