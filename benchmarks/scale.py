"""Campaigns of many records: wall time, processor time and memory over their number.

python benchmarks/scale.py run [6 60 600 …] | plan [600 6000 …]
"""

import argparse
import math
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from itertools import pairwise, product
from pathlib import Path
from statistics import median

os.environ["OMP_NUM_THREADS"] = "1"  # as in the workflow's jobs

import numpy as np
import pandas as pd

from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS, palermo_releases
from freerock.virtual_lab.virtual_record import simulate_record
from freerock.virtual_lab.write_tdms import write_records

ROOT = Path(__file__).parents[1]
SNAKEFILE = ROOT / "Snakefile"
PLAIN = """
import csv
TESTS = [row["test"] for row in csv.DictReader(open("config/campaigns/scale.csv"))]
R, L = "results/{campaign}", "results/{campaign}/logs"
def files(pattern, **values):
    return expand(f"{R}/{pattern}", **values, allow_missing=True)
RECORDS, FITS = (files("{kind}/{test}.nc", kind=kind, test=TESTS) for kind in ("records", "fits"))
PAGES = files("figures/qc_{test}.{suffix}", test=TESTS, suffix=["png", "pdf", "csv"])
TABLES, PRINTED = files("tables/{n}.csv", n=range(16)), files("tables/{n}.tex", n=range(9))
DRAWN = files("figures/{n}.{suffix}", n=range(8), suffix=["png", "pdf", "csv", "txt"])
REPORT = files("report.{n}", n=range(6))
wildcard_constraints:
    n="[0-9]+",
rule all:
    input: expand([*RECORDS, *FITS, *PAGES, *TABLES, *PRINTED, *DRAWN, *REPORT, f"{R}/end"], campaign="scale")
rule record:
    input: "raw/{campaign}/{test}.tdms"
    output: f"{R}/records/{{test}}.nc"
    log: f"{L}/record_{{test}}.log"
    shell: "touch {output}"
rule fit:
    input: f"{R}/records/{{test}}.nc"
    output: f"{R}/fits/{{test}}.nc"
    log: f"{L}/fit_{{test}}.log"
    shell: "touch {output}"
rule quality:
    input: f"{R}/records/{{test}}.nc", f"{R}/fits/{{test}}.nc"
    output: files("figures/qc_{test}.{suffix}", suffix=["png", "pdf", "csv"])
    log: f"{L}/quality_{{test}}.log"
    shell: "touch {output}"
rule tables:
    input: RECORDS, FITS
    output: TABLES
    log: f"{L}/tables.log"
    shell: "touch {output}"
rule printed_tables:
    input: TABLES
    output: PRINTED
    log: f"{L}/printed_tables.log"
    shell: "touch {output}"
rule figure:
    input: lambda w: expand([RECORDS, FITS, RECORDS + FITS, *[TABLES] * 5][int(w.n)], campaign=w.campaign)
    output: files("figures/{n}.{suffix}", suffix=["png", "pdf", "csv", "txt"])
    log: f"{L}/figure_{{n}}.log"
    shell: "touch {output}"
rule report:
    input: RECORDS, FITS, PAGES, TABLES, PRINTED, DRAWN
    output: REPORT
    log: f"{L}/report.log"
    shell: "touch {output}"
rule complete:
    input: REPORT, f"{R}/tables/0.csv"
    output: f"{R}/end"
    log: f"{L}/complete.log"
    shell: "touch {output}"
"""
COLUMNS = "test,file,channel,block,foundation,laser,exclude,override,reason,note\n"
SCENES = [*product(CONFIGURATIONS, FOUNDATIONS)]  # of the records, in turn
LASERS = {"config1": "at_220mm", "config2": "at_200mm", "config3": "at_100mm"}


def record(number: int, runs: int):
    """A simulated record whose impacts scatter by 1 %."""
    block, foundation = SCENES[number % len(SCENES)]
    (shape, angle, laser), seed = CONFIGURATIONS[block], 1 + number
    parameters = FOUNDATIONS[foundation]
    releases = palermo_releases(angle, parameters, np.random.RandomState(seed), number=runs, sigma_r=0.01)
    return simulate_record(shape, laser, "hunt_crossley", releases, seed=seed)


def write_campaign(folder: Path, n: int, *, runs: int = 1, files: bool = True) -> None:
    """A campaign of n records with its configuration; without files, only what a plan needs."""
    (folder / "config/campaigns").mkdir(parents=True)
    (folder / "raw/scale").mkdir(parents=True)
    (folder / "config/config.yaml").write_text("campaigns: [scale]\n")
    palermo = (ROOT / "config/campaigns/palermo_virtual.yaml").read_text(encoding="utf-8")
    kept = re.search(r"^blocks:.*?(?=^# Tables)", palermo, re.M | re.S)[0]
    head = "title: Many records\norigin: simulated\n"
    (folder / "config/campaigns/scale.yaml").write_text(head + kept)
    names, lines = [f"r{number:05d}" for number in range(n)], []
    for number, name in enumerate(names):
        block, foundation = SCENES[number % len(SCENES)]
        lines.append(f"{name},{name}.tdms,,{block},{foundation},{LASERS[block]},,,,\n")
    (folder / "config/campaigns/scale.csv").write_text(COLUMNS + "".join(lines))
    if files:
        write_records(folder / "raw/scale", ((name, record(i, runs)) for i, name in enumerate(names)))
    else:
        for name in names:
            (folder / f"raw/scale/{name}.tdms").touch()


def snakemake(folder: Path, *arguments: str, cores: int = 2, snakefile: Path = SNAKEFILE) -> dict:
    """Run a workflow in a folder; wall and processor time [s], largest memory of a process [MB], output."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    command = [sys.executable, "-m", "snakemake", "--snakefile", snakefile, "--directory", folder]
    command += ["--profile", ROOT / "profiles/default", "--cores", str(cores), *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    return {
        "wall_s": wall,
        "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "peak_mb": after.ru_maxrss / 1024,
        "output": done.stdout + done.stderr,
    }


def jobs(done: dict) -> int:
    return int((re.findall(r"^total +(\d+)$", done["output"], re.M) or [0])[0])


def run(numbers: list[int], cores: int) -> None:
    """Analyse campaigns of so many records, then again, then with one record more."""
    walls = []
    for n in numbers:
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch, "campaign")
            write_campaign(folder, n)
            plan = snakemake(folder, "--dry-run", "--quiet", "all")
            whole = snakemake(folder, cores=cores)
            again = [snakemake(folder) for _ in range(5)]
            assert all("Nothing to be done" in each["output"] for each in again)
            idle = sorted(each["wall_s"] for each in again)
            by_step = steps(folder)
            added = add_one(folder, n)
        walls.append((n, whole["wall_s"]))
        print(
            f"{n:5d} records: {whole['wall_s']:7.1f} s wall, {whole['cpu_s'] / n:5.2f} s CPU per record, "
            f"{jobs(whole)} jobs, {whole['peak_mb']:.0f} MB at most; plan {plan['wall_s']:.1f} s, "
            f"nothing to do {median(idle):.1f} s ({idle[0]:.1f} to {idle[-1]:.1f}), "
            f"one record more {jobs(added)} jobs",
            flush=True,
        )
        for step, spent in by_step.iterrows():
            print(f"        {step:26s} {spent.cpu_time / n:6.3f} s CPU per record, {spent.max_rss:4.0f} MB")
    for (n, wall), (more, longer) in pairwise(walls):
        exponent = math.log(longer / wall) / math.log(more / n)
        print(f"{n} to {more} records: wall time grows with the power {exponent:.2f}")


def measured(n: int, cores: int) -> list[dict]:
    """Rows of `freerock_bench.scale`: what n records of three runs take, whole and by step, and 600 records.

    All cores share the jobs of a record; then tables, figures and report follow one another.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch, "campaign")
        write_campaign(folder, n, runs=3)
        whole, by_step = snakemake(folder, cores=cores), steps(folder)
    rows = [("whole", "processor time", whole["cpu_s"] / n)]
    for step, spent in by_step.iterrows():
        rows += [(step, "processor time", spent.cpu_time / n), (step, "memory", spent.max_rss)]
    last = by_step.cpu_time.loc[["tables", "report"]].sum()
    last += by_step.cpu_time.filter(like="figure_").max()
    for many in (2, 32):
        minutes = 600 / 60 * ((whole["cpu_s"] - last) / many + last) / n
        rows.append((f"600 records, {many} cores", "minutes", minutes))
    return [dict(zip(("case", "parameter", "value"), row, strict=True)) for row in rows]


def add_one(folder: Path, n: int) -> dict:
    """The plan of the finished campaign with one record more."""
    shutil.copy(folder / "raw/scale/r00000.tdms", folder / "raw/scale/added.tdms")
    with open(folder / "config/campaigns/scale.csv", "a", encoding="utf-8") as file:
        file.write("added,added.tdms,,config1,marble,at_220mm,,,,\n")
    return snakemake(folder, "--dry-run")


def steps(folder: Path) -> pd.DataFrame:
    """Processor time [s] and largest memory [MB] of each step, from the last lines of its logs."""
    paths = sorted((folder / "results/scale/logs").glob("*.log"))
    line = re.compile(r"(\S+) s of processor time, at most (\S+) MB")
    spent = [line.findall(path.read_text())[-1] for path in paths]
    names = [re.sub(r"^(record|fit|quality)_.*", r"\1", path.stem) for path in paths]
    frame = pd.DataFrame(spent, columns=["cpu_time", "max_rss"], dtype=float)
    return frame.groupby(names, sort=False).agg({"cpu_time": "sum", "max_rss": "max"})


def plan(numbers: list[int]) -> None:
    """How long Snakemake plans campaigns of so many records, and the same files by plain rules."""
    for n in numbers:
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch, "campaign")
            write_campaign(folder, n, files=False)
            (folder / "shell").write_text(PLAIN)
            (folder / "script").write_text(PLAIN.replace('shell: "touch {output}"', 'script: "nothing.py"'))
            (folder / "nothing.py").touch()
            given = ("--dry-run", "--quiet", "all")
            each = (SNAKEFILE, folder / "shell", folder / "script")
            spent = [[snakemake(folder, *given, snakefile=one)["cpu_s"] for one in each] for _ in range(3)]
        ours, shell, script = (min(column) for column in zip(*spent, strict=True))
        print(
            f"{n:5d} records, planned: {ours:.1f} s CPU; {ours / shell:.2f} times plain rules that touch, "
            f"{ours / script:.2f} times plain rules with an empty script",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command", choices=["run", "plan"])
    parser.add_argument("numbers", type=int, nargs="*", help="of records; 6 60 600, and 600 6000 of a plan")
    parser.add_argument("--cores", type=int, default=2)
    given = parser.parse_args()
    if given.command == "plan":
        plan(given.numbers or [600, 6000])
    else:
        run(given.numbers or [6, 60, 600], given.cores)


if __name__ == "__main__":
    main()
