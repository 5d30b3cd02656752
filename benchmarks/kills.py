"""Runs that are killed: the same command then gives the bytes of a run from scratch.

python benchmarks/kills.py [20]

Snakemake is killed by SIGKILL at random times, alone and with its jobs in turn, and started again.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from scale import ROOT, SNAKEFILE, write_campaign

PROFILE = ROOT / "profiles/default"
COMMAND = [sys.executable, "-m", "snakemake", "--snakefile", f"{SNAKEFILE}", "--profile", f"{PROFILE}"]
LONGEST_S = 60.0  # of a run before it is killed
FOR_EVER_S = 3600.0
RECORDS = 3


def products(folder: Path) -> dict[str, bytes]:
    """Bytes of each product by its path; logs and halves of files are none."""
    paths = (path for path in (folder / "results").rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in paths
        if path.parent.name != "logs" and ".partial" not in path.name
    }


def killed(folder: Path, after_s: float, with_jobs: bool) -> bool:
    """Start a run and kill it after a time; whether it was at work."""
    nowhere = subprocess.DEVNULL
    run = subprocess.Popen(
        [*COMMAND, "--cores", "2"], cwd=folder, stdout=nowhere, stderr=nowhere, start_new_session=True
    )
    with suppress(subprocess.TimeoutExpired):
        run.wait(after_s)
        return False
    (os.killpg if with_jobs else os.kill)(run.pid, signal.SIGKILL)
    run.wait()
    subprocess.run([*COMMAND, "--unlock"], cwd=folder, check=True, capture_output=True)
    return True


def main() -> None:
    """Kill and go on, and print what differs from a run from scratch."""
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    rng = random.Random(1)
    with tempfile.TemporaryDirectory() as scratch:
        whole, cut = Path(scratch, "whole"), Path(scratch, "cut")
        for folder in (whole, cut):
            write_campaign(folder, RECORDS)
        start = time.perf_counter()
        subprocess.run([*COMMAND, "--cores", "2"], cwd=whole, check=True, capture_output=True)
        longest_s = min(LONGEST_S, 0.5 * (time.perf_counter() - start))
        whole_ones, differing, kills, runs = products(whole), set[str](), 0, 0
        while kills < n or (cut / "results").exists():
            if killed(cut, rng.uniform(2, longest_s) if kills < n else FOR_EVER_S, bool(kills % 2)):
                kills += 1
                continue
            runs, made = runs + 1, products(cut)
            differing |= {path for path in {**whole_ones, **made} if whole_ones.get(path) != made.get(path)}
            shutil.rmtree(cut / "results")
    print(f"{kills} kills, {runs} runs to the end: of {len(whole_ones)} products differ {sorted(differing)}")
    sys.exit(bool(differing))


if __name__ == "__main__":
    main()
