"""Records of foreign physics go through the workflow, and what is true of them stays apart."""

import json
import shutil
import subprocess
import sys

import pytest
from small_campaign import ROOT, check_out

from freerock.tables.csvfile import read_csv
from freerock_bench import foreign

pytestmark = pytest.mark.slow
TESTS = ("rigid_by_side",)  # of a .mat file, and soon fitted


def test_foreign_records_are_analysed_without_their_truths(tmp_path):
    checkout = check_out(tmp_path)
    for part in ("config/campaigns/foreign.yaml", "config/campaigns/foreign.csv"):
        shutil.copy2(ROOT / part, checkout / part)
    shutil.copytree(ROOT / "raw/foreign", checkout / "raw/foreign")
    lines = (checkout / "config/campaigns/foreign.csv").read_text().splitlines()
    kept = [lines[0], *(line for line in lines if line.startswith(TESTS))]
    (checkout / "config/campaigns/foreign.csv").write_text("\n".join(kept) + "\n")
    (checkout / "config/config.yaml").write_text("campaigns: [foreign]\n")
    text = (checkout / "config/campaigns/foreign.yaml").read_text()
    (checkout / "config/campaigns/foreign.yaml").write_text(
        text + "\nfits: {models: [housner], paper_mode: true}\n"
    )

    done = checkout.snakemake(*(f"results/foreign/tables/{name}.csv" for name in foreign.TABLES))
    assert done.returncode == 0, done.stderr
    assert not (checkout / "benchmarks").exists()  # nothing of the truths was there to be read

    truths = json.loads((ROOT / foreign.TRUTHS).read_text())
    graded = foreign.score(checkout / "results/foreign", {name: truths[name] for name in TESTS})
    assert set(graded["case"]) == {*TESTS}
    missed = graded.loc[graded["parameter"] == "verdict missed", "inside"]
    assert len(missed) == sum(len(truths[name]["runs"]) for name in TESTS) and not missed.any()
    assert set(read_csv(checkout / "results/foreign/tables/runs.csv")["origin"]) == {"simulated"}


def test_no_generator_imports_freerock():
    for path in (ROOT / "benchmarks/foreign").glob("*.py"):
        assert "import freerock" not in path.read_text() and "from freerock" not in path.read_text()


def test_records_are_as_listed():
    listed = (ROOT / "raw/foreign/manifest.csv").read_text().splitlines()[1:]
    files = {line.split(",")[0] for line in listed}
    truths = json.loads((ROOT / foreign.TRUTHS).read_text())
    assert {name.split(".")[0] for name in files} == set(truths)
    golden = ROOT / "src/freerock_bench/golden/solutions"
    package = [*golden.iterdir(), *(ROOT / "raw/foreign").iterdir(), ROOT / foreign.TRUTHS]
    assert sum(path.stat().st_size for path in package) <= 12e6


def test_a_rigid_record_is_made_again(tmp_path):
    """Of another machine's rounding at most the last count differs."""
    code = f"""
import sys; sys.path.insert(0, {str(ROOT / "benchmarks/foreign")!r}); sys.argv = ["make.py", "none"]
from pathlib import Path
import make
make.RAW = Path({str(tmp_path)!r})
make.make("rigid_by_side", 1 + list(make.SCENES).index("rigid_by_side"))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    from freerock.records.read import read_record

    one, other = (
        read_record(folder / "rigid_by_side.mat", "laser")["laser"].values
        for folder in (tmp_path, ROOT / "raw/foreign")
    )
    assert abs(one - other).max() < 1.5 * 10.5 / 2**15
