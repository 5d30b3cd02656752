"""Snakemake's checksums of files: each worked out once as long as the file stands."""

import os
from collections.abc import Awaitable, Callable
from functools import wraps
from typing import Any

Checksum = Callable[..., Awaitable[str | None]]


def once(checksum: Checksum) -> Checksum:
    """A method of Snakemake's files that works out their checksum, with what it found kept.

    Snakemake notes with each product the checksums of all that its job read, and works each out again: of a
    batch of forty records forty times. What is kept counts as long as size and time of the last change of the
    file are the same; nothing can set that time back.
    """
    known: dict[tuple[Any, ...], str | None] = {}

    @wraps(checksum)
    async def kept(file: Any, *arguments: Any, **named: Any) -> str | None:
        try:
            status = os.stat(file)
        except OSError:  # not there, or not a local file
            return await checksum(file, *arguments, **named)
        asked = str(file), arguments, tuple(sorted(named.items()))
        key = *asked, status.st_ino, status.st_size, status.st_ctime_ns
        if key not in known:
            known[key] = await checksum(file, *arguments, **named)
        return known[key]

    return kept
