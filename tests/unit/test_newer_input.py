"""The file that makes Snakemake do a job again: newer than its products, older than what comes."""

import os

import pytest

from freerock.errors import FreerockError
from freerock.jobs import newer_input


@pytest.fixture(autouse=True)
def own_folder():
    newer_input._folder.cache_clear()
    yield
    newer_input._folder.cache_clear()


@pytest.mark.parametrize("age_s", [0, 3600, -86400], ids=["new", "old", "of tomorrow"])
def test_it_is_newer_than_all_products_in_seconds_too(tmp_path, age_s):
    products = [tmp_path / name for name in "abc"]
    for number, path in enumerate(products[:2]):
        path.touch()
        os.utime(path, (0, path.stat().st_mtime - age_s - number))
    told = newer_input.newer_than(map(str, products), "fit_a")
    newest = products[0].stat().st_mtime
    assert newest < os.path.getmtime(told) < newest + 0.01
    assert (
        os.path.getsize(told) == 0 and newer_input.is_one(told) and not newer_input.is_one(str(products[0]))
    )


def test_where_nothing_is_there_it_is_of_now(tmp_path):
    (tmp_path / "now").touch()
    told = newer_input.newer_than([str(tmp_path / "missing")], "fit_a")
    assert abs(os.path.getmtime(told) - (tmp_path / "now").stat().st_mtime) < 5


def test_each_job_has_its_own(tmp_path):
    assert newer_input.newer_than([], "fit_a") != newer_input.newer_than([], "fit_b")


def test_without_a_temporary_folder_a_line_says_so(tmp_path, monkeypatch):
    def full(**options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(newer_input, "TemporaryDirectory", full)
    with pytest.raises(FreerockError, match="No space left on device; free some space there"):
        newer_input.newer_than([], "fit_a")
