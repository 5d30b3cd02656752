"""Jobs look for garbage seldom, and from their first import on."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

WORKFLOW = Path(__file__).parents[2] / "workflow"
PRINT_AT_THE_END = """
import atexit, gc
atexit.register(lambda: print(gc.get_freeze_count()))  # after what is registered later
import freerock.jobs
print(gc.get_threshold()[0])
"""


@pytest.mark.parametrize(
    "file",
    [*sorted(WORKFLOW.glob("scripts/*.py")), WORKFLOW / "rules/common.smk"],
    ids=lambda path: path.name,
)
def test_that_room_is_the_first_of_ours_that_a_job_and_the_workflow_import(file):
    ours = [
        line
        for line in file.read_text().splitlines()
        if line.startswith(("import freerock", "from freerock"))
    ]
    assert re.match(r"(import|from) freerock\.jobs\b", ours[0])


def test_python_looks_for_garbage_seldom_and_not_at_the_end():
    threshold, frozen = map(int, subprocess.check_output([sys.executable, "-c", PRINT_AT_THE_END]).split())
    assert threshold >= 10_000 and frozen > 1000
