"""A test that hangs is a failure with its stack, under the settings of this project with shorter times."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WAITS = "__import__('time').sleep(60)"
LOOPS = "sum(__import__('itertools').repeat(0))"  # in compiled code, which no signal reaches


@pytest.mark.parametrize(
    ("hang", "timeout", "told"),
    [(WAITS, 60, "Failed: Timeout (>1.0s) from pytest-timeout"), (LOOPS, 2, "Timeout (0:00:02)!\n")],
    ids=["waits", "loops"],
)
def test_a_hang_is_a_failure_with_its_stack(hang, timeout, told, tmp_path, pytestconfig):
    limits = [float(pytestconfig.getini(name)) for name in ("timeout", "faulthandler_timeout")]
    assert 0 < limits[0] < limits[1] <= 1000
    file = tmp_path / "test_it.py"
    file.write_text(f"def test_it():\n    {hang}\n")
    options = ["-c", ROOT / "pyproject.toml", "-p", "no:cacheprovider", "-p", "no:xdist"]
    options += ["-o", "timeout=1", "-o", f"faulthandler_timeout={timeout}"]
    command = [sys.executable, "-m", "pytest", *options, file]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, cwd=tmp_path)
    assert done.returncode == 1
    assert told in done.stdout + done.stderr
    assert hang in done.stdout or f'{file}", line 2 in test_it' in done.stderr
