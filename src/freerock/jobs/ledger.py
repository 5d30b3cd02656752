"""The ledger: what the products of a job were made from and by, and their checksums, in a file beside them.

The entry of a job is `ledger/NAME.json` in the folder of its campaign's results, NAME as of its log. It is
written last and travels with the products; what it does not bear out is made again, see
`freerock.jobs.soundness`.
"""

import json
import os
import platform
import re
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import requires, version
from pathlib import Path
from typing import Any

from freerock.errors import FreerockError
from freerock.files import sha256, write_text
from freerock.jobs.log import log_to

FOLDER = "ledger"
Look = tuple[int, int, int, int]  # size, times of content and of status [ns], inode
TICK_NS, COARSE_TICK_NS = 20_000_000, 2_000_000_000  # of a file system's clock, and of one in whole seconds


@dataclass(frozen=True)
class Entry:
    """What the ledger holds of a job.

    Parameters
    ----------
    settings : dict
        Parameters of the rule, as JSON gives them back; `code`, the checksum of the code, is one of them.
    inputs, outputs : dict of str to str
        SHA-256 by path, in the order of the rule.
    software : dict of str to str
        Version by name.
    looks : dict of str to list of int
        How each of the files looked when its checksum was taken.
    """

    settings: dict[str, Any]
    inputs: dict[str, str]
    outputs: dict[str, str]
    software: dict[str, str]
    looks: dict[str, list[int]] = field(default_factory=dict)


def entry_path(log: str | Path) -> Path:
    """The ledger's file of the job that has this log."""
    return Path(log).parents[1] / FOLDER / f"{Path(log).stem}.json"


def read_entry(path: str | Path) -> Entry | None:
    """The entry in a file of the ledger; None where there is none that can be understood."""
    try:
        entry = Entry(**json.loads(Path(path).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, RecursionError):
        return None
    texts = (entry.inputs, entry.outputs, entry.software)
    sound = all(isinstance(each, dict) for each in (entry.settings, entry.looks, *texts))
    sound = sound and all(isinstance(word, str) for each in texts for word in each.values())
    return entry if sound and all(map(is_look, entry.looks.values())) else None


def is_look(seen: Any) -> bool:
    """Whether a value read from JSON is the look of a file."""
    return isinstance(seen, list) and len(seen) == 4 and all(isinstance(each, int) for each in seen)


@contextmanager
def at_work(job: Any) -> Iterator[None]:
    """Do the work of a job: messages go to its log, and at the end, without an error, its entry is written.

    Parameters
    ----------
    job : Snakemake
        What Snakemake gives to a script under the name `snakemake`.

    Raises
    ------
    FreerockError
        An input was changed meanwhile, or the entry can't be written.
    """
    log_to(job.log[0])
    before = {path: look(path) for path in job.input}
    yield
    made_from, made = (
        {path: checksum(path) for path in map(str, files)} for files in (job.input, job.output)
    )
    for path, earlier in before.items():
        if look(path) != earlier:
            raise FreerockError(path, "was changed while it was being read", "run the same command again")
    entry = Entry(
        plain(dict(job.params.items())),
        {path: found for path, (found, _) in made_from.items()},
        {path: found for path, (found, _) in made.items()},
        software(),
        {path: [*seen] for path, (_, seen) in (made_from | made).items() if seen},
    )
    write_text(entry_path(job.log[0]), json.dumps(asdict(entry), ensure_ascii=False, indent=1) + "\n")


def plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as JSON gives them back: lists for tuples."""
    return dict(json.loads(json.dumps(settings)))


def checksum(path: str | Path) -> tuple[str, Look | None]:
    """SHA-256 of a file, and how it looked where a later change is sure to show.

    Raises
    ------
    FreerockError
        It can't be read.
    """
    now_ns, before = time.time_ns(), look(path)
    found = sha256(path)
    return found, before if before and before == look(path) and settled(before, now_ns) else None


def look(path: str | Path) -> Look | None:
    """How a file looks without being read: what changes its content changes this. None without a file."""
    try:
        seen = os.stat(path)
    except OSError:
        return None
    return seen.st_size, seen.st_mtime_ns, seen.st_ctime_ns, seen.st_ino


def settled(seen: Look, now_ns: int) -> bool:
    """Whether a file that is changed from now on gets another time: its last change is not of this moment."""
    changed_ns = max(seen[1], seen[2])
    return now_ns - changed_ns > (COARSE_TICK_NS if changed_ns % 1_000_000_000 == 0 else TICK_NS)


@cache
def software() -> dict[str, str]:
    """Versions of what computes: Python, the libraries that freerock requires, and the kind of machine."""
    names = (re.match(r"[\w.-]+", line) for line in requires("freerock") or () if "extra ==" not in line)
    libraries = {name[0]: version(name[0]) for name in names if name}
    return {"machine": platform.machine(), "python": platform.python_version()} | libraries
