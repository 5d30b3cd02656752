"""Whether a run can go on: room for Snakemake's notes, and its folder still there."""

import os
import sys
import tempfile
import threading
import time
from pathlib import Path

from freerock.errors import FreerockError

NOTES_BYTES = 1 << 16  # of locks and notes, at least


def check_space(notes: Path = Path(".snakemake")) -> None:
    """Refuse to start without room for Snakemake's notes, of whose lack it says nothing in a line.

    Raises
    ------
    FreerockError
        They can't be written.
    """
    try:
        notes.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=notes) as file:
            file.write(bytes(NOTES_BYTES))
            file.flush()
    except OSError as error:
        remedy = "free some space, or give yourself the right to write there"
        raise FreerockError(notes, f"can't be written ({error.strerror})", remedy) from None


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
        print(
            f"{here}: is no longer there; put it back, then run the same command", file=sys.stderr, flush=True
        )
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()
