"""A small campaign in a checkout of its own, and Snakemake run in it."""

import fcntl
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from warm import commands

from freerock.models.block import Block
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.virtual_record import Recording, VirtualRelease, simulate_record

ROOT = Path(__file__).parents[2]
CAMPAIGN = """\
title: Two blocks on a mat
origin: simulated
blocks:
  tall: {height_m: 0.28, width_m: 0.07, mass_kg: 5.84}
  squat: {height_m: 0.14, width_m: 0.07, mass_kg: 2.98}
foundations:
  mat: {label: Mat}
lasers:
  high: {beam: horizontal, position_m: 0.2, range_m: 0.1}
  low: {beam: horizontal, position_m: 0.1, range_m: 0.1}
"""
BY = 'creator: "Rossi, Ada; Bianchi, Ugo"\ninstitution: Laboratory\nlicense: CC-BY-4.0\n'
COLUMNS = "test,file,channel,block,foundation,laser,exclude,override,reason,note\n"
BLOCKS = {
    "tall": (Block(0.28, 0.07, 5.84), Laser("horizontal", 0.2, 0.1), math.radians(10)),
    "squat": (Block(0.14, 0.07, 2.98), Laser("horizontal", 0.1, 0.1), math.radians(20)),
}
MAT = {"k": 2.86e6, "lambda": 8.16e7}

# Dumps, at the end of each script, the package's files that it has imported.
TRACE = """\
import atexit, os, sys

def dump():
    script = os.path.basename(sys.argv[0]).split(".", 1)[-1]
    modules = [module for name, module in sys.modules.items() if name.startswith("freerock")]
    with open(os.path.join(os.environ["TRACE"], script + str(os.getpid())), "w") as out:
        out.write("\\n".join(module.__file__ for module in modules))

if os.environ.get("TRACE") and ".snakemake/scripts" in sys.argv[0]:
    atexit.register(dump)
"""


def simulated(block, seed, *, angle_deg=None, **options):
    """A simulated record of one release, by default at 500 Hz; the options are those of `Recording`."""
    shape, laser, usual = BLOCKS[block]
    theta0 = usual if angle_deg is None else math.radians(angle_deg)
    release = VirtualRelease(theta0, MAT, tilt_s=1.2, held_s=1.5, pause_s=1.5)
    recording = Recording(**{"rate_hz": 500.0} | options)
    return simulate_record(shape, laser, "hunt_crossley", [release], seed=seed, recording=recording)


class Checkout:
    """A folder with the workflow, the package and a campaign."""

    def __init__(self, folder: Path):
        self.folder = folder

    def __truediv__(self, path) -> Path:
        return self.folder / path

    def snakemake(self, *arguments, warm=True, **environment) -> subprocess.CompletedProcess:
        environment = os.environ | {"PYTHONPATH": str(self.folder / "src")} | environment
        python = commands() / "python" if warm else sys.executable
        command = [python, "-m", "snakemake", "--cores", "2", *map(str, arguments)]
        return subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)

    def planned(self, *targets) -> dict:
        """Number of jobs a run would have, by rule."""
        done = self.snakemake("--dry-run", *targets)
        assert done.returncode == 0, done.stdout + done.stderr
        if "Nothing to be done" in done.stdout + done.stderr:
            return {}
        told = done.stdout + done.stderr
        stats = told.split("Job stats:")[1].split("total")[0]
        return {
            rule: int(number)
            for rule, number in re.findall(r"^(\w+) +(\d+)$", stats, re.M)
            if rule not in ("all", *targets)
        }

    def edit(self, path, old: str, new: str) -> None:
        text = (self / path).read_text(encoding="utf-8")
        assert text.count(old) == 1, f"{path}: {old!r}"
        (self / path).write_text(text.replace(old, new), encoding="utf-8")

    def partial_files(self) -> list[Path]:
        """Results that are half written."""
        return [path for path in (self / "results").rglob("*") if "partial" in path.name]

    def products(self) -> dict:
        """Bytes of each product; logs are none."""
        return {
            path.relative_to(self.folder).as_posix(): path.read_bytes()
            for path in sorted((self / "results").rglob("*"))
            if path.is_file() and path.parent.name != "logs"
        }


def once(tmp_path_factory, name: str, make) -> Path:
    """A folder made by the first test that asks for it, in whichever process of this run of the tests."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    folder, made = base / name, base / f"{name}.made"
    with open(base / f"{name}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            make(folder)
            made.touch()
    return folder


def check_out(folder: Path) -> Checkout:
    """The workflow and the package without a campaign."""
    for part in ("src", "workflow", "profiles"):
        shutil.copytree(ROOT / part, folder / part)
    shutil.copy2(ROOT / "Snakefile", folder)
    (folder / "config" / "campaigns").mkdir(parents=True)
    return Checkout(folder)


def copied(folder: Path, to: Path, *left_out: str) -> Path:
    """A copy of a folder; what Python compiled is linked, since it is replaced and never changed."""

    def copy(source, target):
        (os.link if "/__pycache__/" in source else shutil.copy2)(source, target)

    passing = shutil.ignore_patterns("iocache", "log", *left_out)  # another test may plan in the same folder
    return shutil.copytree(folder, to, ignore=passing, copy_function=copy)


def add_campaign(checkout: Checkout, name: str, yaml: str, records: list) -> None:
    """Configure a campaign and make it the one to analyse; a record is test, channel, block."""
    (checkout / "config/config.yaml").write_text(f"campaigns: [{name}]\n")
    (checkout / f"config/campaigns/{name}.yaml").write_text(yaml)
    lasers = {"tall": "high", "squat": "low"}
    lines = [
        f"{test},{test}.tdms,{channel},{block},mat,{lasers[block]},,,,\n" for test, channel, block in records
    ]
    (checkout / f"config/campaigns/{name}.csv").write_text(COLUMNS + "".join(lines))
