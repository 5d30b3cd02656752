"""Accelerograms of the PEER strong-motion databases: four lines of text, then accelerations in g."""

import re
from pathlib import Path

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN

HEADER = 4  # lines
STATED = re.compile(r"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*([0-9.E+-]+)")
OLDER = re.compile(r"^\s*(\d+)\s+([0-9.E+-]+)\s+NPTS,\s*DT")


def read_at2(path: str | Path) -> tuple[Floats, Floats]:
    """Time from 0 [s] and acceleration [g] of an accelerogram, shape (n,).

    The fourth line states the number of samples and their interval, as "NPTS= 4096, DT= .0100 SEC" or
    "4096 0.0100 NPTS, DT".

    Raises
    ------
    FreerockError
        Another unit, no number of samples or interval, another number of samples, what is no number.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="latin-1").splitlines()
    except OSError as error:
        raise FreerockError(path, f"can't be read ({error.strerror})", COPY_AGAIN) from None
    head = " ".join(lines[:HEADER]).upper()
    fourth = lines[HEADER - 1].upper() if len(lines) >= HEADER else ""
    stated = STATED.search(fourth) or OLDER.search(fourth)
    if not stated:
        remedy = "write it as NPTS= 4096, DT= .0100 SEC, or the file as a table with a column of time"
        raise FreerockError(path, "its fourth line states no NPTS and DT", remedy)
    if "UNITS OF G" not in head:
        raise FreerockError(path, "does not state UNITS OF G", "give the acceleration in g")
    n, step_s = int(stated[1]), _number(path, HEADER, stated[2])
    if not step_s > 0:
        raise FreerockError(path, f"DT is {step_s:g} s", "correct the fourth line")
    words = [(i, word) for i, line in enumerate(lines[HEADER:], HEADER + 1) for word in line.split()]
    if len(words) != n or n < 2:
        raise FreerockError(path, f"has {len(words)} samples and states NPTS= {n}", COPY_AGAIN)
    time_s: Floats = np.arange(n, dtype=float) * step_s
    return time_s, np.array([_number(path, line, word) for line, word in words])


def _number(path: Path, line: int, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise FreerockError(f"{path}:{line}", f"{word[:20]!r} is not a number", COPY_AGAIN) from None
