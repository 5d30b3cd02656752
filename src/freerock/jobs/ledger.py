"""The ledger: what the products of a job were made from and by, and their checksums, in a file beside them.

The entry of a job is `ledger/NAME.json` in the folder of its campaign's results, NAME as of its log. It is
written last and travels with the products; what it does not bear out is made again, see
`freerock.jobs.whole_or_rerun`.
"""

import atexit
import gc
import json
import platform
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import requires, version
from pathlib import Path
from typing import Any

from freerock.errors import DamagedProduct, FreerockError
from freerock.files import read_json, sha256, write_text
from freerock.jobs import code_identity
from freerock.jobs.contents import checksum, is_look, look
from freerock.jobs.log import log_to
from freerock.jobs.newer_input import is_one

LEDGER_FOLDER = "ledger"
AGAIN = "run the same command again"
SELDOM = 100_000  # objects between two looks for garbage


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
    return Path(log).parents[1] / LEDGER_FOLDER / f"{Path(log).stem}.json"


def read_entry(path: str | Path) -> Entry | None:
    """The entry in a file of the ledger; None where there is none that can be understood."""
    try:
        entry = Entry(**read_json(path, AGAIN))
    except (FreerockError, TypeError):
        return None
    texts = (entry.inputs, entry.outputs, entry.software)
    sound = all(isinstance(each, dict) for each in (entry.settings, entry.looks, *texts))
    sound = sound and all(isinstance(word, str) for each in texts for word in each.values())
    return entry if sound and all(map(is_look, entry.looks.values())) else None


@contextmanager
def at_work(job: Any, *code: str) -> Iterator[None]:
    """Do the work of a job: messages go to its log, and at the end, without an error, its entry is written.

    A script imports inside it what takes long: to look for garbage among what libraries leave, while they are
    imported and when Python ends, would take a third of the time of the imports.

    Parameters
    ----------
    job : Snakemake
        What Snakemake gives to a script under the name `snakemake`.
    *code : str
        The script and the modules it imports by name, as `code_identity.code_checksum` takes them; left out,
        edits of the code go unseen.

    Raises
    ------
    DamagedProduct
        An input is a product and no longer as it was written.
    FreerockError
        An input was changed meanwhile, the code is not that of the plan, or the entry can't be written.
    """
    log_to(job.log[0])
    gc.set_threshold(SELDOM)
    atexit.register(gc.freeze)
    # Where each file looks as before the imports, by its change of status too, they were of the code checked.
    imported = {path: look(path) for path in code_identity.code(*code)} if code else {}
    if code and code_identity.code_checksum(*code) != job.params.get("code", ""):
        raise FreerockError(code[0], "its code was edited since the run began", AGAIN)
    made_from = {path: checksum(path) for path in map(str, job.input) if not is_one(path)}
    refuse_damaged({path: found for path, (found, _) in made_from.items()})
    yield
    for path, (found, seen) in made_from.items():
        if look(path) != seen if seen else sha256(path) != found:
            raise FreerockError(path, "was changed while it was being read", AGAIN)
    for path, seen in imported.items():
        if look(path) != seen:
            raise FreerockError(path, "was edited while the job was at work", AGAIN)
    made = {path: checksum(path) for path in map(str, job.output)}
    entry = Entry(
        as_json(dict(job.params.items())),
        {path: found for path, (found, _) in made_from.items()},
        {path: found for path, (found, _) in made.items()},
        software(),
        {path: [*seen] for path, (_, seen) in (made_from | made).items() if seen},
    )
    write_text(entry_path(job.log[0]), json.dumps(asdict(entry), ensure_ascii=False, indent=1) + "\n")


def refuse_damaged(read: Mapping[str, str]) -> None:
    """Refuse products that no job has written so.

    Parameters
    ----------
    read : mapping of str to str
        SHA-256 by path. Files that no ledger knows, as those of records, pass.

    Raises
    ------
    DamagedProduct
        The first of them.
    """
    folders = {above / LEDGER_FOLDER for path in read for above in Path(path).parents}
    written: dict[str, set[str]] = {}
    for entry in filter(None, (read_entry(path) for folder in folders for path in folder.glob("*.json"))):
        for path, found in entry.outputs.items():
            written.setdefault(path, set()).add(found)
    for path, found in read.items():
        if found not in written.get(path, {found}):
            raise DamagedProduct(path, "is not as it was written", "delete the file and run snakemake again")


def as_json(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as JSON gives them back: lists for tuples."""
    return dict(json.loads(json.dumps(settings)))


@cache
def software() -> dict[str, str]:
    """Versions of what computes: Python, the libraries that freerock requires, and the kind of machine."""
    names = (re.match(r"[\w.-]+", line) for line in requires("freerock") or () if "extra ==" not in line)
    libraries = {name[0]: version(name[0]) for name in names if name}
    return {"machine": platform.machine(), "python": platform.python_version()} | libraries
