"""The server of the desk: this computer only, and nothing without the token that its address holds.

Each answer is JSON or a file of this package or of Bokeh's; no page may load from, or send to, anywhere else.
"""

import asyncio
import json
import logging
import secrets
import socket
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from signal import SIGINT, SIGTERM
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

import tornado.httpserver
import tornado.netutil
import tornado.web

from freerock.errors import FreerockError
from freerock.review.desk import Desk

HOST = "127.0.0.1"
MOST_BYTES = 1_000_000  # of a request
HERE = Path(__file__).parent
OWN = {"review.js": "text/javascript", "charts.js": "text/javascript", "review.css": "text/css"}
BOKEH = {"bokeh.min.js": "text/javascript", "bokeh-api.min.js": "text/javascript"}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
LONG, SHORT = ("refit", "misfit"), ("keep", "undo", "look")  # methods of the desk that the page may call
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
        name = self.request.host.rpartition(":")[0]
        if not secrets.compare_digest(str(given).encode(), self.token.encode()) or name not in (
            HOST,
            "localhost",
        ):
            raise tornado.web.HTTPError(404)

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """Say no more than the number."""
        self.finish(str(status_code))

    async def answer(self, make: Callable[[], Any], long: bool = False) -> None:
        """Answer in JSON; a mistake is an answer as well, in a line."""
        pool = self.work.long if long else self.work.short
        try:
            made = await asyncio.get_running_loop().run_in_executor(pool, make)
        except FreerockError as error:
            self.set_status(409)
            made = {"error": str(error)}
        except Exception as error:
            from freerock.review.bench import Superseded

            superseded = isinstance(error, Superseded)
            self.set_status(410 if superseded else 500)
            made = {"error": "" if superseded else f"{type(error).__name__}: {error}"}
            if not superseded:
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
        self.finish((HERE if name in OWN else _bokeh()).joinpath(name).read_bytes())


class Ask(Page):
    """What the page requires; it changes nothing."""

    async def get(self, what: str) -> None:
        """A question by its name."""
        desk, test = self.desk, self.get_query_argument("test", "")
        run = self.get_query_argument("run", "")
        number = int(run) if run.isdigit() else None
        if what == "list":
            await self.answer(desk.listing)
        elif what == "again":
            await self.answer(desk.again)
        elif what == "styles":
            await self.answer(_styles)
        elif what == "record":
            await self.answer(lambda: desk.record(test, number))
            if self.get_status() == 200:
                self.work.long.submit(desk.ahead, test)
        elif what == "means":
            await self.answer(lambda: desk.means(test))
        elif what == "window":
            times = [float(self.get_query_argument(name)) for name in ("from", "to")]
            await self.answer(lambda: desk.window(test, times[0], times[1]))
        else:
            raise tornado.web.HTTPError(404)


class Do(Page):
    """What the page has done."""

    async def post(self, what: str) -> None:
        """A request by its name; JSON, so that no form of another page can send one."""
        if not self.request.headers.get("Content-Type", "").startswith("application/json"):
            raise tornado.web.HTTPError(415)
        if what not in LONG + SHORT:
            raise tornado.web.HTTPError(404)
        do = getattr(self.desk, what)
        try:
            given = json.loads(self.request.body)
            check_form(do, given)
        except (TypeError, ValueError) as error:
            raise tornado.web.HTTPError(400) from error
        if what == "refit":
            given["needed"] = self.work.needed()
        await self.answer(lambda: do(**given), long=what in LONG)


def check_form(do: Callable[..., Any], given: Any) -> None:
    """Raise TypeError where a request does not hold what a method of the desk takes, by its type hints."""
    hints = get_type_hints(do)
    taken = {name: hints[name] for name in signature(do).parameters if name != "needed"}
    if not isinstance(given, dict) or given.keys() != taken.keys():
        raise TypeError(f"takes {', '.join(taken)}")
    for name, hint in taken.items():
        if not any(_is_a(given[name], kind) for kind in _kinds(hint)):
            raise TypeError(name)


def _kinds(hint: Any) -> Sequence[Any]:
    return get_args(hint) if isinstance(hint, UnionType) else (hint,)


def _is_a(value: Any, kind: Any) -> bool:
    return isinstance(value, get_origin(kind) or kind) or (kind is float and isinstance(value, int))


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


def _styles() -> Any:
    from freerock.figures.looks import on_screen

    return on_screen()


def _bokeh() -> Path:
    """BokehJS as it comes with the Python package, which need not be imported for it."""
    found = find_spec("bokeh")
    if found is None or found.origin is None:
        raise ModuleNotFoundError("No module named 'bokeh'", name="bokeh")
    return Path(found.origin).parent / "server/static/js"
