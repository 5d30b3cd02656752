"""Records of a job: what goes wrong with one, and what goes wrong with the machine."""

import errno
import os

import pytest

from freerock.errors import FreerockError
from freerock.jobs.each_record import make_each, of_the_machine


def error(number):
    return OSError(number, os.strerror(number))


def caused_by(cause):
    failure = FreerockError("a.tdms", "can't be read", "check it")
    failure.__cause__ = cause
    return failure


MACHINE = [error(errno.ENOSPC), error(errno.EIO), error(errno.EMFILE), MemoryError()]
RECORD = [KeyError("x"), error(errno.ENOENT), ZeroDivisionError(), OSError("truncated file")]


@pytest.mark.parametrize("failure", MACHINE, ids=str)
def test_what_the_machine_lacks_says_nothing_about_the_record(failure):
    assert of_the_machine(failure)
    assert of_the_machine(caused_by(failure))


@pytest.mark.parametrize("failure", RECORD, ids=repr)
def test_what_is_wrong_with_a_record_is_not_the_machine(failure):
    assert not of_the_machine(failure)
    assert not of_the_machine(caused_by(failure))


@pytest.mark.parametrize("failure", RECORD, ids=repr)
def test_one_record_stops_no_other(failure):
    made, given_up = [], {}

    def make(test):
        if test == "bad":
            raise failure
        made.append(test)

    make_each(["one", "bad", "other"], make, given_up.__setitem__)
    assert made == ["one", "other"]
    assert list(given_up) == ["bad"]
    assert given_up["bad"].startswith(f"unforeseen: {type(failure).__name__}: ")
