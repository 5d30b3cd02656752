"""A run whose folder is deleted ends, in one line."""

import subprocess
import sys
import time

RUN = """
import time
from freerock.jobs.guard import watch_folder
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
