"""What Snakemake's rules and scripts share: the code a step runs, and its log."""

import errno
import hashlib
import logging
import re
import sys
import traceback
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from types import TracebackType

from freerock.errors import DamagedProduct, FreerockError
from freerock.files import sha256
from freerock.jobs.guard import job_runs

PACKAGE = Path(__file__).parents[1]
# What the machine lacks, whichever record is at work: space, a disk that answers, memory, open files.
MACHINE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.ESTALE}
MACHINE |= {errno.ENOMEM, errno.EMFILE, errno.ENFILE}
IMPORT = re.compile(r"^ *(?:from ([\w.]+) import (\([^)]*\)|.*)|import (.*))", re.M)
FOR_TYPES = re.compile(r"^if TYPE_CHECKING:\n(?:(?: .*)?\n)+", re.M)
_sha256 = cache(sha256)  # modules are shared by many steps


@cache
def code_checksum(script: str | Path) -> str:
    """SHA-256 of the files a script runs, with their names: not of their times or of where they lie.

    As a parameter of a step it makes an edited module rerun the steps that use it, and no other.

    Parameters
    ----------
    script : path
        A Python file.

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
    for path in map(Path, code(script)):
        inside = path.relative_to(PACKAGE) if path.is_relative_to(PACKAGE) else Path(path.name)
        lines.append(f"{inside.as_posix()} {_sha256(path)}\n")
    return hashlib.sha256("".join(sorted(lines)).encode()).hexdigest()


def code(script: str | Path) -> list[str]:
    """Files a script runs: itself, every freerock module it imports, directly or not, and their data files.

    Imports inside functions count, those for type checkers don't. What imports `import_module` is taken to
    import every module beside it.

    Parameters
    ----------
    script : path
        A Python file.

    Returns
    -------
    list of str
        Absolute paths, sorted.
    """
    found, new = set(), {Path(script)}
    while new:
        found |= new
        new = {path for file in new for path in _imported(file)} - found
    folders = {file.parent for file in found if file.name == "__init__.py"} - {PACKAGE}
    data = {path for folder in folders for path in folder.glob("[!.]*.*") if path.suffix != ".py"}
    return sorted(map(str, found | data))


@cache
def _imported(file: Path) -> frozenset[Path]:
    """The freerock modules that the lines of a file import, with the packages that hold them.

    Found by pattern: syntax trees of all files take four times as long, whenever Snakemake starts.
    """
    if file.suffix != ".py":
        return frozenset()
    names: set[str] = set()
    text = re.sub(r" *#.*", "", file.read_text(encoding="utf-8"))
    for module, members, modules in IMPORT.findall(FOR_TYPES.sub("", text)):
        names |= {module, *re.findall(r"[\w.]+", modules)}
        names |= {f"{module}.{member}" for member in re.findall(r"\w+", members)}
    found: set[Path] = set()
    if "importlib.import_module" in names:
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


def make_each(tests: Sequence[str], make: Callable[[str], None], give_up: Callable[[str, str], None]) -> None:
    """Make the product of each test of a job; what nobody foresaw in one of them does not stop the others.

    A `FreerockError` and what is the machine's fault, such as a full disk or a lack of memory, end the job.

    Parameters
    ----------
    tests : sequence of str
    make : callable
        Takes a test and writes its product.
    give_up : callable
        Takes a test and a reason, and writes a product that holds this reason.
    """
    logger = logging.getLogger(PACKAGE.name)
    for number, test in enumerate(tests, 1):
        logger.info("%s (%d of %d)", test, number, len(tests))
        try:
            make(test)
        except Exception as error:
            if isinstance(error, FreerockError) or of_the_machine(error):
                raise
            reason = f"unforeseen: {type(error).__name__}: {error}; the log of the step has the traceback"
            logger.exception("%s: %s", test, reason)
            give_up(test, reason)


def of_the_machine(error: BaseException | None) -> bool:
    """Whether an error, or one it was raised from, says nothing about the record: a full disk, no memory."""
    while error is not None:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno in MACHINE):
            return True
        error = error.__cause__ or error.__context__
    return False


def log_to(path: str | Path) -> logging.Logger:
    """Send a script's messages, warnings and fatal error to its log; returns the logger for its messages.

    Errors show on the terminal too, each in a line. A `FreerockError` ends the script with its one line,
    anything else with a traceback. A damaged product of an earlier step is deleted, so that it is made again.
    """
    job_runs()
    logging.basicConfig(filename=path, filemode="w", format="%(message)s", encoding="utf-8")
    logging.captureWarnings(True)
    sys.excepthook = _report
    logger = logging.getLogger(PACKAGE.name)
    logger.setLevel(logging.INFO)
    terminal = logging.StreamHandler()
    terminal.setLevel(logging.ERROR)
    terminal.setFormatter(_OneLine())
    logger.addHandler(terminal)
    return logger


def why_failed(logs: Iterable[str | Path]) -> list[str]:
    """The lines that tell why jobs failed, from their logs, which the log of Snakemake names."""
    found = []
    for log in logs:
        for path in re.findall(r"log: (\S+) \(check log file", Path(log).read_text(encoding="utf-8")):
            lines = Path(path).read_text(encoding="utf-8").splitlines() if Path(path).exists() else []
            found += lines if Path(path).stem == "complete" else lines[-1:]
    return list(dict.fromkeys(found))


class _OneLine(logging.Formatter):
    """The message alone; tracebacks are for the log."""

    def format(self, record: logging.LogRecord) -> str:
        return record.getMessage()


def _report(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if isinstance(error, DamagedProduct):
        Path(str(error.where)).unlink(missing_ok=True)
        error = FreerockError(error.where, error.what, "it has been deleted: run the same command again")
    text = str(error) if isinstance(error, FreerockError) else "".join(traceback.format_exception(error))
    logging.error(text)
    print(text, file=sys.stderr)
