"""What every reader gives: the channels of a file, their clocks, and a way to their samples."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError

SAMPLES_AT_ONCE = 1 << 18  # samples; their temporary copies take little memory
COPY_AGAIN = "copy it again from the acquisition computer"
NAMES_LISTED = 20

SECONDS_OF_UNIT = {
    **dict.fromkeys(["", "s", "sec", "secs", "second", "seconds", "sek", "sekunden"], 1.0),
    **dict.fromkeys(["ms", "msec", "millisecond", "milliseconds"], 1e-3),
    **dict.fromkeys(["us", "µs", "μs", "microsecond", "microseconds"], 1e-6),
    **dict.fromkeys(["ns", "nsec", "nanosecond", "nanoseconds"], 1e-9),
    **dict.fromkeys(["min", "minute", "minutes"], 60.0),
}

RATES_DIFFER = 0.01  # so much, as a share, and two rates are not the same one rounded


class SampleColumn(Protocol):
    """Samples of a channel, in memory or in a file that is open: any part of them as doubles."""

    def __len__(self) -> int: ...

    def __getitem__(self, part: slice, /) -> Floats: ...


def whole(column: SampleColumn, unit: float = 1.0) -> Floats:
    """All samples of a column in a unit, part by part, lest memory holds them twice."""
    if isinstance(column, np.ndarray) and unit == 1:
        return np.asarray(column, float)
    values = np.empty(len(column))
    for start in range(0, len(column), SAMPLES_AT_ONCE):
        part = slice(start, start + SAMPLES_AT_ONCE)
        np.multiply(column[part], unit, out=values[part])
    return values


@dataclass(frozen=True)
class Even:
    """A sampling interval that the file states, and its first instant [s]."""

    step_s: float
    start_s: float = 0.0


@dataclass(frozen=True)
class Stamps:
    """A column of time stamps, and its unit as the file states it ("" where it states none)."""

    name: str
    column: Any
    unit: str


@dataclass(frozen=True)
class Channel:
    """A channel; `column` is where its reader finds it; `clock` is a text where it can't be read: why.

    `also` are other clocks that the file gives for it, which must agree with the first.
    """

    name: str
    units: str
    column: Any
    clock: Even | Stamps | str
    group: str = ""
    also: tuple[Even | Stamps, ...] = ()


@dataclass(frozen=True)
class Contents:
    """What a reader finds in a file.

    Parameters
    ----------
    channels : sequence of Channel
    read : callable
        Gives the samples by column for a sequence of columns; those of HDF5 stay in the file.
    format : str
        Attribute of the dataset.
    notes : sequence of str
        What the reader found out about the file by itself; attribute `reading`.
    start_time : str
        Attribute of the dataset; "" where the file states no date.
    """

    channels: Sequence[Channel]
    read: Callable[[Sequence[Any]], Mapping[Any, SampleColumn]]
    format: str
    notes: Sequence[str] = ()
    start_time: str = ""


Named = dict[str, Channel]  # channels of a file by name


def differ(one: float, other: float) -> bool:
    """Whether two sampling intervals are not the same one rounded."""
    return abs(one / other - 1) > RATES_DIFFER


def seconds_in(where: object, unit: str) -> float:
    """A unit of time [s]; also of the form "seconds since 2017-05-01".

    Raises
    ------
    FreerockError
        No unit of time that is known.
    """
    plain = unit.casefold().split(" since ")[0].strip()
    if plain not in SECONDS_OF_UNIT:
        raise FreerockError(where, f"the time is in {unit[:40]!r}", "give it in s, ms, us or min")
    return SECONDS_OF_UNIT[plain]


def names_in_short(names: Iterable[str]) -> str:
    """Names with commas, the first NAMES_LISTED of many."""
    names = list(names)
    more = f", and {len(names) - NAMES_LISTED} more" if len(names) > NAMES_LISTED else ""
    return ", ".join(names[:NAMES_LISTED]) + more


def by_name(path: Path, contents: Contents) -> Named:
    """Channels by name, or by group/name where two groups share a name.

    Raises
    ------
    FreerockError
        No channel.
    """
    channels = contents.channels
    short = Counter(c.name for c in channels)
    names = {c.name if short[c.name] == 1 else f"{c.group}/{c.name}": c for c in channels}
    if not names:
        raise FreerockError(path, "the file holds no channel", COPY_AGAIN)
    return names


def chosen(path: Path, names: Named, channel: str | None) -> dict[str, Channel]:
    """The channel requested, or all that can be read.

    Raises
    ------
    FreerockError
        There is no such channel, or it can't be read.
    """
    if channel is None:
        wanted = {name: c for name, c in names.items() if not isinstance(c.clock, str)}
        if not wanted:
            what = f"no channel holds a number (channels: {names_in_short(names)})"
            raise FreerockError(path, what, COPY_AGAIN)
        return wanted
    full = {f"{c.group}/{c.name}": name for name, c in names.items()}
    name = channel if channel in names else full.get(channel)
    if name is None:
        remedy = "correct the channel column of the campaign's CSV"
        raise FreerockError(path, f"no channel {channel!r}; its channels are {names_in_short(names)}", remedy)
    if isinstance(names[name].clock, str):
        what = f"channel {name!r} {names[name].clock}"
        raise FreerockError(path, what, "name a channel that holds numbers")
    return {name: names[name]}
