"""The log of a job, and what becomes of an error that nobody foresaw."""

import atexit
import errno
import logging
import resource
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from freerock.errors import FreerockError, printable

# What the machine lacks, whatever the record: space, a disk that answers, memory, open files.
MACHINE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.ESTALE}
MACHINE |= {errno.ENOMEM, errno.EMFILE, errno.ENFILE}

log = logging.getLogger("freerock")


def log_to(path: str | Path) -> None:
    """Send a script's messages, warnings and fatal error to its log; errors show on the terminal, too.

    A `FreerockError` ends the script with its one line, anything else with a traceback. The last line of the
    log is what the script took.
    """
    sys.excepthook = _report
    logging.raiseExceptions = False  # of a log that a full disk does not take: the terminal has the line
    logging.basicConfig(filename=path, filemode="w", encoding="utf-8", format="%(message)s")
    logging.captureWarnings(True)
    log.setLevel(logging.INFO)
    terminal = logging.StreamHandler()
    terminal.setLevel(logging.ERROR)
    terminal.setFormatter(_OneLine())
    log.addHandler(terminal)
    atexit.register(_note_spent)


def make_or_give_up(make: Callable[[], None], give_up: Callable[[str], None]) -> None:
    """Make the product of a record; after an unforeseen error give up, so that other records go on.

    A `FreerockError` and what is the machine's fault, such as a full disk, end the job.

    Parameters
    ----------
    make : callable
        Writes the product.
    give_up : callable
        Takes a reason and writes a product that holds it.
    """
    try:
        make()
    except Exception as error:
        if isinstance(error, FreerockError) or of_the_machine(error):
            raise
        reason = f"unforeseen: {type(error).__name__}: {error}; the log of the step has the traceback"
        log.exception(reason)
        give_up(reason)


def of_the_machine(error: BaseException | None) -> bool:
    """Whether an error, or one it was raised from, says nothing about the record: a full disk, no memory."""
    while error is not None:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno in MACHINE):
            return True
        error = error.__cause__ or error.__context__
    return False


def _note_spent() -> None:
    spent = resource.getrusage(resource.RUSAGE_SELF)
    peak_mb = spent.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
    log.info("%.2f s of processor time, at most %.0f MB of memory", spent.ru_utime + spent.ru_stime, peak_mb)


class _OneLine(logging.Formatter):
    """The message alone; tracebacks are for the log."""

    def format(self, record: logging.LogRecord) -> str:
        return printable(record.getMessage())


def _report(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    text = str(error) if isinstance(error, FreerockError) else "".join(traceback.format_exception(error))
    logging.error(text)
    print(text, file=sys.stderr)
