"""How far an analysis is."""

import math
import os
import time

import pytest

from freerock.cli.progress_command import newest_run, progress, progress_text
from freerock.products.netcdf import write_failure
from freerock.runs.verdict import Reason

TESTS = ["a", "b", "c", "d"]
ATTRS = {"campaign": "lab", "title": "A lab", "origin": "measured", "block": "tall", "foundation": "mat"}


def product(folder, name, made_s, reason=None):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    if reason is None:
        path.touch()
    else:
        found = Reason("fail" if reason else "warn", "not_processed", reason)
        write_failure(path, found, ATTRS | {"test": path.stem})
    os.utime(path, (made_s, made_s))


def test_pace_of_the_newest_run_tells_the_rest(tmp_path):
    now = 1e9
    for test, made in zip(TESTS, (now - 500, now - 90, now - 80), strict=False):
        product(tmp_path, f"records/{test}.nc", made, reason="no release" if test == "b" else "")
    product(tmp_path, "fits/a.nc", now - 10)
    state = progress(tmp_path, TESTS, started_s=now - 100, now_s=now)
    assert state.done == {"records": 3, "fits": 1, "quality pages": 0}
    assert state.failed == [("b", "no release")]
    assert state.share == pytest.approx(0.25 * 3 / 4 + 0.45 / 4)
    new = 0.25 * 2 / 4 + 0.45 / 4  # the first record is older than the run
    assert state.remaining_s == pytest.approx((1 - state.share) / new * 100)
    assert progress_text("lab", state) == (
        "lab: 30 % of the work on the records done, about 5 min to go at the pace of the newest run "
        "(products of earlier runs are taken to be up to date)\n"
        "  records           3 of 4\n"
        "  fits              1 of 4\n"
        "  quality pages     0 of 4\n"
        "  failed: b: no release\n"
        "  look at the runs: freerock review lab"
    )


def test_nothing_made_yet_and_everything_made(tmp_path):
    assert progress_text("lab", progress(tmp_path, TESTS, 0.0, 1.0)).startswith(
        "lab: 0 % of the work on the records done\n"
    )
    for test in TESTS:
        product(tmp_path, f"records/{test}.nc", 5.0, reason="")
        product(tmp_path, f"fits/{test}.nc", 5.0)
        product(tmp_path, f"figures/qc_{test}.csv", 5.0)
    assert "tables, figures and report" in progress_text("lab", progress(tmp_path, TESTS, 0.0, 9.0))
    (tmp_path / "complete.txt").touch()
    assert progress_text("lab", progress(tmp_path, TESTS, 0.0, 9.0)).startswith("lab: complete\n")


def test_products_of_no_known_run_have_no_pace(tmp_path):
    product(tmp_path, "records/a.nc", 5.0, reason="")
    state = progress(tmp_path, TESTS, newest_run(tmp_path), 1e9)
    assert math.isnan(state.remaining_s)
    assert progress_text("lab", state).startswith("lab: 6 % of the work on the records done\n")


def test_the_newest_run_is_known_by_its_log(tmp_path):
    assert newest_run(tmp_path) == 0.0
    logs = tmp_path / ".snakemake/log"
    logs.mkdir(parents=True)
    for name in ("2026-01-02T030405.123456", "2026-01-02T030407.000001", "notes"):
        (logs / f"{name}.snakemake.log").touch()
    assert time.strftime("%Y-%m-%dT%H%M%S", time.localtime(newest_run(tmp_path))) == "2026-01-02T030407"
