"""The studies are a target of their own."""

import os
import re
import runpy
from pathlib import Path

from small_campaign import ROOT

from freerock.jobs.code_checksum import code_files


def test_only_on_demand(finished):
    alone = finished.snakemake("--dry-run", "--forceall")
    asked = finished.snakemake("--dry-run", "studies")
    assert alone.returncode == asked.returncode == 0, alone.stderr + asked.stderr
    assert "study" not in alone.stdout + alone.stderr
    jobs = dict(re.findall(r"^(\w*stud\w*) +(\d+)$", asked.stdout + asked.stderr, re.M))
    assert jobs == {"study": "2", "study_figure": "4", "studies": "1"}


def test_a_study_and_its_figure(checkout):
    """A study without processes of its own, small, with every module its scripts import among their code."""
    path = os.pathsep.join(str(checkout / part) for part in ("src", "hook"))
    wanted = [f"results/studies/figures/speed_accuracy.{suffix}" for suffix in ("pdf", "png", "csv")]
    done = checkout.snakemake(
        *wanted, "--config", "studies=small", PYTHONPATH=path, TRACE=str(checkout / "trace")
    )
    assert done.returncode == 0, done.stderr
    assert all((checkout / product).stat().st_size > 0 for product in wanted)
    modules = {"study.py": "speed_accuracy", "study_figure.py": "figures.speed_accuracy"}
    for script, module in modules.items():
        (trace,) = (checkout / "trace").glob(f"{script}*")
        files = code_files(ROOT / "workflow/scripts" / script, f"freerock_bench.{module}")
        imported = {Path(file).relative_to(checkout / "src") for file in trace.read_text().split("\n")}
        assert imported <= {*map(Path, files)}
        assert Path("freerock_bench", *module.split(".")).with_suffix(".py") in imported


def test_the_processes_of_a_study_do_not_start_its_job_again():
    """They import the script that started them, under this name and without its job."""
    runpy.run_path(str(ROOT / "workflow/scripts/study.py"), run_name="__mp_main__")
