"""Checksums of files; one that looks as it did when its checksum was taken is not read again."""

import json
import os
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

from freerock.errors import FreerockError
from freerock.files import check_special, read_json, sha256, write_text

LOOKS = Path(".snakemake/freerock.looks.json")  # of files on this machine; without it they are read again
TICK_NS, COARSE_TICK_NS = 20_000_000, 2_000_000_000  # of a file system's clock, and of one in whole seconds
Look = tuple[int, ...]  # size, times of content and of status [ns], inode
Known = dict[str, dict[Look, str]]


def checksum(path: str | Path) -> tuple[str, Look | None]:
    """SHA-256 of a file, and how it looked where a later change is sure to show.

    Raises
    ------
    FreerockError
        It can't be read.
    """
    now_ns, before = time.time_ns(), look(path)
    found = sha256(path)
    return found, before if before and before == look(path) and look_settled(before, now_ns) else None


def look(path: str | Path) -> Look | None:
    """How a file looks without being read: what changes its content changes this. None without a file.

    Raises
    ------
    FreerockError
        It is a FIFO, a socket or a device.
    """
    try:
        seen = os.stat(path)
    except OSError:
        return None
    check_special(path, seen.st_mode)
    return seen.st_size, seen.st_mtime_ns, seen.st_ctime_ns, seen.st_ino


def look_settled(seen: Look, now_ns: int) -> bool:
    """Whether a file that is changed from now on gets another time: its last change is not of this moment."""
    changed_ns = max(seen[1], seen[2])
    return now_ns - changed_ns > (COARSE_TICK_NS if changed_ns % 1_000_000_000 == 0 else TICK_NS)


class Checksums:
    """Checksums of files. A file that looks as it did when its checksum was taken is not read again.

    Parameters
    ----------
    known : mapping
        By path, the checksum of each look; empty, every file is read.
    """

    def __init__(self, known: Known) -> None:
        self.known = known
        self.found: dict[str, tuple[str | None, Look | None]] = {}

    def look_at(self, paths: Iterable[str]) -> None:
        """Take the checksums of files, several at once; FreerockError where one can't be read."""
        unknown = []
        for path in dict.fromkeys(paths):
            if path in self.found:
                continue
            seen = look(path)
            told = self.known.get(path, {}).get(seen) if seen else None
            if seen is None or told:
                self.found[path] = told, seen
            else:
                unknown.append(path)
        if unknown:
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                self.found |= dict(zip(unknown, pool.map(checksum, unknown), strict=True))

    def sha256(self, path: str) -> str | None:
        """Checksum of a file; None where there is none."""
        if path not in self.found:
            self.look_at([path])
        return self.found[path][0]

    def note(self, notes: Path = LOOKS) -> None:
        """Write down what need not be read next time, beside what was written down of other files."""
        before = {path: [told, *seen] for path, told, seen in noted(notes)}
        now = {path: [told, *seen] for path, (told, seen) in self.found.items() if told and seen}
        kept = {path: each for path, each in before.items() if path not in self.found}
        if kept | now != before:
            write_text(notes, json.dumps(kept | now, ensure_ascii=False))


def noted(notes: Path = LOOKS) -> list[tuple[str, str, Look]]:
    """Path, checksum and look of each file as an earlier run wrote them down; none where they are damaged."""
    with suppress(FreerockError):
        read = read_json(notes, "delete it")
        if isinstance(read, dict) and all(isinstance(each, list) for each in read.values()):
            return [(path, each[0], tuple(each[1:])) for path, each in read.items() if is_look(each[1:])]
    return []


def is_look(seen: Any) -> bool:
    """Whether a value read from JSON is the look of a file."""
    return isinstance(seen, list) and len(seen) == 4 and all(isinstance(each, int) for each in seen)
