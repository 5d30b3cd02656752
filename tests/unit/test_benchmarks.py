"""The benchmarks and what draws the figures of the docs import what is there."""

import runpy
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
SCRIPTS = [*sorted(ROOT.glob("benchmarks/*.py")), ROOT / "docs/images/draw.py"]
IMPORT = "import runpy, sys; [runpy.run_path(path, run_name='imported') for path in sys.argv[1:]]"


def test_the_functions_whose_cost_is_taken_are_there():
    scale = runpy.run_path(str(ROOT / "benchmarks/scale.py"), run_name="imported")
    for step, functions in scale["PARTS"].items():
        module = import_module(f"freerock.jobs.{step}")
        assert all(hasattr(module, name) for name in functions)


def test_benchmarks_are_imported():
    command = [sys.executable, "-c", IMPORT, *map(str, SCRIPTS)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
