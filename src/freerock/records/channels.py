"""What the readers share: the channels of a file, the choice among them, and their dataset."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from freerock.errors import FreerockError
from freerock.records.timebase import Grid, on_grid, regular_grid

if TYPE_CHECKING:
    import xarray as xr

COPY_AGAIN = "copy it again from the acquisition computer"
NAMES_TOLD = 20
NAMES_ONLY = object()  # in place of a channel's name: list the channels and read none
# Deflate, the densest compression of these formats, shrinks data at most 1032 times.
DENSEST = 1100
LITTLE = 1 << 26  # bytes that need no check


SECONDS = {
    **dict.fromkeys(["", "s", "sec", "secs", "second", "seconds", "sek", "sekunden"], 1.0),
    **dict.fromkeys(["ms", "msec", "millisecond", "milliseconds"], 1e-3),
    **dict.fromkeys(["us", "µs", "μs", "microsecond", "microseconds"], 1e-6),
    **dict.fromkeys(["ns", "nsec", "nanosecond", "nanoseconds"], 1e-9),
    **dict.fromkeys(["min", "minute", "minutes"], 60.0),
}


@dataclass(frozen=True)
class Even:
    """A sampling interval that the file states, and its first instant [s]."""

    step_s: float
    start_s: float = 0.0


@dataclass(frozen=True)
class Stamps:
    """A column of time stamps in the unit that the file states, or none."""

    name: str
    column: Hashable
    unit: str


@dataclass(frozen=True)
class Channel:
    """A channel; `column` is where its reader finds it; in place of a clock, why it can't be read."""

    name: str
    units: str
    column: Hashable
    clock: Even | Stamps | str
    group: str = ""


def dataset(
    path,
    channels: Sequence[Channel],
    channel: str | None,
    read: Callable[[list], dict],
    attrs: dict,
    notes: Iterable[str] = (),
) -> "xr.Dataset":
    """Read the channel asked for, or all, into one dataset over time.

    Parameters
    ----------
    path : path
        The file, for errors.
    channels : sequence of Channel
        Its channels.
    channel : str or None
        The one to read. `NAMES_ONLY` returns the channels by their names instead of a dataset.
    read : callable
        Gives arrays by column for a list of columns.
    attrs : dict
        Attributes of the dataset.
    notes : iterable of str
        What the reader found out about the file by itself; attribute `reading`.
    """
    names = by_name(path, channels)
    if channel is NAMES_ONLY:
        return names
    wanted = chosen(path, names, channel)
    clocks = list(dict.fromkeys(c.clock for c in wanted.values()))
    stamps = [clock for clock in clocks if isinstance(clock, Stamps)]
    columns = read(list(dict.fromkeys([c.column for c in wanted.values()] + [s.column for s in stamps])))
    lengths = {name: len(columns[c.column]) for name, c in wanted.items()}
    for name, length in lengths.items():
        if not length:
            raise FreerockError(path, f"channel {name!r} is empty", COPY_AGAIN)
    if not _one_clock(clocks, columns):
        several = f"channels of several time bases: {listed(lengths)}"
        raise FreerockError(path, several, "name the channel")
    if len(set(lengths.values())) > 1:
        told = listed(f"{name} {n}" for name, n in lengths.items())
        raise FreerockError(path, f"channels of unequal length: {told}", "name the channel")

    length = next(iter(lengths.values()))
    notes = list(notes)
    if stamps:
        grid, length = _stamped(path, stamps[0], columns[stamps[0].column], length)
        notes += [] if stamps[0].unit else ["time has no unit and is taken for seconds"]
    else:
        grid = Grid(clocks[0].start_s, clocks[0].step_s, length)
    import xarray as xr  # half a second, which listing the channels does without

    told = {"reading": "; ".join(notes), "time_base": "; ".join(grid.faults)}
    return xr.Dataset(
        {
            name: ("time", _placed(path, grid, columns[c.column], length), {"units": c.units})
            for name, c in wanted.items()
        },
        coords={"time": ("time", _instants(grid), {"units": "s"})},
        attrs=attrs
        | {"sampling_rate_hz": 1 / grid.step_s}
        | {key: text for key, text in told.items() if text},
    )


def seconds_in(where, unit: str) -> float:
    """A unit of time [s]; also of the form "seconds since 2017-05-01".

    Raises
    ------
    FreerockError
        No unit of time that is known.
    """
    plain = unit.casefold().split(" since ")[0].strip()
    if plain not in SECONDS:
        raise FreerockError(where, f"the time is in {unit[:40]!r}", "give it in s, ms, us or min")
    return SECONDS[plain]


def listed(names: Iterable[str]) -> str:
    """Names with commas, the first NAMES_TOLD of many."""
    names = list(names)
    more = f", and {len(names) - NAMES_TOLD} more" if len(names) > NAMES_TOLD else ""
    return ", ".join(names[:NAMES_TOLD]) + more


def check_declared(path, n_bytes: float, densest: float = DENSEST) -> None:
    """Refuse to set aside more memory than a file of its size can fill, but for a little."""
    size = path.stat().st_size
    if n_bytes > max(densest * size, LITTLE):
        what = f"the file declares {n_bytes:.3g} bytes of data, more than its {size} bytes can hold"
        raise FreerockError(path, what, COPY_AGAIN)


def by_name(path, channels: Sequence[Channel]) -> dict[str, Channel]:
    """Channels by name, or by group/name where two groups share a name."""
    short = [c.name for c in channels]
    names = {c.name if short.count(c.name) == 1 else f"{c.group}/{c.name}": c for c in channels}
    if not names:
        raise FreerockError(path, "the file holds no channel", COPY_AGAIN)
    return names


def chosen(path, names: dict[str, Channel], channel: str | None) -> dict[str, Channel]:
    """The channel asked for, or all that can be read.

    Raises
    ------
    FreerockError
        There is no such channel, or it can't be read.
    """
    if channel is None:
        wanted = {name: c for name, c in names.items() if not isinstance(c.clock, str)}
        if not wanted:
            raise FreerockError(path, f"no channel holds a number (channels: {listed(names)})", COPY_AGAIN)
        return wanted
    full = {f"{c.group}/{c.name}": name for name, c in names.items()}
    name = channel if channel in names else full.get(channel)
    if name is None:
        remedy = "correct the channel column of the campaign's CSV"
        raise FreerockError(path, f"no channel {channel!r}; its channels are {listed(names)}", remedy)
    if isinstance(names[name].clock, str):
        raise FreerockError(
            path, f"channel {name!r} {names[name].clock}", "name a channel that holds numbers"
        )
    return {name: names[name]}


def _one_clock(clocks, columns):
    """Whether clocks are one: equal, or columns of equal stamps."""
    if len(clocks) == 1:
        return True
    if not all(isinstance(clock, Stamps) for clock in clocks):
        return False
    first = columns[clocks[0].column]
    return len({clock.unit for clock in clocks}) == 1 and all(
        np.array_equal(columns[clock.column], first, equal_nan=True) for clock in clocks[1:]
    )


def _stamped(path, clock, stamps, length):
    """Grid of a channel's stamps, and how many of its samples have one; empty rows at the end don't count."""
    if len(stamps) != length:
        what = f"{length} samples but {len(stamps)} time stamps in {clock.name!r}"
        raise FreerockError(path, what, COPY_AGAIN)
    known = np.flatnonzero(~np.isnan(stamps))
    length = known[-1] + 1 if known.size else 0
    return regular_grid(f"{path}: {clock.name!r}", stamps[:length] * seconds_in(path, clock.unit)), length


def _placed(path, grid, values, length):
    if np.isfinite(values[length:]).any():
        what = f"{np.isfinite(values[length:]).sum()} samples at the end have no time stamp"
        raise FreerockError(path, what, "export the time column again")
    return on_grid(path, grid, values[:length])


def _instants(grid):
    instants = np.arange(grid.size, dtype=float)
    instants *= grid.step_s
    instants += grid.start_s
    return instants
