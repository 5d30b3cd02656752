"""Damaged record files: each must be read or refused with the project's error, in little time and memory.

python -m freerock_bench.fuzz readers [files per reader] [kind …]
"""

import os
import resource
import shutil
import signal
import struct
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "unit"))
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # each thread reserves memory

MEMORY_BYTES = 1 << 30
SECONDS = 10  # of processor time, since other programs may be running
ASLEEP_SECONDS = 60
BATCH = 200  # files that a process reads, unless it dies
OUTCOMES = {0: "read", 1: "refused", 2: "a traceback", 3: "an error of several lines"}
OUTCOME = struct.Struct("Bd")  # outcome and time of a file


def readers(n: int, kinds: list[str]) -> int:
    """Try damaged files of each kind; return how many were neither read nor refused."""
    from records import KINDS, damaged_files

    from freerock.records.read import read_record

    if unknown := [kind for kind in kinds if kind not in KINDS]:
        sys.exit(f"{unknown[0]} is no kind of file: name some of {', '.join(KINDS)}")
    faults = 0
    for kind in kinds or KINDS:
        with tempfile.TemporaryDirectory() as folder:
            faults += tried(kind, damaged_files(kind, Path(folder), n, seed=1), n, read_record)
    return faults


def tried(kind: str, files: Iterator[Path], n: int, task: Callable[[Path], object]) -> int:
    """Print how many files a task took, refused, or anything else; return the number of these.

    Files that are neither are kept.
    """
    outcomes, slowest, done = Counter(), 0.0, 0
    while done < n:
        for outcome, seconds in _batch(files, min(BATCH, n - done), task):
            file = next(files)
            slowest = max(slowest, seconds)
            outcomes[outcome] += 1
            done += 1
            if outcome not in ("read", "refused"):
                kept = f"{tempfile.gettempdir()}/{kind.replace(' ', '_')}_{done}{file.suffix}"
                shutil.copy(file, kept)
                print(f"  {outcome}: {kept}")
    read, refused = outcomes.pop("read", 0), outcomes.pop("refused", 0)
    counts = f"{read:6d} read, {refused:6d} refused, {outcomes.total()} anything else"
    print(f"{kind:8s} {counts}; the slowest took {slowest:.2f} s", flush=True)
    return outcomes.total()


def _batch(files: Iterator[Path], n: int, task: Callable[[Path], object]) -> list[tuple[str, float]]:
    """Outcomes of the next files, taken by a process of its own; when it dies, of those up to the deadly one.

    The process goes on with its copy of the iterator, so the caller's stands where it stood.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        _limit()
        for file in islice(files, n):
            start = time.process_time()
            outcome = _outcome(task, file)
            os.write(writing, OUTCOME.pack(outcome, time.process_time() - start))
        os._exit(0)
    os.close(writing)
    with open(reading, "rb") as pipe:
        outcomes = [(OUTCOMES[outcome], seconds) for outcome, seconds in OUTCOME.iter_unpack(pipe.read())]
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        outcomes.append((signal.Signals(os.WTERMSIG(status)).name, 0.0))
    return outcomes


def _limit() -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


def _outcome(task: Callable[[Path], object], file: Path) -> int:
    from freerock.errors import FreerockError

    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    signal.alarm(ASLEEP_SECONDS)
    try:
        task(file)
    except FreerockError as error:
        return 3 if any("\n" in str(each) for each in getattr(error, "problems", [error])) else 1
    except BaseException:
        return 2
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
    return 0


def _import_readers() -> None:
    """Import every reader, lest each child does."""
    from importlib import import_module

    from records import walked_by_a_fork

    from freerock.records.read import READERS

    for name in {*READERS.values()}:
        import_module(f"freerock.records.{name}")
    import_module("freerock.records.hdf5").walked = walked_by_a_fork


if __name__ == "__main__":
    part, *rest = sys.argv[1:] or ["readers"]
    if part != "readers":
        sys.exit(__doc__)
    _import_readers()
    sys.exit(readers(int(rest[0]) if rest else 10_000, rest[1:]) > 0)
