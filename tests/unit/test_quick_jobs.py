"""Jobs leave out what takes time and serves nothing in them: garbage, the help of Matplotlib."""

import subprocess
import sys
from pathlib import Path

import pytest

WORKFLOW = Path(__file__).parents[2] / "workflow"
PRINT_AT_THE_END = """
import atexit, gc
atexit.register(lambda: print(gc.get_freeze_count()))  # after what is registered later
import freerock.jobs.garbage
print(gc.get_threshold()[0])
"""
LATER = """
import sys
import freerock.jobs.no_stats, freerock.jobs.make_fits
from lmfit.minimizer import norm_dist
print("scipy.stats.distributions" in sys.modules or bool(sys.modules["matplotlib"]))
print(round(norm_dist.cdf(1.96), 3), "scipy.stats.distributions" in sys.modules)
"""


@pytest.mark.parametrize(
    "file",
    [*sorted(WORKFLOW.glob("scripts/*.py")), WORKFLOW / "rules/common.smk"],
    ids=lambda path: path.name,
)
def test_it_is_the_first_of_our_modules_that_a_job_and_the_workflow_import(file):
    ours = [
        line
        for line in file.read_text().splitlines()
        if line.startswith(("import freerock", "from freerock"))
    ]
    assert ours[0].split("#")[0].strip() == "import freerock.jobs.garbage"


def test_python_looks_for_garbage_seldom_and_not_at_the_end():
    threshold, frozen = map(int, subprocess.check_output([sys.executable, "-c", PRINT_AT_THE_END]).split())
    assert threshold >= 10_000 and frozen > 1000


@pytest.mark.parametrize("script", ["figure.py", "quality.py"])
def test_jobs_that_draw_leave_out_the_help_of_matplotlib_before_they_import_it(script):
    ours = [
        line for line in (WORKFLOW / "scripts" / script).read_text().splitlines() if "import freerock" in line
    ]
    assert "import freerock.jobs.no_help" in ours[1]
    printed = "import freerock.jobs.no_help; from matplotlib.lines import Line2D; print(Line2D.set.__doc__)"
    assert "dash_joinstyle" not in subprocess.check_output([sys.executable, "-c", printed], text=True)


def test_a_fit_imports_distributions_only_when_they_are_used():
    text = (WORKFLOW / "scripts/fit.py").read_text()
    assert "import freerock.jobs.garbage\nimport freerock.jobs.no_stats" in text
    told = subprocess.check_output([sys.executable, "-c", LATER], text=True).split()
    assert told == ["False", "0.975", "True"]
