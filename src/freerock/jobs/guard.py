"""What a run may find: leavings and jobs of a killed run, another run, no room, a wrong clock, no folder."""

import errno
import fcntl
import os
import sys
import tempfile
import threading
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from freerock.errors import FreerockError
from freerock.files import PARTIAL
from freerock.jobs.contents import look

ROOM = "free some space, give yourself the right to write there, or use --directory"
NOTES_BYTES = 1 << 16  # of Snakemake's locks and notes, of whose lack it says nothing in a line
RUNS, JOBS = Path("results/.runs"), Path("results/.jobs")


def run_starts() -> None:
    """Clear away the locks and half files that a killed run has left, after the last of its jobs has ended.

    Runs and jobs hold locks of the operating system, which end with their process. Where another run is
    alive, or the file system knows no such locks, nothing is taken away and Snakemake refuses to start.
    """
    with suppress(OSError):
        RUNS.parent.mkdir(exist_ok=True)
        runs = _opened(RUNS)
        with suppress(BlockingIOError):  # another run is alive
            fcntl.flock(runs, fcntl.LOCK_EX | fcntl.LOCK_NB)
            jobs = _opened(JOBS)
            try:
                fcntl.flock(jobs, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                print("A run was killed; waiting for the jobs it left at work.", file=sys.stderr)
                fcntl.flock(jobs, fcntl.LOCK_EX)
            os.close(jobs)
            for left in (*Path(".snakemake/locks").glob("*.lock"), *RUNS.parent.rglob(PARTIAL)):
                left.unlink()
        fcntl.flock(runs, fcntl.LOCK_SH)  # until this process ends
    job_runs()


def job_runs() -> None:
    """Let a later run see that this process and all that it starts are at work, until the last of them ends.

    The lock is their standard input, which a process has from its first moment, long before its imports;
    no other file is handed on to the jobs that Snakemake starts.
    """
    with suppress(OSError):  # not below Snakemake
        jobs = _opened(JOBS)
        fcntl.flock(jobs, fcntl.LOCK_SH)
        os.dup2(jobs, 0)
        os.close(jobs)


def hold(folder: Path) -> None:
    """Keep other runs from a campaign's folder of products until this process ends.

    Raises
    ------
    FreerockError
        Another run is at work on it.
    """
    with suppress(OSError):  # no right to write, of which check_room tells, or no such locks
        folder.mkdir(parents=True, exist_ok=True)
        try:
            fcntl.flock(_opened(folder / ".lock"), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FreerockError(folder, "another run is at work on it", "wait until it has ended") from None


def _opened(path: Path) -> int:
    return os.open(path, os.O_CREAT | os.O_RDWR, 0o666)


def check_folder(folder: Path, writable: bool = False) -> None:
    """Refuse a file in the place of a folder, or a folder without the right to write; only looks.

    Raises
    ------
    FreerockError
        It is there and no folder, or read-only where it must be writable.
    """
    if folder.exists() and not folder.is_dir():
        raise FreerockError(folder, f"can't be written ({os.strerror(errno.ENOTDIR)})", ROOM)
    if writable and folder.exists() and not os.access(folder, os.W_OK):
        raise FreerockError(folder, "can't be written", ROOM)


def check_room(folder: Path, n_bytes: int = 0) -> None:
    """Refuse a folder that can't be written, or the nearest above it that exists.

    Tried with a file in it and in the folders directly below: what rights say does not hold for everyone.

    Raises
    ------
    FreerockError
        No file of so many bytes can be made in one of them.
    """
    above = next(each for each in (folder, *folder.parents) if each.exists())
    for where in [above, *(each for each in folder.glob("*") if each.is_dir())]:
        try:
            with tempfile.TemporaryFile(dir=where) as file:
                file.write(bytes(n_bytes))
                file.flush()
        except OSError as error:
            raise FreerockError(where, f"can't be written ({error.strerror})", ROOM) from None


def check_clock(products: Iterable[Path], inputs: Iterable[Path], tolerance_s: float = 5.0) -> None:
    """Set the times of products from the future to now; refuse inputs from there, and what is no file.

    To Snakemake a product that is older than an input is outdated, and the job that made it has failed.

    Raises
    ------
    FreerockError
        An input's time lies in the future; a FIFO, a socket or a device is among the products.
    """
    now = time.time()
    for path in inputs:
        if path.exists() and path.stat().st_mtime > now + tolerance_s:
            when = time.strftime("%Y-%m-%d %H:%M", time.localtime(path.stat().st_mtime))
            what = f"was last written on {when}, in the future of this machine's clock"
            raise FreerockError(path, what, "set the clock right, or touch the file")
    with suppress(OSError):  # read-only: Snakemake will say so where it wants to write
        for path in products:
            if (seen := look(path)) and seen[1] > (now + tolerance_s) * 1e9:
                os.utime(path, (now, now))


def watch_folder(every_s: float = 1.0, misses: int = 3) -> None:
    """End this process, in a line, when its working folder has been deleted or renamed.

    Snakemake would go on without its notes, or wait for a job for ever.
    """
    here = os.getcwd()

    def look() -> None:
        missed = 0
        while missed < misses:
            time.sleep(every_s)
            try:
                os.stat(here)
                missed = 0
            except FileNotFoundError:
                missed += 1
            except OSError:  # a share that does not answer
                continue
        told = f"{here}: is no longer there; put it back, then run the same command"
        print(told, file=sys.stderr, flush=True)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()
