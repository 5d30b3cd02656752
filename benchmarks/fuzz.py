"""Damaged record files: each must be read or refused with the project's error, in little time and memory.

python benchmarks/fuzz.py readers [files per reader] [kind …]
"""

import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "unit"))
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # each thread reserves address space

MEMORY_BYTES = 1 << 30
SECONDS = 5
OUTCOMES = {0: "read", 1: "refused"}


def readers(n: int, kinds: list[str]) -> int:
    """Print how many damaged files of each kind were read, refused, or anything else; return the latter."""
    from records import KINDS, damaged_files

    faults = 0
    for kind in kinds or KINDS:
        with tempfile.TemporaryDirectory() as folder:
            outcomes, slowest = Counter(), 0.0
            for i, path in enumerate(damaged_files(kind, Path(folder), n, seed=1)):
                start = time.monotonic()
                outcome = _outcome(path)
                slowest = max(slowest, time.monotonic() - start)
                outcomes[outcome] += 1
                if outcome not in OUTCOMES.values():
                    kept = Path(tempfile.gettempdir(), f"{kind.replace(' ', '_')}_{i}{path.suffix}")
                    shutil.copy(path, kept)
                    print(f"  {outcome}: {kept}")
            read, refused = (outcomes.pop(name, 0) for name in OUTCOMES.values())
            faults += outcomes.total()
            told = f"{read:6d} read, {refused:6d} refused, {outcomes.total()} anything else"
            print(f"{kind:8s} {told}; the slowest took {slowest:.2f} s", flush=True)
    return faults


def _outcome(path: Path) -> str:
    """Read a file in a process of its own, under limits of memory and time."""
    child = os.fork()
    if not child:
        os._exit(_read(path))
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return signal.Signals(os.WTERMSIG(status)).name
    return OUTCOMES.get(os.WEXITSTATUS(status), f"error {os.WEXITSTATUS(status)}")


def _read(path: Path) -> int:
    from freerock.acquisition import read_record
    from freerock.errors import FreerockError

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.alarm(SECONDS)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    try:
        read_record(path)
    except FreerockError as error:
        return 1 if "\n" not in str(error) else 3
    except BaseException:
        return 2
    return 0


def _import_readers() -> None:
    """Import every reader, lest each child does."""
    from importlib import import_module

    from freerock.acquisition import READERS

    for name in {*READERS.values()}:
        import_module(f"freerock.acquisition.{name}")


if __name__ == "__main__":
    part, *rest = sys.argv[1:] or ["readers"]
    if part != "readers":
        sys.exit(__doc__)
    _import_readers()
    sys.exit(readers(int(rest[0]) if rest else 10_000, rest[1:]) > 0)
