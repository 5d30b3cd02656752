"""Reads the corrections by hand in the cells of a campaign's CSV, and writes such cells.

`runs.hand_corrections` tells their way to the fit.
"""

import re
from collections.abc import Iterable
from decimal import Decimal
from itertools import pairwise
from typing import NamedTuple

from freerock.config.values import Invalid, shown

RUN, SECONDS = "[0-9]{1,6}", r"(-?[0-9]{1,9}(?:\.[0-9]{0,12})?)"
ITEM = re.compile(rf"({RUN})\s*@\s*{SECONDS}\s*:\s*{SECONDS}(?:\s+hold\s+{SECONDS}\s*:\s*{SECONDS})?")
AS = "2@12.310:19.800 or 2@12.310:19.800 hold 10.000:12.200"
LEFT_OUT = re.compile(rf"({RUN})|{SECONDS}\s*:\s*{SECONDS}")
NOTHING, WHOLE_RECORD = "", "record"
EXCLUDED = "record, or numbers of runs and stretches of time in seconds, as 2;3;12.310:12.450"


class Override(NamedTuple):
    """A run set by hand.

    Parameters
    ----------
    run : int
        Its number among all runs of the record, found or set by hand, in the order of release.
    release_s, end_s : float
        Release and end in the time of the record [s].
    reason : str
        Why; a cell does not say it.
    hold_s : (float, float) or None
        From when to when it is held before [s], where θ0 is read; None leaves that to be found.
    """

    run: int
    release_s: float
    end_s: float
    reason: str = ""
    hold_s: tuple[float, float] | None = None


class Exclusions(NamedTuple):
    """What a cell leaves out of a record.

    Parameters
    ----------
    runs : tuple of int
        Numbers of runs.
    stretches : tuple of (float, float)
        From when to when samples are not used [s].
    """

    runs: tuple[int, ...] = ()
    stretches: tuple[tuple[float, float], ...] = ()


def read_exclusions(cell: str) -> Exclusions:
    """What a cell leaves out, in its order there; nothing but "record" leaves out all of it.

    Raises
    ------
    Invalid
        It is not understood, or a stretch ends before it begins.
    """
    runs, stretches = list[int](), list[tuple[float, float]]()
    for item in cell.split(";") if cell not in (NOTHING, WHOLE_RECORD) else []:
        match = LEFT_OUT.fullmatch(item.strip())
        if not match:
            raise Invalid(f"{shown(item)} is not understood", f"give {EXCLUDED}")
        run, from_s, to_s = match.groups()
        if run:
            runs.append(int(run))
        elif float(from_s) < float(to_s):
            stretches.append((float(from_s), float(to_s)))
        else:
            raise Invalid(f"the stretch {item.strip()} ends before it begins", "give its begin first")
    return Exclusions(tuple(runs), tuple(stretches))


def written_exclusions(runs: Iterable[int], stretches: Iterable[tuple[float, float]]) -> str:
    """The cell that `read_exclusions` reads as these runs and stretches, in order."""
    times = [f"{_seconds(from_s)}:{_seconds(to_s)}" for from_s, to_s in sorted(stretches)]
    return ";".join([*map(str, sorted({*runs})), *dict.fromkeys(times)])


def read_overrides(cell: str) -> tuple[Override, ...]:
    """The runs that a cell sets by hand, in their order there.

    A cell holds `run@release:end`, or `run@release:end hold from:to`, more after a `;`.

    Raises
    ------
    Invalid
        It is not understood, or its runs contradict one another: what is known before a record is read.
    """
    runs = tuple(_read(item.strip()) for item in cell.split(";") if item.strip())
    if len({each.run for each in runs}) < len(runs):
        raise Invalid("a run is overridden twice", "give each run once")
    for one, other in pairwise(sorted(runs)):
        what = f"run {one.run} lasts from {one.release_s:g} to {one.end_s:g} s"
        if other.release_s <= one.release_s:
            what += f", run {other.run} is released at {other.release_s:g} s"
            raise Invalid(what, "number runs in the order of release")
        if other.release_s < one.end_s or (other.hold_s and other.hold_s[0] < one.end_s):
            raise Invalid(f"{what}, in which run {other.run} is held or released", "end it before")
    return runs


def written_overrides(runs: Iterable[Override]) -> str:
    """The cell that `read_overrides` reads as these runs."""
    cells = []
    for run, release_s, end_s, _, hold_s in runs:
        hold = f" hold {_seconds(hold_s[0])}:{_seconds(hold_s[1])}" if hold_s else ""
        cells.append(f"{run}@{_seconds(release_s)}:{_seconds(end_s)}{hold}")
    return ";".join(cells)


def _read(item: str) -> Override:
    match = ITEM.fullmatch(item)
    if not match:
        what = f"{shown(item)} is not run@release:end, nor run@release:end hold from:to"
        raise Invalid(what, f"give run and seconds, as {AS}")
    release_s, end_s = float(match[2]), float(match[3])
    hold_s = (float(match[4]), float(match[5])) if match[4] else None
    each = Override(int(match[1]), release_s, end_s, hold_s=hold_s)
    for wrong, what, remedy in (
        (each.run == 0, "there is no run 0", "count from 1"),
        (release_s >= end_s, f"run {each.run} ends before it is released", "give the release first"),
        (hold_s and hold_s[0] >= hold_s[1], f"the hold of run {each.run} ends first", "give its begin first"),
        (hold_s and hold_s[1] > release_s, f"run {each.run} is held once released", "end the hold before"),
    ):
        if wrong:
            raise Invalid(what, remedy)
    return each


def _seconds(time_s: float) -> str:
    """A time with milliseconds at least, so that it is read as the same number."""
    short = f"{time_s:.3f}"
    return short if float(short) == time_s else format(Decimal(repr(time_s)), "f")
