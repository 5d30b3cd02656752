"""A run whose folder is deleted ends, in one line."""

import resource
import subprocess
import sys
import time

import pytest

from freerock.errors import FreerockError
from freerock.jobs.watch import check_space

RUN = """
import time
from freerock.jobs.watch import watch_folder
watch_folder(every_s=0.05)
print("begun", flush=True)
time.sleep({seconds})
"""


def test_a_run_without_its_folder_ends_in_a_line(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    command = [sys.executable, "-c", RUN.format(seconds=60)]
    run = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert run.stdout.readline() == "begun\n"
    folder.rmdir()
    began = time.monotonic()
    _, told = run.communicate(timeout=30)
    assert run.returncode == 1
    assert told == f"{folder}: is no longer there; put it back, then run the same command\n"
    assert time.monotonic() - began < 10


def test_a_run_whose_folder_stays_ends_by_itself(tmp_path):
    command = [sys.executable, "-c", RUN.format(seconds=0.5)]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")


def test_a_run_without_room_for_its_notes_is_refused(tmp_path):
    check_space(tmp_path / ".snakemake")
    assert list(tmp_path.rglob("*")) == [tmp_path / ".snakemake"]
    most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, most[1]))
    try:
        with pytest.raises(FreerockError) as error:
            check_space(tmp_path / ".snakemake")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, most)
    assert str(error.value) == (
        f"{tmp_path}/.snakemake: can't be written (File too large); "
        "free some space, or give yourself the right to write there"
    )
