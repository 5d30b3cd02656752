"""The desk under generated requests: wrong types and sizes, two desks, kills and full disks at each write.

python -m freerock_bench.desk [requests] --seed N

Two desks serve one campaign, each in a process of its own. Before a request one of them may be set to be
killed, or to find the disk full, at one of its next writes. After each request the campaign is opened as a
new desk does, and its two files are compared with the answer. What must not be is printed; exit code 1.
"""

import argparse
import asyncio
import http.client
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
from collections import Counter
from contextlib import closing, suppress
from errno import ENOSPC
from multiprocessing.sharedctypes import RawArray
from pathlib import Path
from typing import Any

from freerock.config.review_log import LOOKED_AT, log_of
from freerock.review import server
from freerock.review.corrections import COLUMNS
from freerock.review.csv_edit import digest, parsed
from freerock.review.desk import Desk

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "workflow"))

NAME, TESTS, TOKEN = "small", ("tall", "lost"), "token"
FAULTS = ("none", "kill", "full", "short")  # short: no file may grow beyond so many bytes
WRITES = {"open", "os.rename", "os.remove", "os.chmod"}
TOLD_EVERY = 200  # requests
MOST_WRITES, TIMEOUT_S = 12, 30
WORDS = ["wet base", 'a 5" block', "knocked, seen", "# no comment", "βeta", "x" * 1999, "\u2028 line"]
WORDS += ["a\tb", ""]
VALUES: list[Any] = [None, True, 0, -1, 1.9, 1e300, "", "12", "²", [], [True], {}, {"a": 1}, "x" * 131_073]
BODIES = [b"", b"{", b"[" * 50_000, b"\xff\xfe", b"NaN", b'{"a": 1e400}', b"null", b'"text"']
BODIES += [b"x" * 1_100_000]
PATHS = ["ask/record?test=tall&run=%C2%B2", "ask/record?run=1", "ask/window?test=tall&from_s=nan&to_s=1"]
PATHS += ["ask/list?x=1", "ask/means?test=none", "ask/nothing", "do/undo", "ask/again", "ask/list"]


class Fault:
    """What happens to a desk at one of its writes; in memory that its process shares with this one."""

    def __init__(self) -> None:
        self._shared = RawArray("i", 2)

    def set(self, kind: str, at: int) -> None:
        """Choose a kind of `FAULTS` and the write at which it happens, or the bytes a file may have."""
        self._shared[:] = FAULTS.index(kind), at

    def strike(self, event: str, arguments: tuple[Any, ...] = ()) -> None:
        """Happen, if this is the write; a hook of Python's audit."""
        number, left = self._shared
        kind = FAULTS[number]
        if kind == "none" or event not in WRITES or (event == "open" and not _writes(*arguments)):
            return
        if kind == "short":
            resource.setrlimit(resource.RLIMIT_FSIZE, (left, resource.RLIM_INFINITY))
            return
        self.set(kind if left > 1 else "none", left - 1)
        if left == 1 and kind == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if left == 1:
            raise OSError(ENOSPC, os.strerror(ENOSPC))


def _writes(path: Any, mode: Any, flags: Any) -> bool:
    return bool(flags & (os.O_WRONLY | os.O_RDWR)) and "small" in str(path)


class Served:
    """A desk in a process of its own, and what its page knows."""

    def __init__(self) -> None:
        self.fault, self.known = Fault(), ""
        self.begin()

    def begin(self) -> None:
        """Open the desk, as `freerock review` does."""
        self.fault.set("none", 0)
        reading, writing = os.pipe()
        self.process = os.fork()
        if not self.process:
            with suppress(BaseException):
                self._serve(writing)
            os._exit(1)
        os.close(writing)
        with open(reading, "rb") as pipe:
            self.port = int(pipe.readline() or 0)

    def _serve(self, writing: int) -> None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        synchronise = os.fsync

        def fsync(file: int) -> None:
            self.fault.strike("os.rename")
            synchronise(file)

        os.fsync = fsync
        desk = Desk(NAME)
        sys.addaudithook(self.fault.strike)
        server.secrets.token_urlsafe = lambda _: TOKEN
        (listening,) = server.tornado.netutil.bind_sockets(0, server.HOST, server.socket.AF_INET)
        asyncio.run(
            server._serve(
                desk, listening, lambda *_: os.write(writing, f"{listening.getsockname()[1]}\n".encode())
            )
        )

    def ask(self, path: str, body: bytes | None = None) -> tuple[int, dict[str, Any]]:
        """Status and answer of a request; 0 where the desk was killed or the request cut off."""
        line = http.client.HTTPConnection(server.HOST, self.port, timeout=TIMEOUT_S)
        try:
            headers = {"Content-Type": "application/json"}
            line.request("GET" if body is None else "POST", f"/{TOKEN}/{path}", body, headers)
            reply = line.getresponse()
            told = reply.read()
        except (http.client.HTTPException, ConnectionError):
            return 0, {}
        finally:
            line.close()
            self.fault.set("none", 0)
        with suppress(ValueError):
            answer = json.loads(told)
            return reply.status, answer if isinstance(answer, dict) else {}
        return reply.status, {}

    def revive(self) -> bool:
        """Open it again where it was killed or has met a limit; returns whether it was."""
        done, _ = os.waitpid(self.process, os.WNOHANG)
        if done:
            self.begin()
        return bool(done)

    def close(self) -> None:
        """End its process."""
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)


def write_campaign(folder: Path) -> None:
    """A campaign whose records are not there, which the desk need not read to keep corrections."""
    from small_campaign import CAMPAIGN, Checkout, add_campaign

    (folder / "config/campaigns").mkdir(parents=True)
    (folder / "raw/small").mkdir(parents=True)
    yaml, blocks = CAMPAIGN.replace("truth: truth.json\n", ""), ("tall", "squat")
    records = [(test, "", block) for test, block in zip(TESTS, blocks, strict=True)]
    add_campaign(Checkout(folder), NAME, yaml, records)


def correction(chance: random.Random) -> dict[str, Any]:
    """A correction that may be kept, or refused for want of a reason."""
    start = round(chance.uniform(0, 90), 3)
    override = {"run": chance.randint(1, 9), "release_s": start, "end_s": start + 5, "hold_s": None}
    return {
        "overrides": [override] * chance.randint(0, 1),
        "exclude": chance.choice(["record", [], [1], [2, 3]]),
        "stretches": chance.choice([[], [[start, start]], [[start, start + 0.1], [start + 1, start + 2]]]),
        "reason": chance.choice(WORDS),
        "note": chance.choice(WORDS),
    }


def request(chance: random.Random, known: str) -> tuple[str, bytes | None]:
    """Path and body of a request: most in order, others with a value, a key or a body of another form."""
    test = chance.choice((*TESTS, *TESTS, "none"))
    one, both = {test: correction(chance)}, dict.fromkeys(TESTS, correction(chance))
    orders = [("keep", {"corrections": one, "known": known, "why": chance.choice(WORDS)})]
    orders += [("keep", {"corrections": both, "known": known, "why": "both"}), ("undo", {})]
    orders += [("look", {"test": test, "run": chance.randint(1, 9), "seen": chance.random() < 0.7})]
    (do, given), kind = chance.choice(orders), chance.random()
    if kind < 0.6:
        return f"do/{do}", json.dumps(given).encode()
    if kind < 0.8:
        _spoil(given, chance)
        do = chance.choice([do, do, "refit"])
        return f"do/{do}", json.dumps(given).encode()
    if kind < 0.9:
        return f"do/{do}", chance.choice(BODIES)
    return chance.choice(PATHS), None


def _longest() -> int:
    """Bytes of the larger of the two files."""
    return max(each.stat().st_size for each in Path("config/campaigns").glob("*.csv"))


def _spoil(given: Any, chance: random.Random) -> None:
    """Put another value, or another key, somewhere into a request."""
    key: Any = (
        chance.choice([*given] if isinstance(given, dict) else [*range(len(given))]) if given else "more"
    )
    inner = given.get(key) if isinstance(given, dict) else given[key]
    if isinstance(inner, dict | list) and inner and chance.random() < 0.8:
        _spoil(inner, chance)
    elif isinstance(given, dict) and chance.random() < 0.2:
        given[chance.choice(["more", "", "x" * 300])] = given.pop(key, 1)
    else:
        given[key] = chance.choice(VALUES)


def state() -> tuple[dict[tuple[str, str], str], list[Any], str]:
    """Cells by test and column, entries of the log, and digest of the CSV, as a new desk finds them."""
    desk = Desk(NAME)
    content = desk.csv.read_bytes()
    table = parsed(content)
    cells = {(test, column): table.value(test, column) for test in TESTS for column in COLUMNS}
    return cells, [*desk.changes], digest(content)


def what_is_wrong(before: Any, after: Any, status: int, told: dict[str, Any], path: str) -> str:
    """Why the two files don't go with an answer; empty where they do."""
    cells, log, known = after
    if status >= 500:
        return f"answered {status}: {told.get('error', '')}"
    if left := [each.name for each in Path("config/campaigns").iterdir() if each.name.startswith(".")]:
        return f"left behind: {', '.join(left)}"
    if log[: len(before[1])] != before[1]:
        return "entries of the log are lost"
    folded = dict(before[0])
    for change in log[len(before[1]) :]:
        if change.cell != LOOKED_AT:
            folded[change.test, change.cell] = " ".join(change.after.split(" "))
    if folded != cells:
        return "the log and the CSV differ"
    if status in (400, 404, 405, 409, 410, 413) and (after != before):
        return "kept, though refused"
    if status == 200 and path == "do/keep" and told.get("digest") != known:
        return "answered 200 and not kept"
    if status and "error" in told and (not str(told["error"]) or "\n" in str(told["error"])):
        return f"no line: {told['error']!r}"
    return ""


def tried(n: int, seed: int, faults: bool = True) -> tuple[Counter[str], list[str]]:
    """Send n requests to two desks of the campaign here; counts of outcomes, and what is wrong."""
    counts, wrong, before, chance = Counter[str](), list[str](), state(), random.Random(seed)
    with closing(Served()) as one, closing(Served()) as other:
        for number in range(n):
            desk = chance.choice([one, other])
            if not desk.known or chance.random() < 0.5:
                desk.known = before[2]
                desk.ask("ask/again")
            path, body = request(chance, desk.known)
            kind = chance.choice(FAULTS) if faults else "none"
            least, most = (0, 500 + 2 * _longest()) if kind == "short" else (1, MOST_WRITES)
            desk.fault.set(kind, chance.randint(least, most))
            status, told = desk.ask(path, body)
            desk.known = told.get("digest", desk.known)
            if kind == "short":
                desk.close()
                desk.begin()
            elif desk.revive():
                counts["killed"] += 1
            after = state()
            if why := what_is_wrong(before, after, status, told, path):
                wrong.append(f"{number}: {path} ({kind}): {why}")
                print(wrong[-1], flush=True)
            counts[f"{status} {path.partition('?')[0]}" if status in (200, 409) else str(status)] += 1
            counts[f"{kind}, answered {status}" if kind != "none" else "no fault"] += 1
            before = after
            if (number + 1) % TOLD_EVERY == 0:
                print(f"{number + 1} requests: {len(wrong)} wrong", flush=True)
    return counts, wrong


def main() -> int:
    """Try, print counts, return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("requests", type=int, nargs="?", default=2000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    folder = Path(tempfile.mkdtemp())
    write_campaign(folder)
    os.chdir(folder)
    counts, wrong = tried(given.requests, given.seed)
    entries = len(state()[1])
    print("; ".join(f"{count} {what}" for what, count in sorted(counts.items())))
    print(f"{given.requests} requests: {len(wrong)} wrong; {entries} entries in {log_of('small.csv')}")
    if not wrong:
        shutil.rmtree(folder)
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
