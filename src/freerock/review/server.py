"""The server of the desk: this computer only, and nothing without the token that its address holds.

Each answer is JSON or a file of this package or of Bokeh's; no page may load from, or send to, anywhere else.
"""

import asyncio
import json
import logging
import secrets
import socket
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from signal import SIGINT, SIGTERM
from typing import Any

import tornado.httpserver
import tornado.netutil
import tornado.web

from freerock.errors import FreerockError
from freerock.figures.looks import on_screen, scripts_folder
from freerock.review.desk import Desk
from freerock.review.reprocessing import Superseded
from freerock.review.requests import DONE, REQUESTS, checked, read_request

HOST = "127.0.0.1"
MOST_BYTES = 1_000_000  # of a request
HERE = Path(__file__).parent
OWN = {"review.js": "text/javascript", "charts.js": "text/javascript", "review.css": "text/css"}
BOKEH = {"bokeh.min.js": "text/javascript", "bokeh-api.min.js": "text/javascript"}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}

log = logging.getLogger("freerock")


class Work:
    """One thread for what takes long and one for what the page waits for; of two refits the newer counts."""

    def __init__(self) -> None:
        self.long, self.short = (ThreadPoolExecutor(1, name) for name in ("refit", "look"))
        self.newest = 0

    def needed(self) -> Callable[[], bool]:
        """Says whether nothing newer has been requested since."""
        self.newest += 1
        mine = self.newest
        return lambda: mine == self.newest


class Page(tornado.web.RequestHandler):
    """What all answers share."""

    def initialize(self, desk: Desk, work: Work, token: str) -> None:
        """Take what the server holds."""
        self.desk, self.work, self.token = desk, work, token

    def set_default_headers(self) -> None:
        """Nothing leaves this computer."""
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def prepare(self) -> None:
        """Refuse what comes without the token, or under another name of this computer."""
        given = self.path_kwargs.pop("token", "")
        known = self.request.host.rpartition(":")[0] in (HOST, "localhost")
        if not secrets.compare_digest(str(given).encode(), self.token.encode()) or not known:
            raise tornado.web.HTTPError(404)

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """Say no more than the number."""
        self.finish(str(status_code))

    def taken(self, check: Callable[[], dict[str, Any]]) -> dict[str, Any] | None:
        """What a request holds; None where it is refused and so answered, in a line with the field."""
        try:
            return check()
        except FreerockError as error:
            self.set_status(400)
            self.finish({"error": str(error)})
            return None

    async def answer(self, make: Callable[[], Any], long: bool = False) -> None:
        """Answer in JSON; a mistake is an answer as well, in a line."""
        pool = self.work.long if long else self.work.short
        try:
            made = await asyncio.get_running_loop().run_in_executor(pool, make)
        except FreerockError as error:
            self.set_status(409)
            made = {"error": str(error)}
        except Superseded:
            self.set_status(410)
            made = {"error": ""}
        except Exception as error:
            self.set_status(500)
            made = {"error": f"{type(error).__name__}: {error}"}
            log.exception("freerock review: %s", self.request.path)
        self.set_header("Content-Type", "application/json")
        self.finish(json.dumps(made, ensure_ascii=False, allow_nan=False))


class Opening(Page):
    """Leads the browser that freerock opens to the page, once: others see its command line, token and all."""

    def prepare(self) -> None:
        """Anybody may ask."""

    def get(self, once: str) -> None:
        """The way to the page, for who comes first with the right word."""
        known = self.settings.pop("once", "")
        if not known or not secrets.compare_digest(once.encode(), known.encode()):
            raise tornado.web.HTTPError(404)
        self.redirect(f"/{self.token}/")


class File(Page):
    """The page, its script and its looks, and BokehJS."""

    def get(self, name: str = "") -> None:
        """A file."""
        if not name:
            self.set_header("Content-Type", "text/html; charset=utf-8")
            self.finish((HERE / "review.html").read_bytes())
            return
        kinds = OWN | BOKEH
        if name not in kinds:
            raise tornado.web.HTTPError(404)
        self.set_header("Content-Type", f"{kinds[name]}; charset=utf-8")
        if name in BOKEH:
            self.set_header("Cache-Control", "private, max-age=86400")
        self.finish((HERE if name in OWN else scripts_folder()).joinpath(name).read_bytes())


class Ask(Page):
    """What the page requires; it changes nothing."""

    async def get(self, what: str) -> None:
        """A question by its name."""
        if what not in REQUESTS:
            raise tornado.web.HTTPError(404)
        given = {name: self.get_query_argument(name) for name in self.request.arguments}
        if (asked := self.taken(lambda: checked(REQUESTS[what], given))) is None:
            return
        ways: dict[str, Callable[..., Any]] = {"list": self.desk.listing, "styles": on_screen}
        await self.answer(partial(ways.get(what) or getattr(self.desk, what), **asked))
        if what == "record" and self.get_status() == 200:
            self.work.long.submit(self.desk.ahead, asked["test"])


class Do(Page):
    """What the page has done."""

    async def post(self, what: str) -> None:
        """A request by its name; JSON, so that no form of another page can send one."""
        if not self.request.headers.get("Content-Type", "").startswith("application/json"):
            raise tornado.web.HTTPError(415)
        if what not in DONE:
            raise tornado.web.HTTPError(404)
        if (given := self.taken(lambda: read_request(DONE[what], self.request.body))) is None:
            return
        if what == "refit":
            given["needed"] = self.work.needed()
        await self.answer(partial(getattr(self.desk, what), **given), long=what == "refit")


def application(desk: Desk, token: str, once: str = "") -> tornado.web.Application:
    """The server's addresses, all of them below the token; `once` leads there a single time."""
    shared = {"desk": desk, "work": Work(), "token": token}
    name = r"/(?P<token>[\w-]+)"
    return tornado.web.Application(
        [
            (r"/open/(?P<once>[\w-]+)", Opening, shared),
            (rf"{name}/(?P<name>[\w.-]*)", File, shared),
            (rf"{name}/ask/(?P<what>\w+)", Ask, shared),
            (rf"{name}/do/(?P<what>\w+)", Do, shared),
        ],
        default_handler_class=Page,
        default_handler_args=shared,
        log_function=lambda handler: None,
        once=once,
    )


def serve(desk: Desk, port: int, ready: Callable[[str, str], None]) -> None:
    """Serve the desk until the process is stopped.

    Parameters
    ----------
    desk : Desk
    port : int
        0 for any that is free.
    ready : callable
        Told the address once it answers, and another that leads there a single time.

    Raises
    ------
    FreerockError
        The port is taken.
    """
    try:
        (listening,) = tornado.netutil.bind_sockets(port, HOST, socket.AF_INET)
    except OSError as error:
        remedy = "name another by --port, or none"
        raise FreerockError(f"port {port}", str(error.strerror), remedy) from error
    asyncio.run(_serve(desk, listening, ready))


async def _serve(desk: Desk, listening: socket.socket, ready: Callable[[str, str], None]) -> None:
    token, once = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
    served = application(desk, token, once)
    server = tornado.httpserver.HTTPServer(served, max_buffer_size=MOST_BYTES)
    server.add_socket(listening)
    root = f"http://{HOST}:{listening.getsockname()[1]}"
    ready(f"{root}/{token}/", f"{root}/open/{once}")
    stopped = asyncio.Event()
    for signal in (SIGINT, SIGTERM):  # also where a shell has it run in the background, deaf to Ctrl+C
        asyncio.get_running_loop().add_signal_handler(signal, stopped.set)
    await stopped.wait()
