"""What every reader gives: the channels of a file, their clocks, and a way to their samples."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from freerock.arrays import Floats, Indices
from freerock.errors import FreerockError

COPY_AGAIN = "copy it again from the acquisition computer"
NAME_ONE = "name one (of a campaign in the channel column of its CSV)"
NAMES_LISTED = 20
RATES_DIFFER = 0.01  # so much, as a share, and two rates are not the same one rounded

Load = Callable[[], Floats]


@dataclass(frozen=True)
class Even:
    """A sampling interval that the file states.

    Parameters
    ----------
    step_s, start_s : float
        The interval and the first instant [s].
    origin : str
        Date and time from which start_s counts; "" where the file states none.
    unknown : str
        Why the interval is not known; "" where it is.
    """

    step_s: float
    start_s: float = 0.0
    origin: str = ""
    unknown: str = ""


@dataclass(frozen=True, eq=False)
class Stamps:
    """A column of time stamps, and its unit as the file states it ("" where it states none).

    `default` is the unit that the format is known for; "" where files of it are in any.
    """

    name: str
    load: Load
    unit: str
    default: str = ""


@dataclass(frozen=True)
class Grid:
    """Uniform grid of a column of stamps.

    Parameters
    ----------
    start_s, step_s : float
        First instant and sampling interval [s].
    size : int
        Number of instants.
    places : ndarray of int, shape (n_stamps,), or None
        Instant of each stamp; None when the n-th stamp is the n-th instant.
    faults : tuple of str
        What was found and how it was handled.
    """

    start_s: float
    step_s: float
    size: int
    places: Indices | None = field(default=None, compare=False)
    faults: tuple[str, ...] = field(default=(), compare=False)


@dataclass(frozen=True, eq=False)
class Channel:
    """A channel; `load` gives its samples; `fault` says why it can't be read, "" where it can.

    `also` are other clocks that the file gives for it, which must agree with the first.
    """

    name: str
    units: str
    load: Load
    clock: Even | Stamps
    group: str = ""
    also: tuple[Even | Stamps, ...] = ()
    fault: str = ""


@dataclass(frozen=True)
class Contents:
    """What a reader finds in a file.

    Parameters
    ----------
    channels : sequence of Channel
    format : str
        Attribute of the dataset.
    notes : list of str
        What the reader found out about the file by itself; attribute `reading`. Loading may add to it.
    start_time : str
        Attribute of the dataset; "" where the file states no date.
    above : sequence of str
        The rows above the numbers, but for headings.
    """

    channels: Sequence[Channel]
    format: str
    notes: list[str]
    start_time: str = ""
    above: Sequence[str] = ()


class Named(dict[str, Channel]):
    """Channels of a file by name, and the rows above the numbers."""

    above: Sequence[str] = ()


def unfit(name: str, why: str, group: str = "") -> Channel:
    """A channel that can't be read, and why."""
    return Channel(name, "", lambda: np.empty(0), Even(np.nan), group, fault=why)


def is_possible(step: float) -> bool:
    """Whether a number may be a sampling interval [s], or a rate [Hz]."""
    return 1e-12 < step < 1e12


def differ(one: float, other: float) -> bool:
    """Whether two sampling intervals are not the same one rounded."""
    return abs(one / other - 1) > RATES_DIFFER


def names_in_short(names: Iterable[str]) -> str:
    """Names with commas, the first NAMES_LISTED of many."""
    names = list(names)
    more = f", and {len(names) - NAMES_LISTED} more" if len(names) > NAMES_LISTED else ""
    return ", ".join(names[:NAMES_LISTED]) + more


def by_name(path: Path, contents: Contents) -> Named:
    """Channels by name, or by group/name where two groups share a name; repeated names end in (2), (3) …

    Raises
    ------
    FreerockError
        No channel.
    """
    groups = Counter(name for name, _ in {(c.name, c.group) for c in contents.channels})
    names, seen = Named(), Counter[str]()
    for c in contents.channels:
        name = c.name if groups[c.name] == 1 else f"{c.group}/{c.name}"
        seen[name] += 1
        names[name if seen[name] == 1 else f"{name} ({seen[name]})"] = c
    names.above = contents.above
    if not names:
        raise FreerockError(path, "the file holds no channel", COPY_AGAIN)
    return names


def chosen(path: Path, names: Mapping[str, Channel], channel: str | None) -> dict[str, Channel]:
    """The channel requested, or all that can be read.

    Raises
    ------
    FreerockError
        There is no such channel, or it can't be read.
    """
    if not channel:
        wanted = {name: c for name, c in names.items() if not c.fault}
        if not wanted:
            why = names_in_short(f"{name} {c.fault}" for name, c in names.items())
            raise FreerockError(path, f"no channel holds numbers ({why})", "export the signals as numbers")
        return wanted
    full = {f"{c.group}/{c.name}": name for name, c in reversed([*names.items()])}
    name = channel if channel in names else full.get(channel)
    if name is None:
        what = f"no channel {channel!r}; its channels are {names_in_short(names)}"
        raise FreerockError(path, what, NAME_ONE)
    if names[name].fault:
        raise FreerockError(path, f"channel {name!r} {names[name].fault}", "name one that holds numbers")
    return {name: names[name]}
