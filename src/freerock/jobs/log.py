"""The log of a job, and the lines that say why jobs failed."""

import io
import logging
import re
import sys
import traceback
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType

from freerock.errors import DamagedProduct, FreerockError, printable
from freerock.files import ROOM_REMEDY, read_bytes, regular


def log_to(path: str | Path) -> logging.Logger:
    """Send a script's messages, warnings and fatal error to its log; returns the logger for its messages.

    Errors show on the terminal too, each in a line. A `FreerockError` ends the script with its one line,
    anything else with a traceback. A damaged product of an earlier step is deleted, so that it is made again.
    """
    sys.excepthook = _report
    try:
        stream = open(path, "w", encoding="utf-8", opener=regular)  # noqa: SIM115 (to the end of the process)
    except OSError as error:
        raise FreerockError(path, f"cannot be written ({error.strerror})", ROOM_REMEDY) from error
    logging.basicConfig(stream=stream, format="%(message)s")
    logging.captureWarnings(True)
    logger = logging.getLogger("freerock")
    logger.setLevel(logging.INFO)
    terminal = logging.StreamHandler()
    terminal.setLevel(logging.ERROR)
    terminal.setFormatter(_OneLine())
    logger.addHandler(terminal)
    return logger


def in_utf8() -> None:
    """Let Snakemake write its own log in UTF-8, in which `why_failed` reads it, whatever the locale."""
    for handler in logging.getLogger("snakemake.logging").handlers:
        stream = getattr(handler, "stream", None)
        if isinstance(handler, logging.FileHandler) and isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding="utf-8")


def why_failed(logs: Iterable[str | Path]) -> list[str]:
    """The lines that say why jobs failed, from their logs, which the log of Snakemake names."""
    found = []
    for log in logs:
        for path in re.findall(r"log: (\S+) \(check log file", Path(log).read_text("utf-8", "replace")):
            lines = read_bytes(path).decode("utf-8", "replace").splitlines() if Path(path).exists() else []
            found += lines if Path(path).stem == "complete" else lines[-1:]
    return list(dict.fromkeys(map(printable, found)))


class _OneLine(logging.Formatter):
    """The message alone; tracebacks are for the log."""

    def format(self, record: logging.LogRecord) -> str:
        return printable(record.getMessage())


def _report(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if isinstance(error, DamagedProduct):
        Path(str(error.where)).unlink(missing_ok=True)
        error = FreerockError(error.where, error.what, "it has been deleted: run the same command again")
    text = str(error) if isinstance(error, FreerockError) else "".join(traceback.format_exception(error))
    if logging.root.handlers:
        logging.error(text)
    print(text, file=sys.stderr)
