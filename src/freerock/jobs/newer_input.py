"""How Snakemake repeats a job that the ledger does not confirm: an input newer than its products.

The input is an empty file in a temporary folder, which ends with the process. A plan changes nothing in the
working folder, and what Snakemake has noted does not matter, nor whether the product is a target.
"""

import atexit
import os
import time
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from freerock.errors import FreerockError

PREFIX = "freerock_again_"
A_MOMENT_NS = 1_000_000  # more than the rounding of a time in seconds


def newer_than(products: Iterable[str], job: str) -> str:
    """A new file that is a moment newer than the newest product there is, older than any made from now on.

    Parameters
    ----------
    products : iterable of str
        Paths; products of the future have been set to now.
    job : str
        Its name, which becomes that of the file.

    Raises
    ------
    FreerockError
        There is no room for it.
    """
    times = [os.stat(path).st_mtime_ns for path in products if os.path.exists(path)]
    try:
        path = Path(mkdtemp(prefix=PREFIX, dir=_folder()), job)  # Snakemake looks into a folder once
        path.touch()
        when = max(times, default=time.time_ns()) + (A_MOMENT_NS if times else 0)
        os.utime(path, ns=(when, when))
    except OSError as error:
        remedy = "free some space there, or name another folder in TMPDIR"
        raise FreerockError("the folder of temporary files", str(error.strerror or error), remedy) from None
    return str(path)


def is_one(path: str) -> bool:
    """Whether a path is that of such a file, which holds nothing and is made from nothing."""
    return Path(path).parent.name.startswith(PREFIX)


@cache
def _folder() -> str:
    folder = TemporaryDirectory(prefix=PREFIX)
    atexit.register(folder.cleanup)
    return folder.name
