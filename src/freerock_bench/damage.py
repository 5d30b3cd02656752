"""Campaigns damaged and runs killed at random: one `snakemake` then makes the bytes of a run from scratch.

python -m freerock_bench.damage damage [campaigns] | kills [campaigns]

Both take --seed N.

`damage`: each campaign is damaged one to three times, then brought up to date. That must end with exit code
0 and the bytes of a run from scratch, or with another and a line that says what to do. `kills`: ten times a
run or a job of up to three runs at once is killed; then one run ends the work. What else happens is counted,
and its folder is kept. All is done in memory, in /dev/shm. Runs that nobody kills are forked from a Python
that holds the libraries, and nothing of freerock.
"""

import argparse
import hashlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import psutil

from freerock.files import PARTIAL
from freerock.virtual_lab.write_tdms import write_records

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "workflow"))

FITS = "fits: {models: [hunt_crossley], paper_mode: true}\n"  # the quickest
SETTINGS = [  # a line of the configuration, and what it becomes
    ("yaml", "mass_kg: 2.98", "mass_kg: 2.97"),
    ("yaml", "records_per_job: 2\n", "records_per_job: 1\n"),
    ("yaml", "label: Mat", "label: Rubber mat"),
    ("csv", "squat,mat,low,,,,", "squat,mat,low,record,,wet base,"),
]
BESIDE = {"logs", "benchmarks", "ledger"}
IN_MEMORY = Path("/dev/shm")
OLD_S = 1_000_000_000  # a time stamp, of 2001
TOLD = re.compile(r"^[^:\n]+: .+; .+$")
KILLS, AT_ONCE = 10, 3


class Lab:
    """A folder with a campaign."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.results = folder, folder / "results/tiny"

    def copied(self, to: Path, *parts: str) -> "Lab":
        """This folder copied, or parts of it."""
        for part in parts or os.listdir(self.folder):
            shutil.copytree(self.folder / part, to / part)
        return Lab(to)

    def begin(self, cores: int, warm: bool = False) -> tuple[subprocess.Popen, Path]:
        """Snakemake at work, and the file of what it says; a warm one passes no signal on."""
        from warm import commands

        out = Path(f"{self.folder}_{time.monotonic_ns()}.out")
        python = commands() / "python" if warm else sys.executable
        command = [python, "-m", "snakemake", "--snakefile", ROOT / "Snakefile"]
        command += ["--directory", self.folder, "--profile", ROOT / "profiles/default"]
        command += ["--cores", str(cores)]
        with open(out, "w") as told:
            streams = {"stdout": told, "stderr": told, "stdin": subprocess.DEVNULL}
            streams["env"] = os.environ | {"PYTHONPATH": str(ROOT / "src")}
            return subprocess.Popen(command, **streams, start_new_session=True), out

    def run(self, cores: int = 1) -> tuple[int, str]:
        """Exit code of one `snakemake`, and what it said."""
        run, out = self.begin(cores, warm=True)
        return run.wait(), out.read_text()

    def files(self, ledger: bool = False) -> list[Path]:
        """Products, or the entries of the ledger."""
        found = (path for path in sorted(self.results.rglob("*")) if path.is_file())
        found = ((path.relative_to(self.results), path) for path in found if not path.name.startswith("."))
        return [
            path
            for name, path in found
            if (name.parts[0] == "ledger" if ledger else name.parts[0] not in BESIDE)
        ]

    def products(self) -> dict[str, bytes]:
        """Bytes of each product."""
        return {path.relative_to(self.results).as_posix(): path.read_bytes() for path in self.files()}


class Reference:
    """What runs from scratch make, by configuration and records."""

    def __init__(self, scratch: Path) -> None:
        self.scratch, self.made = scratch, {}

    def of(self, lab: Lab) -> tuple[int, dict[str, bytes]]:
        """Exit code and products of a run from scratch on the configuration and records of a lab."""
        files = sorted(path for part in ("config", "raw") for path in (lab.folder / part).rglob("*.*"))
        told = [(path.relative_to(lab.folder).as_posix(), path.read_bytes()) for path in files]
        key = hashlib.sha256(repr(told).encode()).hexdigest()
        if key not in self.made:
            fresh = lab.copied(self.scratch / f"reference_{len(self.made)}", "config", "raw")
            self.made[key] = fresh.run()[0], fresh.products()
        return self.made[key]


def write_campaign(folder: Path, seed: int) -> Lab:
    """A campaign of two records, not analysed."""
    from small_campaign import BLOCKS, CAMPAIGN, Checkout, add_campaign, simulated

    (folder / "config/campaigns").mkdir(parents=True)
    yaml = CAMPAIGN.replace("records_per_job: 1", "records_per_job: 2")  # fewer jobs, of every kind
    add_campaign(Checkout(folder), "tiny", yaml + FITS, [(f"{block}_mat", "", block) for block in BLOCKS])
    records = [(f"{block}_mat", simulated(block, seed + number)) for number, block in enumerate(BLOCKS)]
    write_records(folder / "raw/tiny", records)
    return Lab(folder)


def delete(lab, chance, other):
    files = lab.files()
    for path in chance.sample(files, min(len(files), chance.randint(1, 3))):
        path.unlink(missing_ok=True)


def empty(path, chance):
    path.write_bytes(b"")


def cut(path, chance):
    path.write_bytes(path.read_bytes()[: chance.randrange(path.stat().st_size)])


def flip_a_byte(path, chance):
    """Another bit somewhere in a file."""
    data = bytearray(path.read_bytes() or b"0")
    data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    path.write_bytes(data)


def replace_with_old_time(path, chance):
    flip_a_byte(path, chance)
    os.utime(path, (OLD_S, OLD_S))


def restore_with_old_time(lab, chance, other):
    for path in chance.sample(lab.files(), 3):
        os.utime(path, (OLD_S, OLD_S))


def drop_notes(lab, chance, other):
    shutil.rmtree(lab.folder / ".snakemake", ignore_errors=True)


def change_a_setting(lab, chance, other):
    suffix, old, new = chance.choice(SETTINGS)
    path = lab.folder / f"config/campaigns/tiny.{suffix}"
    path.write_text(path.read_text().replace(old, new))


def swap_two(lab, chance, other):
    suffix = chance.choice(sorted({path.suffix for path in lab.files()}))
    alike = [path for path in lab.files() if path.suffix == suffix]
    one, two = chance.sample(alike, 2) if len(alike) > 1 else chance.sample(lab.files(), 2)
    kept = one.with_name(".kept")
    for source, target in ((one, kept), (two, one), (kept, two)):
        source.rename(target)


def copy_from_another(lab, chance, other):
    """Results of the campaign of this name with other records, all or some, with their ledger or without."""
    with_ledger, share = chance.random() < 0.5, chance.choice([0.3, 1])
    for path in [*other.files(), *(other.files(ledger=True) if with_ledger else ())]:
        to = lab.results / path.relative_to(other.results)
        if chance.random() < share and to.parent.exists():
            shutil.copy2(path, to)


def copy_without_times(lab, chance, other):
    kept = lab.folder / "kept"
    lab.results.rename(kept)
    shutil.copytree(kept, lab.results, copy_function=shutil.copyfile)
    shutil.rmtree(kept)


def replace_a_record(lab, chance, other):
    """By another campaign's, with an old time; the manifest lists the one that was there, or is gone."""
    name = chance.choice(sorted(path.name for path in (lab.folder / "raw/tiny").glob("*.tdms")))
    shutil.copyfile(other.folder / f"raw/tiny/{name}", lab.folder / f"raw/tiny/{name}")
    os.utime(lab.folder / f"raw/tiny/{name}", (OLD_S, OLD_S))
    if chance.random() < 0.5:
        (lab.folder / "raw/tiny/manifest.csv").unlink(missing_ok=True)


def damage_the_ledger(lab, chance, other):
    path = chance.choice(lab.files(ledger=True))
    kind = chance.choice(["delete", cut, flip_a_byte, "copy"])
    if kind == "delete":
        path.unlink()
    elif kind == "copy":
        shutil.copy2(chance.choice([each for each in lab.files(ledger=True) if each != path]), path)
    else:
        kind(path, chance)


OF_A_FILE = [empty, cut, flip_a_byte, replace_with_old_time]
DAMAGES = [delete, *OF_A_FILE, restore_with_old_time, drop_notes, change_a_setting, swap_two]
DAMAGES += [copy_from_another, copy_without_times, replace_a_record, damage_the_ledger]


def hurt(lab, chance, other, kind):
    """Do one damage to a lab, or to one of its products."""
    if kind in OF_A_FILE:
        kind(chance.choice(lab.files()), chance)
    else:
        kind(lab, chance, other)


def last_line(told: str) -> str:
    return (told.splitlines() or ["it says nothing"])[-1]


def what_is_wrong(lab: Lab, code: int, told: str, reference: Reference) -> str:
    """Why a run did not end as it should; empty where it did."""
    last = last_line(told)
    if "Traceback" in told:
        return "a traceback"
    if code:
        return "" if TOLD.match(last) else f"no line that says what to do: {last}"
    code_of_scratch, products = reference.of(lab)
    if code_of_scratch:
        return "a run from scratch does not end well"
    made = lab.products()
    if wrong := [path for path in products if made.get(path) != products[path]]:
        return f"other bytes: {', '.join(wrong)}"
    foreign = {*made} - {*products}
    if foreign and "not of this configuration: " not in last:
        return f"not named though foreign: {', '.join(foreign)}"
    return ""


Outcome = tuple[
    "Lab", str, str, str, list[str]
]  # its lab, what was done, how it ended, what is wrong, counts
SAME, LINE = "the bytes of a run from scratch", "a line that says what to do"


def damage(scratch: Path) -> Callable[[Path, random.Random], Outcome]:
    """Campaigns damaged one to three times, then brought up to date."""
    base, other = bases = [write_campaign(scratch / f"base_{seed_of}", seed_of) for seed_of in (0, 10)]
    assert all(each.run()[0] == 0 for each in bases)
    reference = Reference(scratch)

    def one(folder: Path, chance: random.Random) -> Outcome:
        lab = base.copied(folder)
        done = chance.choices(DAMAGES, k=chance.randint(1, 3))
        for each in done:
            with suppress(FileNotFoundError, ValueError, IndexError):  # nothing is left to damage
                hurt(lab, chance, other, each)
        code, told = lab.run()
        wrong, names = what_is_wrong(lab, code, told, reference), [each.__name__ for each in done]
        what = ", ".join(names) + (f": {last_line(told)}" if code else "")
        return lab, what, LINE if code else SAME, wrong, names

    return one


def jobs_of(run: subprocess.Popen) -> list[psutil.Process]:
    """The scripts that a run has at work."""
    with suppress(psutil.Error):
        below = psutil.Process(run.pid).children(recursive=True)
        return [each for each in below if any(".snakemake/scripts" in word for word in _words(each)[1:2])]
    return []


def _words(process: psutil.Process) -> list[str]:
    with suppress(psutil.Error):
        return process.cmdline()
    return []


def kill_something(runs: list[subprocess.Popen], chance: random.Random) -> str:
    """Wait for a random moment, of a job's first two seconds or any, and kill a run, a job or both.

    Returns what was killed; nothing where the run ended before.
    """
    run, end = chance.choice(runs), time.monotonic() + 60
    kind = chance.choice(["run", "job", "run with its jobs"])
    if early := chance.random() < 0.7:
        known = {job.pid for job in jobs_of(run)}
        while run.poll() is None and not {job.pid for job in jobs_of(run)} - known and time.monotonic() < end:
            time.sleep(0.01)
    time.sleep(chance.uniform(0, 2 if early else 8))
    with suppress(psutil.Error, ProcessLookupError):
        if run.poll() is not None:  # its number may be another's by now
            return ""
        if kind == "run with its jobs":
            os.killpg(run.pid, signal.SIGKILL)
        else:
            chance.choice((jobs_of(run) if kind == "job" else []) or [run]).send_signal(signal.SIGKILL)
        return f"{kind}, early" if early else kind
    return ""


def kills(scratch: Path) -> Callable[[Path, random.Random], Outcome]:
    """Campaigns at which ten runs and jobs are killed, then one run ends the work."""
    fresh = write_campaign(scratch / "fresh", 0)
    finished = fresh.copied(scratch / "finished")
    assert finished.run()[0] == 0
    reference = Reference(scratch)

    def one(folder: Path, chance: random.Random) -> Outcome:
        lab = chance.choice([finished, fresh]).copied(folder)
        change_a_setting(lab, chance, lab)
        outs, runs, killed = [], [], []
        while len(killed) < KILLS:
            runs = [run for run in runs if run.poll() is None]
            if not runs:
                delete(lab, chance, lab)  # there is always something to do
            for _ in range(chance.randint(1, AT_ONCE) - len(runs)):
                run, out = lab.begin(cores=2)
                runs.append(run)
                outs.append(out)
                time.sleep(chance.choice([0, 0, 0.5]))
            if runs and (kind := kill_something(runs, chance)):
                killed.append(kind)
        for run in runs:
            run.wait()
        code, told = lab.run(cores=2)
        said = [out.read_text() for out in outs]
        wrong = what_is_wrong(lab, code, told, reference) or (last_line(told) if code else "")
        if not wrong and any("free some space" in each or "Traceback" in each for each in said):
            wrong = "a traceback or a message about space"
        elif not wrong and list(lab.folder.rglob(PARTIAL)):
            wrong = "half files are left"
        noted = ["refused: another run at work"] * sum("another run is at work" in each for each in said)
        waited = sum("waiting for the jobs" in each for each in [*said, told])
        noted += ["waited for jobs left at work"] * waited
        return lab, f"{KILLS} kills", SAME, wrong, [*killed, *noted]

    return one


STUDIES = {"damage": (damage, 200), "kills": (kills, 10)}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("number", type=int, nargs="?", help="200 and 10 when left out")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    study, usual = STUDIES[given.study]
    scratch = Path(tempfile.mkdtemp(dir=IN_MEMORY if IN_MEMORY.is_dir() else None))
    one, n, ends, counts = study(scratch), given.number or usual, Counter(), Counter()
    for number in range(1, n + 1):
        folder = scratch / f"campaign_{number}"
        lab, what, end, wrong, counted = one(folder, random.Random(f"{given.seed} {number}"))
        ends["wrong" if wrong else end] += 1
        counts.update(counted)
        print(f"{number}: {what}: {f'{wrong}; kept in {lab.folder}' if wrong else end}", flush=True)
        if not wrong:
            shutil.rmtree(lab.folder)
    print(f"{n} campaigns: " + "; ".join(f"{count} {end}" for end, count in (ends + counts).items()))
    if not ends["wrong"]:
        shutil.rmtree(scratch)
    return bool(ends["wrong"])


if __name__ == "__main__":
    sys.exit(main())
