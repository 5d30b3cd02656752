"""Records of foreign physics go through the workflow, and what is true of them stays apart."""

import subprocess
import sys

from small_campaign import ROOT

from freerock_bench import foreign


def test_foreign_records_are_analysed_without_their_truths(tmp_path):
    graded = foreign.run("small", tmp_path, 1)
    assert not (tmp_path / "benchmarks").exists()  # nothing of the truths was there to be read
    truths = foreign.truths()
    assert set(graded["case"]) == {*foreign.SMALL}
    used = graded.loc[graded["parameter"] == "run is used", "inside"]
    assert len(used) == sum(len(truths[name]["runs"]) for name in foreign.SMALL) and used.all()
    assert "| **all** |" in foreign.markdown(graded)


def test_no_generator_imports_freerock():
    for path in (ROOT / "benchmarks/foreign").glob("*.py"):
        assert "import freerock" not in path.read_text() and "from freerock" not in path.read_text()


def test_records_are_as_listed():
    listed = (ROOT / "raw/foreign/manifest.csv").read_text().splitlines()[1:]
    files = {line.split(",")[0] for line in listed}
    truths = foreign.truths()
    assert {name.split(".")[0] for name in files} == set(truths)
    golden = ROOT / "src/freerock_bench/golden/solutions"
    package = [*golden.iterdir(), *(ROOT / "raw/foreign").iterdir(), foreign.TRUTHS]
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
