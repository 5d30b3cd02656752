"""An error that nobody foresaw: what goes wrong with a record, and what goes wrong with the machine."""

import errno
import os
import re
import subprocess
import sys

import pytest

from freerock.errors import FreerockError
from freerock.jobs.log import make_or_give_up, of_the_machine


def error(number):
    return OSError(number, os.strerror(number))


def caused_by(cause):
    failure = FreerockError("a.tdms", "can't be read", "check it")
    failure.__cause__ = cause
    return failure


MACHINE = [error(errno.ENOSPC), error(errno.EIO), error(errno.EMFILE), MemoryError()]
RECORD = [KeyError("x"), error(errno.ENOENT), ZeroDivisionError(), OSError("truncated file")]


def raising(failure):
    def make():
        raise failure

    return make


@pytest.mark.parametrize("failure", [*MACHINE, *map(caused_by, MACHINE)], ids=repr)
def test_what_the_machine_lacks_ends_the_job(failure):
    given_up = []
    assert of_the_machine(failure)
    with pytest.raises(type(failure)):
        make_or_give_up(raising(failure), given_up.append)
    assert not given_up


@pytest.mark.parametrize("failure", RECORD, ids=repr)
def test_what_is_wrong_with_a_record_becomes_its_reason(failure):
    given_up = []
    assert not of_the_machine(caused_by(failure))
    make_or_give_up(raising(failure), given_up.append)
    assert len(given_up) == 1
    assert given_up[0].startswith(f"unforeseen: {type(failure).__name__}: ")


def test_a_log_that_a_full_disk_does_not_take_hides_no_error():
    script = (
        "from freerock.errors import FreerockError; from freerock.jobs.log import log_to; "
        "log_to('/dev/full'); raise FreerockError('a.nc', 'cannot be written', 'free some space')"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr == "a.nc: cannot be written; free some space\n"


@pytest.mark.parametrize("ends", ["", "raise FreerockError('a.nc', 'is empty', 'make it again')"])
def test_the_last_line_of_a_log_is_what_the_script_took(tmp_path, ends):
    path = tmp_path / "fit.log"
    script = (
        "from freerock.errors import FreerockError; from freerock.jobs.log import log, log_to; "
        f"log_to({str(path)!r}); log.info('run 1: ok'); {ends}"
    )
    subprocess.run([sys.executable, "-c", script], capture_output=True, check=not ends)
    first, *_, last = path.read_text().splitlines()
    assert first == "run 1: ok"
    seconds, memory_mb = re.fullmatch(r"(\S+) s of processor time, at most (\S+) MB of memory", last).groups()
    assert 0 < float(seconds) < 60
    assert 5 < float(memory_mb) < 5000
