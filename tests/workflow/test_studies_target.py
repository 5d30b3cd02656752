"""The studies are a target of their own."""

import os
import re
from pathlib import Path

import pytest
from small_campaign import ROOT

from freerock.jobs.reruns import code


def test_only_on_demand(finished):
    alone = finished.snakemake("--dry-run", "--forceall")
    asked = finished.snakemake("--dry-run", "studies")
    assert alone.returncode == asked.returncode == 0, alone.stderr + asked.stderr
    assert "study" not in alone.stdout + alone.stderr
    jobs = dict(re.findall(r"^(\w*stud\w*) +(\d+)$", asked.stdout + asked.stderr, re.M))
    assert jobs == {"study": "14", "figure_study": "10", "studies": "1"}


@pytest.mark.parametrize("study", ["paper", "cost"])
def test_a_study_and_its_figure(checkout, study):
    """Without and with processes of its own, in its small size; what its scripts import is their code."""
    path = os.pathsep.join(str(checkout / part) for part in ("src", "hook"))
    wanted = [f"results/studies/figures/{study}.{suffix}" for suffix in ("pdf", "png", "csv")]
    done = checkout.snakemake(
        *wanted, "--config", "studies=small", PYTHONPATH=path, TRACE=str(checkout / "trace")
    )
    assert done.returncode == 0, done.stderr
    assert "is not a figure" not in done.stderr
    assert all((checkout / product).stat().st_size > 0 for product in wanted)
    modules = {"study.py": study, "figure_study.py": f"figures.{study}"}
    for script, module in modules.items():
        traces = (checkout / "trace").glob(f"{script}*")
        files = code(ROOT / "workflow/scripts" / script, f"freerock_bench.{module}")
        declared = {Path(file).relative_to(ROOT) for file in files}
        seen = {file for trace in traces for file in trace.read_text().split("\n")}
        imported = {Path(file).relative_to(checkout.folder) for file in seen}
        assert imported <= declared
        assert Path("src/freerock_bench", *module.split(".")).with_suffix(".py") in imported
