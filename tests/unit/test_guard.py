"""After a bad day: leavings of a killed run, its jobs, another run, times from the future."""

import fcntl
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from threading import Thread

import pytest

from freerock.errors import FreerockError
from freerock.jobs.guard import (
    JOBS,
    NOTES_BYTES,
    RUNS,
    check_clock,
    check_folder,
    check_room,
    hold,
    job_runs,
    run_starts,
)


@pytest.fixture
def locks(tmp_path, monkeypatch):
    """A folder with the locks of Snakemake, as a run at work or a killed one leaves them."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / ".snakemake/locks"
    folder.mkdir(parents=True)
    (tmp_path / "results").mkdir()
    for name in ("0.input.lock", "0.output.lock"):
        (folder / name).touch()
    stdin = os.dup(0)
    yield folder
    os.dup2(stdin, 0)
    os.close(stdin)


def at_work(path):
    """A process that holds its lock; another description of the file counts as another process."""
    file = os.open(path, os.O_CREAT | os.O_RDWR)
    fcntl.flock(file, fcntl.LOCK_SH)
    return file


def is_free(path):
    with open(path) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


def test_locks_and_half_files_of_a_killed_run_are_taken_away(locks):
    half = Path("results/lab/fits/.0123456789abcdef.partial.nc")
    half.parent.mkdir(parents=True)
    for path in (half, half.with_name("whole.nc")):
        path.touch()
    run_starts()
    assert not list(locks.iterdir())
    assert [path.name for path in half.parent.iterdir()] == ["whole.nc"]


def test_locks_and_files_of_a_run_at_work_stay(locks):
    half = Path("results/.0123456789abcdef.partial.nc")
    half.touch()
    at_work(RUNS)
    run_starts()
    assert len(list(locks.iterdir())) == 2
    assert half.exists()


def test_this_run_is_seen_by_the_next(locks):
    run_starts()
    (locks / "0.input.lock").touch()
    run_starts()
    assert len(list(locks.iterdir())) == 1


@pytest.mark.parametrize("left", [True, False], ids=["locks left", "no locks left"])
def test_jobs_of_a_killed_run_are_waited_for(locks, capsys, left):
    for lock in () if left else locks.iterdir():
        lock.unlink()
    job = at_work(JOBS)
    run = Thread(target=run_starts, daemon=True)
    run.start()
    while "waiting for the jobs" not in (told := capsys.readouterr().err):
        time.sleep(0.01)
    assert told == "A run was killed; waiting for the jobs it left at work.\n"
    assert run.is_alive()
    assert bool(list(locks.iterdir())) == left
    os.close(job)
    run.join(10)
    assert not list(locks.iterdir())


def test_a_job_is_seen_from_its_first_moment_until_it_ends(locks):
    """Even one that imports nothing and outlives the run that started it."""
    code = "import subprocess, sys; from freerock.jobs.guard import job_runs; job_runs(); "
    code += "print(subprocess.Popen(['sleep', '600'], stdout=-3, stderr=-3).pid)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not is_free(JOBS)
    os.kill(int(done.stdout), signal.SIGKILL)
    end = time.monotonic() + 10
    while not is_free(JOBS):
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_campaign_has_one_run_at_a_time(locks):
    hold(Path("results/lab"))
    hold(Path("results/other"))
    with pytest.raises(FreerockError) as told:
        hold(Path("results/lab"))
    assert str(told.value) == "results/lab: another run is at work on it; wait until it has ended"


def test_outside_of_snakemake_nothing_is_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    job_runs()
    assert not list(tmp_path.iterdir())


def test_products_from_the_future_get_the_present_time(tmp_path):
    past, future = tmp_path / "past.nc", tmp_path / "future.nc"
    now = time.time()
    for path, when in ((past, now - 100), (future, now + 3600)):
        path.touch()
        os.utime(path, (when, when))
    check_clock([past, future], [past])
    assert past.stat().st_mtime == pytest.approx(now - 100, abs=1)
    assert now - 1 < future.stat().st_mtime < now + 60


def test_inputs_from_the_future_are_refused(tmp_path):
    raw = tmp_path / "raw.tdms"
    raw.touch()
    os.utime(raw, (time.time() + 3600,) * 2)
    with pytest.raises(
        FreerockError, match=r"raw\.tdms: was last written on .*; set the clock right, or touch"
    ):
        check_clock([], [tmp_path / "missing.tdms", raw])
    assert raw.stat().st_mtime > time.time() + 3000


def test_a_folder_that_can_be_written_is_left_as_it_was(tmp_path):
    (tmp_path / "lab/records").mkdir(parents=True)
    (tmp_path / "lab/report.html").touch()
    for folder in ("lab", "other/campaign"):
        check_room(tmp_path / folder)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["lab", "records", "report.html"]


def test_a_file_in_the_place_of_the_results_is_refused(tmp_path):
    (tmp_path / "results").touch()
    for check, folder in ((check_folder, "results"), (check_room, "results/lab")):
        with pytest.raises(FreerockError) as told:
            check(tmp_path / folder)
        assert str(told.value) == (
            f"{tmp_path}/results: can't be written (Not a directory); "
            "free some space, give yourself the right to write there, or use --directory"
        )


def test_looking_at_a_folder_writes_nothing(tmp_path):
    check_folder(tmp_path)
    check_folder(tmp_path / "missing")
    assert not list(tmp_path.iterdir())


def test_the_folder_without_rights_is_named(tmp_path, monkeypatch):
    (tmp_path / "lab/fits").mkdir(parents=True)
    (tmp_path / "lab/records").mkdir()
    made = tempfile.TemporaryFile

    def refused(dir):
        if dir.name == "records":
            raise PermissionError(13, "Permission denied")
        return made(dir=dir)

    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    with pytest.raises(FreerockError, match=r"lab/records: can't be written \(Permission denied\); free"):
        check_room(tmp_path / "lab")


def test_a_run_without_room_for_its_notes_is_refused(tmp_path):
    check_room(tmp_path, NOTES_BYTES)
    assert not list(tmp_path.iterdir())
    most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, most[1]))
    try:
        with pytest.raises(FreerockError) as error:
            check_room(tmp_path / ".snakemake", NOTES_BYTES)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, most)
    assert str(error.value) == (
        f"{tmp_path}: can't be written (File too large); "
        "free some space, give yourself the right to write there, or use --directory"
    )
