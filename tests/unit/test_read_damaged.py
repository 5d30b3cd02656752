import warnings

import pytest
from records import KINDS, TIME, VOLTS, damaged_files, walked_by_a_fork

from freerock.errors import FreerockError
from freerock.records.read import read_record

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("kind", KINDS)
def test_the_files_that_are_damaged_are_read_when_whole(tmp_path, kind):
    suffix, write = KINDS[kind]
    path = tmp_path / f"record{suffix}"
    write(path)
    dataset = read_record(path)
    assert dataset.sizes["time"] == TIME.size
    assert abs(next(iter(dataset.values())) - VOLTS).max() == 0


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_read_or_refused(tmp_path, kind, monkeypatch):
    """`freerock_bench/fuzz.py` does the same with more files, under limits of memory and time."""
    monkeypatch.setattr("freerock.records.hdf5.walked", walked_by_a_fork)
    refused = 0
    with warnings.catch_warnings(action="error"):
        for path in damaged_files(kind, tmp_path, 200, seed=0):
            try:
                read_record(path)
            except FreerockError as error:
                assert str(error).startswith(f"{path}: ") and "\n" not in str(error)
                refused += 1
    assert refused > 50
