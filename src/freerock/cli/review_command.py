"""See, correct and refit the runs of a campaign in the browser.

example:
  freerock review palermo_virtual

The page is served to this computer only, at an address with a secret token. Saved corrections go
into the campaign's CSV; run snakemake afterwards. Ctrl+C ends it.
"""

import os
import webbrowser
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable
from contextlib import suppress
from threading import Thread


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN")
    add("--no-browser", action="store_true", help="print the address without opening a browser")
    add("--port", type=_port, default=0, help="by default any free port")


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 5 and int(text) <= 65535):
        raise ArgumentTypeError(f"{text[:20]!r} is no port, from 0 to 65535")
    return int(text)


def run(chosen: Namespace) -> None:
    """Serve the desk until Ctrl+C."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # as the workflow: the same last digits
    from freerock.review.desk import Desk
    from freerock.review.server import serve

    def ready(address: str, once: str) -> None:
        print(f"{chosen.campaign}: {address}\nCtrl+C ends it.", flush=True)
        if not chosen.no_browser:
            Thread(target=webbrowser.open, args=(once,), daemon=True).start()

    with suppress(KeyboardInterrupt):
        serve(Desk(chosen.campaign), chosen.port, ready)
