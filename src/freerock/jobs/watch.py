"""Whether the folder of a run is still there."""

import os
import sys
import threading
import time


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
