"""A bad day: after every accident the same command finishes, and no byte differs from an undisturbed run.

What was seen is the table of docs/reliability.md; FREEROCK_WRITE=1 writes it again.
"""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from small_campaign import simulated
from warm import commands

from freerock.files import sha256
from freerock.jobs.contents import look
from freerock.products.groups import reasons_in
from freerock.products.netcdf import open_record
from freerock.runs.verdict import in_one_line
from freerock.virtual_lab.write_tdms import write_tdms

# Stage -> a product of its own; the job that makes it is the one that meets with the accident.
STAGES = {
    "record": "records/squat_mat.nc",
    "fit": "fits/squat_mat.nc",
    "quality": "figures/qc_squat_mat.csv",
    "tables": "tables/runs.csv",
    "figure": "figures/restitution.csv",
    "report": "report.html",
}
ACCIDENTS = ["full disk", "kill job", "kill run"]
RECORD, FIT = (f"results/small/{STAGES[stage]}" for stage in ("record", "fit"))
RAW = "raw/small/squat_mat.tdms"
SAME = "same command"
UNSEEN = "bytes changed, old time stamp"
PRIVATE = ["unshare", "--mount", "sh", "-c"]  # mounts that end with the command


@pytest.fixture(scope="module")
def undisturbed(finished):
    return finished.products()


@pytest.fixture(scope="module")
def seen():
    """What follows each accident, by accident and stage."""
    return {}


class Run:
    """Snakemake under way, its output in a file that no orphan holds up."""

    def __init__(self, checkout, *targets, accident="", wrap=()):
        hook = checkout / "accident"
        hook.mkdir(exist_ok=True)
        shutil.copy(Path(__file__).with_name("accident.py"), hook / "sitecustomize.py")
        self.mark, self.out = checkout / "mark", checkout / f"out_{time.monotonic_ns()}"
        path = os.pathsep.join(str(checkout / part) for part in ("src", "accident"))
        environment = {"PYTHONPATH": path, "ACCIDENT": accident, "MARK": str(self.mark), "AT": targets[0]}
        python = sys.executable if wrap else commands() / "python"
        with open(self.out, "w") as out:
            self.process = subprocess.Popen(
                [*wrap, python, "-m", "snakemake", "--cores", "2", *targets],
                cwd=checkout.folder,
                env=os.environ | environment,
                stdout=out,
                stderr=out,
            )

    def wait_for(self, condition):
        end = time.monotonic() + 300
        while not condition():
            assert time.monotonic() < end, self.told
            time.sleep(0.01)

    @property
    def told(self):
        return self.out.read_text()

    def ended(self):
        self.process.wait()
        return self


def run(checkout, *targets, **options):
    return Run(checkout, *targets, **options).ended()


def raw(checkout):
    return {path.name: sha256(path) for path in (checkout / "raw/small").iterdir()}


def private(mount, look="true"):
    """Wrap a command into mounts of its own, with a look at them afterwards; skips where not allowed."""
    if shutil.which("unshare") is None or subprocess.run([*PRIVATE, "mount -t tmpfs none /mnt"]).returncode:
        pytest.skip("mounting a file system is not allowed here")
    return [*PRIVATE, f'{mount} && "$@"; code=$?; {look}; exit $code', "sh"]


def heals(checkout, undisturbed, finished, target, again=None):
    """The same command finishes, nothing else is left over, the record files are as they were."""
    again = again or run(checkout, target)
    assert again.ended().process.returncode == 0, again.told
    assert checkout.products() == undisturbed
    assert raw(checkout) == raw(finished)


@pytest.mark.parametrize("stage", STAGES)
def test_disk_full_job_killed_run_killed(finished, checkout, undisturbed, seen, stage):
    """One after the other at the same stage, without help in between."""
    product = f"results/small/{STAGES[stage]}"
    (checkout / product).unlink()
    for accident in ACCIDENTS:
        (checkout / "mark").unlink(missing_ok=True)
        failed = run(checkout, product, accident=accident)
        assert failed.process.returncode not in (0, None), failed.told
        assert failed.mark.exists() == accident.startswith("kill"), failed.told
        assert not (checkout / product).exists()
        left = {path: data for path, data in checkout.products().items() if ".partial" not in path}
        assert left.items() <= undisturbed.items()
        if accident == "full disk":
            assert "cannot be written" in failed.told
            assert "Traceback" not in failed.told
            assert not [path for path in checkout.products() if ".partial" in path]
    again = Run(checkout, product)
    again.wait_for(lambda: "waiting for the jobs it left at work" in again.told)
    failed.mark.unlink()  # the orphan goes on, renames its product and ends
    heals(checkout, undisturbed, finished, product, again)
    seen |= {(accident, stage): SAME for accident in ACCIDENTS}


def test_disk_is_really_full(finished, checkout, undisturbed, seen):
    """A file system of 64 kB, which is no file size limit: the record's job says so and leaves nothing."""
    (checkout / RECORD).unlink()
    space = "mount -t tmpfs -o size=64k none results/small/records"
    failed = run(checkout, RECORD, wrap=private(space, "echo left:; ls -A results/small/records"))
    assert failed.process.returncode == 1
    assert f"{RECORD}: cannot be written (" in failed.told
    assert "; free some space or allow writing to the folder" in failed.told
    assert failed.told.endswith("\nleft:\n")
    heals(checkout, undisturbed, finished, RECORD)
    seen["full file system", "record"] = SAME


def test_results_folder_is_read_only(finished, checkout, undisturbed, seen):
    (checkout / FIT).unlink()
    rights = "mount --bind results results && mount -o remount,bind,ro results"
    failed = run(checkout, FIT, wrap=private(rights))
    assert failed.process.returncode == 1
    assert "Read-only file system" in failed.told
    heals(checkout, undisturbed, finished, FIT)
    seen["read-only results", "fit"] = SAME


def test_raw_folder_is_read_only(finished, checkout, undisturbed, seen):
    (checkout / RECORD).unlink()
    rights = "mount --bind raw raw && mount -o remount,bind,ro raw"
    heals(checkout, undisturbed, finished, RECORD, run(checkout, RECORD, wrap=private(rights)))
    seen["read-only raw", "record"] = "none needed"


@pytest.mark.parametrize("stage", ["record", "fit"])
@pytest.mark.parametrize("damage", ["cut off", "bytes changed", UNSEEN])
def test_damaged_intermediate_file(finished, checkout, undisturbed, seen, stage, damage):
    """Made again; where the file system does not tell either, the step that reads it deletes it first."""
    path, reader = {"record": (RECORD, FIT), "fit": (FIT, "results/small/tables/runs.csv")}[stage]
    whole = (checkout / path).read_bytes()
    middle = len(whole) // 2
    noise = bytes(255 - byte for byte in whole[middle : middle + 2000])
    changed = whole[:middle] + (b"" if damage == "cut off" else noise + whole[middle + 2000 :])
    (checkout / path).write_bytes(changed)
    if damage == UNSEEN:
        told = {path: [sha256(finished / path), *look(checkout / path)]}
        (checkout / ".snakemake/freerock.looks.json").write_text(json.dumps(told))
        failed = run(checkout, reader, "--forcerun", reader)
        assert failed.process.returncode == 1, failed.told
        told = f"{path}: is not as it was written; it has been deleted: run the same command again"
        assert failed.told.splitlines().count(told) >= 1, failed.told
        assert "Traceback" not in failed.told
    heals(checkout, undisturbed, finished, reader)
    seen[f"product {damage}", stage] = "same command, twice" if damage == UNSEEN else SAME


def test_record_replaced_under_its_name(finished, checkout, undisturbed, seen):
    """Refused with both checksums, until the file is restored."""
    before = sha256(checkout / RAW)
    original = (checkout / RAW).read_bytes()
    write_tdms(checkout / RAW, simulated("squat", 9))
    assert run(checkout, RECORD).process.returncode == 0
    product = open_record(checkout / RECORD)
    found = (
        f"has the sha256 {sha256(checkout / RAW)}, raw/small/manifest.csv lists {before}; restore the file"
    )
    assert product.attrs["verdict"] == "fail"
    assert found in in_one_line(reasons_in(product.attrs))
    assert not product.children
    (checkout / RAW).write_bytes(original)
    heals(checkout, undisturbed, finished, RECORD)
    seen["record replaced", "record"] = "restore the file that is named, then the same command"
