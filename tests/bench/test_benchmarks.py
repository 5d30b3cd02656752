"""What measures by hand and what draws the figures of the docs imports what is there."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
SCRIPTS = [*sorted((ROOT / "src/freerock_bench").glob("*.py")), ROOT / "docs/images/draw.py"]
IMPORT = "import runpy, sys; [runpy.run_path(path, run_name='imported') for path in sys.argv[1:]]"


def test_benchmarks_are_imported():
    command = [sys.executable, "-c", IMPORT, *map(str, SCRIPTS)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
