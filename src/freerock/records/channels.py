"""What every reader gives: the channels of a file, their clocks, and a way to their samples."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from freerock.arrays import Floats
from freerock.errors import FreerockError

COPY_AGAIN = "copy it again from the acquisition computer"
NAMES_LISTED = 20
RATES_DIFFER = 0.01  # so much, as a share, and two rates are not the same one rounded


@dataclass(frozen=True)
class Even:
    """A sampling interval that the file states.

    Parameters
    ----------
    step_s, start_s : float
        The interval and the first instant [s].
    origin : str
        Date and time from which start_s counts; "" where the file states none.
    asked : (str, str) or None
        Why the interval is not known, and what the user may do.
    """

    step_s: float
    start_s: float = 0.0
    origin: str = ""
    asked: tuple[str, str] | None = None


@dataclass(frozen=True)
class Stamps:
    """A column of time stamps, and its unit as the file states it ("" where it states none).

    `default` is the unit that the format is known for; "" where files of it are in any.
    """

    name: str
    column: Any
    unit: str
    default: str = ""


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
        Gives the samples by column for a sequence of columns.
    format : str
        Attribute of the dataset.
    notes : list of str
        What the reader found out about the file by itself; attribute `reading`. Reading may add to it.
    start_time : str
        Attribute of the dataset; "" where the file states no date.
    above : sequence of str
        The rows above the numbers, but for headings.
    """

    channels: Sequence[Channel]
    read: Callable[[Sequence[Any]], Mapping[Any, Floats]]
    format: str
    notes: list[str]
    start_time: str = ""
    above: Sequence[str] = ()


class Named(dict[str, Channel]):
    """Channels of a file by name, and the rows above the numbers."""

    above: Sequence[str] = ()


def differ(one: float, other: float) -> bool:
    """Whether two sampling intervals are not the same one rounded."""
    return abs(one / other - 1) > RATES_DIFFER


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
    short = Counter(c.name for c in contents.channels)
    names = Named({c.name if short[c.name] == 1 else f"{c.group}/{c.name}": c for c in contents.channels})
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
    if channel is None:
        wanted = {name: c for name, c in names.items() if not isinstance(c.clock, str)}
        if not wanted:
            why = names_in_short(f"{name} {c.clock}" for name, c in names.items())
            raise FreerockError(path, f"no channel holds numbers ({why})", "export the signals as numbers")
        return wanted
    full = {f"{c.group}/{c.name}": name for name, c in names.items()}
    name = channel if channel in names else full.get(channel)
    if name is None:
        remedy = "correct the channel column of the campaign's CSV"
        raise FreerockError(path, f"no channel {channel!r}; its channels are {names_in_short(names)}", remedy)
    if isinstance(names[name].clock, str):
        what = f"channel {name!r} {names[name].clock}"
        raise FreerockError(path, what, "name a channel that holds numbers, or export it as numbers")
    return {name: names[name]}
