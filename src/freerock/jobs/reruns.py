"""What makes a step run again besides its inputs and settings: one checksum of the code that it runs."""

import hashlib
import re
from functools import cache
from pathlib import Path

from freerock.files import sha256

PACKAGE = Path(__file__).parents[1]
IMPORT = re.compile(r"^ *(?:from ([\w.]+) import (\([^)]*\)|.*)|import (.*))", re.M)
FOR_TYPES = re.compile(r"^if TYPE_CHECKING:\n(?:(?: .*)?\n)+", re.M)
_sha256 = cache(sha256)  # modules are shared by many steps


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
    lines = []
    for path in map(Path, code(script, *modules)):
        inside = path.relative_to(PACKAGE) if path.is_relative_to(PACKAGE) else Path(path.name)
        lines.append(f"{inside.as_posix()} {_sha256(path)}\n")
    return hashlib.sha256("".join(sorted(lines)).encode()).hexdigest()


def code(script: str | Path, *modules: str) -> list[str]:
    """Files a script runs: itself, every freerock module it imports, directly or not, and their data files.

    Imports inside functions count, those for type checkers don't. A module of the package that imports
    `import_module` is taken to import every module beside it. Parameters as in `code_checksum`.

    Returns
    -------
    list of str
        Absolute paths, sorted.
    """
    found: set[Path] = set()
    new = {Path(script)}.union(*map(_files, modules))
    while new:
        found |= new
        new = {path for file in new for path in _imported(file)} - found
    folders = {file.parent for file in found if file.name == "__init__.py"} - {PACKAGE}
    data = {path for folder in folders for path in folder.glob("[!.]*.*") if path.suffix != ".py"}
    return sorted(map(str, found | data))


@cache
def _imported(file: Path) -> frozenset[Path]:
    """The freerock modules that the lines of a file import, with the packages that hold them.

    Found by pattern: syntax trees of all files take 0.26 s instead of 0.05 s whenever Snakemake starts, and
    it may write no cache when the workflow is only read.
    """
    if file.suffix != ".py":
        return frozenset()
    names: set[str] = set()
    text = re.sub(r" *#.*", "", file.read_text(encoding="utf-8"))
    for module, members, modules in IMPORT.findall(FOR_TYPES.sub("", text)):
        names |= {module, *re.findall(r"[\w.]+", modules)}
        names |= {f"{module}.{member}" for member in re.findall(r"\w+", members)}
    found: set[Path] = set()
    if "importlib.import_module" in names and file.is_relative_to(PACKAGE):
        found |= set(file.parent.glob("*.py"))
    return frozenset(found.union(*map(_files, names)))


@cache
def _files(name: str) -> frozenset[Path]:
    """The files that importing a dotted name runs, as far as they are freerock's."""
    package, *parts = name.split(".")
    if package != PACKAGE.name:
        return frozenset()
    folder = PACKAGE
    found = {folder / "__init__.py"}
    for part in parts:
        if (folder / f"{part}.py").is_file():
            found.add(folder / f"{part}.py")
        folder /= part
        if not (folder / "__init__.py").is_file():
            break
        found.add(folder / "__init__.py")
    return frozenset(found)
