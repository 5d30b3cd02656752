"""What scripts share: products made one by one, and their log."""

import logging
import sys

import pytest

from freerock.errors import FreerockError
from freerock.workflow import log_to, make_each


@pytest.fixture
def log(tmp_path, monkeypatch):
    """A script's log file, to be."""
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    root, own = logging.getLogger(), logging.getLogger("freerock")
    before = [(logger, logger.handlers[:], logger.level) for logger in (root, own)]
    yield tmp_path / "script.log"
    for logger, handlers, level in before:
        logger.handlers[:] = handlers
        logger.setLevel(level)
    logging.captureWarnings(False)


def test_what_nobody_foresaw_stops_no_other(log, capsys):
    logging.getLogger().handlers.clear()  # as in a script, unlike under pytest
    log_to(log)
    made, given_up = [], []

    def make(test):
        if test == "b":
            raise ZeroDivisionError("by nothing")
        made.append(test)

    make_each(["a", "b", "c"], make, lambda *told: given_up.append(told))
    reason = "unforeseen: ZeroDivisionError: by nothing; the log of the step has the traceback"
    assert made == ["a", "c"]
    assert given_up == [("b", reason)]
    assert capsys.readouterr().err == f"b: {reason}\n"
    written = log.read_text()
    assert written.startswith("a (1 of 3)\nb (2 of 3)\n")
    assert "Traceback" in written


@pytest.mark.parametrize("error", [FreerockError("there", "no space", "free some"), MemoryError()])
def test_a_full_disk_or_memory_ends_the_job(error):
    def make(test):
        raise error

    with pytest.raises(type(error)):
        make_each(["a"], make, lambda *told: pytest.fail("given up"))
