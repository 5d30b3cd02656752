"""Channels of a record file as one dataset over even time."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from freerock import bounds
from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records import channels
from freerock.records.channels import Channel, Contents, Even, SampleColumn, Stamps
from freerock.records.timebase import Grid, on_grid, regular_grid, typical_step

if TYPE_CHECKING:
    import xarray as xr


def dataset(path: Path, contents: Contents, channel: str | None) -> "xr.Dataset":
    """Read the channel requested, or all, into one dataset over time.

    Parameters
    ----------
    path : Path
        The file, for errors.
    contents : Contents
        What its reader found.
    channel : str or None
        The one to read.

    Raises
    ------
    FreerockError
        A missing or empty channel, channels of several time bases, time stamps that no even grid fits, a
        sampling interval that is none, or two that contradict each other.
    """
    wanted = channels.chosen(path, channels.by_name(path, contents), channel)
    clocks = list(dict.fromkeys(c.clock for c in wanted.values() if not isinstance(c.clock, str)))
    stamps = [clock for clock in clocks if isinstance(clock, Stamps)]
    others = [clock for c in wanted.values() for clock in c.also if isinstance(clock, Stamps)]
    sought = [*(c.column for c in wanted.values()), *(s.column for s in [*stamps, *others])]
    columns = dict(contents.read(list(dict.fromkeys(sought))))
    length = _one_length(path, wanted, clocks, columns)
    notes = list(contents.notes)
    if stamps:
        grid, length = _stamped(path, stamps[0], columns[stamps[0].column], length)
        notes += [] if stamps[0].unit else ["time has no unit and is taken for seconds"]
    else:
        (even,) = (clock for clock in clocks if isinstance(clock, Even))
        grid = Grid(even.start_s, even.step_s, length)
    if not bounds.SHORTEST_STEP_S < grid.step_s < bounds.LONGEST_STEP_S:
        what = f"the sampling interval is {grid.step_s:g} s"
        raise FreerockError(path, what, "correct it, or the unit of time, where the file states it")
    _check_other_clocks(path, wanted.values(), grid.step_s, columns)
    for column in columns.keys() - {c.column for c in wanted.values()}:
        del columns[column]  # stamps are as large as a channel
    import xarray as xr  # half a second, which listing the channels does without

    attrs = {
        "format": contents.format,
        "start_time": contents.start_time,
        "sampling_rate_hz": 1 / grid.step_s,
        "reading": "; ".join(notes),
        "time_base": "; ".join(grid.faults),
    }
    return xr.Dataset(
        {
            name: ("time", _placed(path, name, grid, columns.pop(c.column), length), {"units": c.units})
            for name, c in wanted.items()
        },
        coords={"time": ("time", np.arange(grid.size) * grid.step_s + grid.start_s, {"units": "s"})},
        attrs={key: value for key, value in attrs.items() if value != ""},
    )


def _check_values(path: Path, name: str, values: Floats) -> None:
    """Refuse a finite sample whose powers no double holds."""
    for start in range(0, len(values), channels.SAMPLES_AT_ONCE):
        part = values[start : start + channels.SAMPLES_AT_ONCE]
        beyond = np.flatnonzero(np.isfinite(part) & (np.abs(part) > bounds.SAMPLE_UNITS))
        if beyond.size:
            n = start + int(beyond[0])
            what = f"channel {name!r} holds {values[n]:.6g} at sample {n}, beyond ±{bounds.SAMPLE_UNITS:g}"
            raise FreerockError(path, what, "export it again, an invalid sample as an empty cell or NaN")


def _one_length(
    path: Path,
    wanted: Mapping[str, Channel],
    clocks: Sequence[Even | Stamps],
    columns: Mapping[Any, SampleColumn],
) -> int:
    """Number of samples of channels that share a clock and a length."""
    lengths = {name: len(columns[c.column]) for name, c in wanted.items()}
    for name, length in lengths.items():
        if not length:
            raise FreerockError(path, f"channel {name!r} is empty", channels.COPY_AGAIN)
    if not _one_clock(clocks, columns):
        several = f"channels of several time bases: {channels.names_in_short(lengths)}"
        raise FreerockError(path, several, "name the channel")
    if len(set(lengths.values())) > 1:
        unequal = channels.names_in_short(f"{name} {n}" for name, n in lengths.items())
        raise FreerockError(path, f"channels of unequal length: {unequal}", "name the channel")
    return next(iter(lengths.values()))


def _one_clock(clocks: Sequence[Even | Stamps], columns: Mapping[Any, SampleColumn]) -> bool:
    """Whether clocks are one: equal, or columns of equal stamps."""
    if len(clocks) == 1:
        return True
    stamps = [clock for clock in clocks if isinstance(clock, Stamps)]
    if len(stamps) < len(clocks):
        return False
    first = channels.whole(columns[stamps[0].column])
    return len({clock.unit for clock in stamps}) == 1 and all(
        np.array_equal(channels.whole(columns[clock.column]), first, equal_nan=True) for clock in stamps[1:]
    )


def _stamped(path: Path, clock: Stamps, column: SampleColumn, length: int) -> tuple[Grid, int]:
    """Grid of a channel's stamps, and how many of its samples have one; empty rows at the end don't count."""
    if len(column) != length:
        what = f"{length} samples but {len(column)} time stamps in {clock.name!r}"
        raise FreerockError(path, what, channels.COPY_AGAIN)
    stamps = channels.whole(column, channels.seconds_in(path, clock.unit))
    while length and np.isnan(stamps[length - 1]):
        length -= 1
    return regular_grid(f"{path}: {clock.name!r}", stamps[:length]), length


def _check_other_clocks(
    path: Path, wanted: Iterable[Channel], step_s: float, columns: Mapping[Any, SampleColumn]
) -> None:
    """Refuse a second sampling rate that contradicts the first; time without a unit may be in any."""
    for clock in dict.fromkeys(clock for channel in wanted for clock in channel.also):
        if isinstance(clock, Even):
            steps, where = [clock.step_s], "the file states"
        else:
            step = typical_step(channels.whole(columns[clock.column]))
            units = {clock.unit} & channels.SECONDS_OF_UNIT.keys()
            steps = [
                step * channels.SECONDS_OF_UNIT[unit] for unit in (units - {""} or channels.SECONDS_OF_UNIT)
            ]
            where = f"{clock.name!r} gives"
        if min(steps) > 0 and all(channels.differ(each, step_s) for each in steps):
            what = f"one clock gives {1 / step_s:.6g} Hz, and {where} {1 / max(steps):.6g} Hz"
            raise FreerockError(path, what, "correct the one that is wrong, or its unit, or leave it out")


def _placed(path: Path, name: str, grid: Grid, column: SampleColumn, length: int) -> Floats:
    """Samples of a channel at the instants of the grid."""
    if length < len(column):
        late = np.isfinite(column[length : len(column)]).sum()
        if late:
            what = f"{late} samples at the end have no time stamp"
            raise FreerockError(path, what, "export the time column again")
        column = channels.whole(column)[:length]
    samples = on_grid(path, grid, column)
    _check_values(path, name, samples)
    return samples
