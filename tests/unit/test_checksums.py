"""A checksum is worked out once as long as its file stands."""

import asyncio
import hashlib
import os

import pytest

from freerock.jobs.checksums import once


@pytest.fixture
def worked_out():
    return []


@pytest.fixture
def checksum(worked_out):
    async def of(file, threshold=None):
        worked_out.append(str(file))
        if not os.path.exists(file) or (threshold and os.path.getsize(file) > threshold):
            return None
        with open(file, "rb") as opened:
            return hashlib.file_digest(opened, "sha256").hexdigest()

    kept = once(of)
    return lambda *arguments, **named: asyncio.run(kept(*arguments, **named))


def test_a_file_that_stands_is_looked_at_once(tmp_path, checksum, worked_out):
    file = tmp_path / "a"
    file.write_text("one")
    assert {checksum(file, 100) for _ in range(3)} == {hashlib.sha256(b"one").hexdigest()}
    assert checksum(file, 2) is None and checksum(file, threshold=2) is None
    assert worked_out == [str(file)] * 3


def test_a_file_that_changes_is_looked_at_again_though_size_and_time_are_set_back(
    tmp_path, checksum, worked_out
):
    file = tmp_path / "a"
    file.write_text("one")
    before, first = os.stat(file), checksum(file)
    file.write_text("two")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert checksum(file) == hashlib.sha256(b"two").hexdigest() != first
    (tmp_path / "b").write_text("two")
    os.replace(tmp_path / "b", file)
    assert checksum(file) == hashlib.sha256(b"two").hexdigest()
    assert len(worked_out) == 3


def test_a_file_that_is_not_there_is_asked_for_each_time(tmp_path, checksum):
    file = tmp_path / "a"
    assert checksum(file) is None
    file.write_text("one")
    assert checksum(file) == hashlib.sha256(b"one").hexdigest()
    file.unlink()
    assert checksum(file) is None
