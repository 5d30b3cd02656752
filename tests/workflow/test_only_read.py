"""Reading the workflow changes nothing on disk: before a first run, after a finished or a killed one."""

import os
import shutil
import time

import pytest
from small_campaign import Checkout

READ = [
    ["--dry-run"],
    ["--dry-run", "results/small/fits/squat_mat.nc"],
    ["--lint"],
    ["--dag"],
    ["--summary"],
]


# Of Python, and of Snakemake whatever it is asked: its log of the command, and what a dry run looked up.
NOT_OURS = {"__pycache__", ".snakemake/log", ".snakemake/iocache"}


def listing(folder):
    """Size, time and inode of every file."""
    left_out = [path for name in NOT_OURS for path in folder.rglob(name)]
    found = (path for path in folder.rglob("*") if path.is_file() and not {*left_out} & {*path.parents})
    return {
        path.relative_to(folder).as_posix(): (stat.st_size, stat.st_mtime_ns, stat.st_ino)
        for path, stat in ((path, path.stat()) for path in found)
    }


def killed(checkout):
    """A run was killed: locks, a product half made, one not made, and the clock was set back meanwhile."""
    (checkout / "results/small/fits/squat_mat.nc").unlink()
    (checkout / "results/small/fits/.squat_mat.partial.nc").write_bytes(b"half")
    (checkout / ".snakemake/locks").mkdir(exist_ok=True)
    for kind in ("input", "output"):
        (checkout / f".snakemake/locks/0.{kind}.lock").write_text("results/small/fits/squat_mat.nc\n")
    tomorrow = time.time() + 86400
    for path in (checkout / "results").rglob("*.*"):
        os.utime(path, (tomorrow, tomorrow))


def clean(checkout):
    """Nothing was run yet."""
    shutil.rmtree(checkout / "results")
    shutil.rmtree(checkout / ".snakemake")


@pytest.mark.parametrize("state", [killed, clean, lambda checkout: None], ids=["killed", "clean", "finished"])
def test_reading_changes_no_file(checkout, state):
    state(checkout)
    before = listing(checkout.folder)
    assert "Snakefile" in before
    for arguments in READ:
        done = checkout.snakemake(*arguments)
        assert "Traceback" not in done.stderr
        assert done.returncode == 0, done.stdout + done.stderr
        assert listing(checkout.folder) == before, arguments
    assert (checkout / ".snakemake/locks/0.input.lock").exists() == (state is killed)


def test_the_same_command_then_finishes(checkout: Checkout):
    killed(checkout)
    assert checkout.snakemake("--dry-run").returncode == 0
    done = checkout.snakemake("results/small/fits/squat_mat.nc")
    assert done.returncode == 0, done.stderr
    assert not list((checkout / ".snakemake").glob("locks/*"))
