"""The door to record files: `READERS` names the module of each format. A new one begins best from `tdms`."""

import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from freerock import bounds
from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records import channels
from freerock.records.cells import OVERLOAD
from freerock.records.channels import COPY_AGAIN, Channel, Contents, Even, Named, Stamps
from freerock.records.headings import seconds_in
from freerock.records.timebase import Grid, on_grid, regular_grid, typical_step
from freerock.records.times import SECOND_UNITS

if TYPE_CHECKING:
    import xarray as xr

# Suffix: module of this room with FORMAT, its name, and contents(path), which yields `channels.Contents`.
READERS = {
    ".tdms": "tdms",
    ".lvm": "lvm",
    ".mat": "mat",
    **dict.fromkeys([".csv", ".tsv", ".txt", ".asc", ".dat", ".prn"], "text"),
    **dict.fromkeys([".xlsx", ".xlsm"], "excel"),
    **dict.fromkeys([".h5", ".hdf5", ".nc"], "hdf5"),
    **dict.fromkeys([".uff", ".unv", ".uf", ".mf4", ".mdf", ".wav"], "waves"),
}
NOT_READ = {  # suffix: the program that writes it
    **dict.fromkeys([".dxd", ".d7d", ".d7z"], "DEWESoft"),
    **dict.fromkeys([".raw", ".imc", ".imcdev"], "imc FAMOS"),
    **dict.fromkeys([".tdm", ".tdx"], "NI DIAdem"),
    **dict.fromkeys([".bin", ".mea", ".tst"], "catman or an oscilloscope"),
    **dict.fromkeys([".psdata", ".psd"], "PicoScope"),
    **dict.fromkeys([".wfm", ".isf", ".trc"], "an oscilloscope"),
    **dict.fromkeys([".cap", ".spklab", ".cmbl", ".gmbl"], "PASCO or Vernier"),
    **dict.fromkeys([".xls", ".xlsb", ".ods"], "a spreadsheet program, in another format than .xlsx"),
}

EPOCHS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # units in which time since 1970 is written
SINCE_1970_S = 6e8, 4.2e9  # of a recording
PLAIN_STEP_S = 0.05  # longer steps of a record are none of seconds, as those of milliseconds would be


def read_record(
    path: str | Path, channel: str | None = None, *, time_unit: str = "", rate_hz: float | None = None
) -> "xr.Dataset":
    """Read a record file.

    Parameters
    ----------
    path : path-like
        The file; its suffix gives the format.
    channel : str, optional
        Read only this channel, named "channel" or "group/channel"; by default all channels that are numbers,
        provided that they share one time base.
    time_unit : str
        Unit of time stamps (s, ms, us, min) where the file states none; it must not contradict the file.
    rate_hz : float, optional
        Sampling rate [Hz] where the file states none; it must not contradict the file.

    Returns
    -------
    xarray.Dataset
        Over dimension time [s], from the file's own start offset (0 when it gives none): one variable per
        channel, with attribute units as the file states it ("" when it doesn't); a sample that is missing or
        out of range is NaN, and the attribute out_of_range numbers the latter. Attributes: format,
        sampling_rate_hz and, where there is something to say: start_time (ISO 8601, with the zone where the
        file states it), reading (what was found out about the file: delimiter, decimal comma, marks), above
        (rows above the numbers that are no headings), time_base (faults of the time stamps and how they were
        handled, see `timebase`).

    Raises
    ------
    FreerockError
        A missing, truncated, empty or unreadable file; an unknown format; a missing channel; several time
        bases; no sampling rate, or a unit of time that is not understood; time stamps that no even grid fits.
        Nothing else leaves this function.
    """
    path = Path(path)
    with _opened(path) as contents:
        return _dataset(path, contents, channel or None, time_unit, rate_hz)


def list_channels(path: str | Path) -> Named:
    """The channels of a record file, without reading their samples where the format allows it.

    Parameters
    ----------
    path : path-like
        The file; its suffix gives the format.

    Returns
    -------
    freerock.records.channels.Named
        Channel by the names that `read_record` accepts; if a channel can't be read, `clock` states why.

    Raises
    ------
    FreerockError
        As of `read_record`, as far as the samples need not be read.
    """
    path = Path(path)
    with _opened(path) as contents:
        return channels.by_name(path, contents)


@contextmanager
def _opened(path: Path) -> Iterator[Contents]:
    """What the reader of a file's format finds in it, while the file is open."""
    if path.is_dir():
        raise FreerockError(path, "is a folder", "name the files in it")
    if not path.is_file():
        raise FreerockError(path, "no such file", "put it there, or correct its name")
    suffix = path.suffix.lower()
    if suffix in NOT_READ:
        remedy = "export it there as CSV, TDMS, .mat or .xlsx"
        raise FreerockError(path, f"{suffix} files of {NOT_READ[suffix]} are not read", remedy)
    if suffix not in READERS:
        raise FreerockError(path, f"unknown format {path.suffix!r}", f"use one of {', '.join(READERS)}")
    if path.stat().st_size == 0:
        raise FreerockError(path, "the file is empty", COPY_AGAIN)
    reader = import_module(f"freerock.records.{READERS[suffix]}")
    if READERS[suffix] == "text" and reader.is_labview(path):
        reader = import_module("freerock.records.lvm")
    try:
        with warnings.catch_warnings(action="ignore"), reader.contents(path) as contents:
            yield contents
    except FreerockError:
        raise
    except Exception as error:  # the libraries raise whatever damaged bytes lead them into
        what = f"not a readable {reader.FORMAT} file ({type(error).__name__}: {str(error)[:200]})"
        raise FreerockError(path, what, COPY_AGAIN) from error


def _dataset(
    path: Path, contents: Contents, channel: str | None, time_unit: str = "", rate_hz: float | None = None
) -> "xr.Dataset":
    """The channel requested, or all, as one dataset over time."""
    wanted = channels.chosen(path, channels.by_name(path, contents), channel)
    clocks = list(dict.fromkeys(c.clock for c in wanted.values() if not isinstance(c.clock, str)))
    stamps = [clock for clock in clocks if isinstance(clock, Stamps)]
    also = list(dict.fromkeys(clock for c in wanted.values() for clock in c.also))
    sought = [c.column for c in wanted.values()]
    sought += [clock.column for clock in [*stamps, *also] if isinstance(clock, Stamps)]
    columns = dict(contents.read(list(dict.fromkeys(sought))))
    length = _one_length(path, wanted, clocks, columns)
    notes, begun = list(dict.fromkeys(contents.notes)), contents.start_time
    if stamps:
        time_s, told = _in_seconds(path, stamps[0], columns[stamps[0].column], also, time_unit)
        notes += told
        grid, length = _stamped(f"{path}: {stamps[0].name!r}", time_s, length)
    else:
        (even,) = (clock for clock in clocks if isinstance(clock, Even))
        if even.asked and not rate_hz:
            raise FreerockError(path, *even.asked)
        begun = even.origin or begun
        grid = Grid(even.start_s, 1 / rate_hz if even.asked and rate_hz else even.step_s, length)
    if not bounds.SHORTEST_STEP_S < grid.step_s < bounds.LONGEST_STEP_S:
        what = f"the sampling interval is {grid.step_s:g} s"
        raise FreerockError(path, what, "correct it, or the unit of time, where the file states it")
    also += [Even(1 / rate_hz, origin="sampling_rate_hz")] if rate_hz else []
    _check_other_clocks(path, also, grid.step_s, columns)
    import xarray as xr  # half a second, which listing the channels does without

    found = {}
    for name, c in wanted.items():
        samples, over = _placed(path, grid, columns[c.column], length)
        beyond = {"out_of_range": over.astype(np.int64)} if over.size else {}
        if over.size:
            notes.append(
                f"{over.size} samples of {name} are out of range and missing, the first at {over[0]}"
            )
        found[name] = ("time", samples, {"units": c.units} | beyond)
    attrs = {
        "format": contents.format,
        "start_time": begun,
        "sampling_rate_hz": 1 / grid.step_s,
        "reading": "; ".join(notes),
        "above": "\n".join(contents.above),
        "time_base": "; ".join(grid.faults),
    }
    return xr.Dataset(
        found,
        coords={"time": ("time", np.arange(grid.size) * grid.step_s + grid.start_s, {"units": "s"})},
        attrs={key: value for key, value in attrs.items() if value != ""},
    )


def _one_length(
    path: Path, wanted: Mapping[str, Channel], clocks: Sequence[Even | Stamps], columns: Mapping[Any, Floats]
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


def _one_clock(clocks: Sequence[Even | Stamps], columns: Mapping[Any, Floats]) -> bool:
    """Whether clocks are one: equal, or columns of equal stamps."""
    stamps = [clock for clock in clocks if isinstance(clock, Stamps)]
    if len(clocks) == 1 or len(stamps) < len(clocks):
        return len(clocks) == 1
    first = columns[stamps[0].column]
    return len({clock.unit for clock in stamps}) == 1 and all(
        np.array_equal(columns[clock.column], first, equal_nan=True) for clock in stamps[1:]
    )


def _in_seconds(
    path: Path, clock: Stamps, stamps: Floats, also: Iterable[Even | Stamps], given: str
) -> tuple[Floats, list[str]]:
    """Stamps [s], and what was found out: a unit that is not stated may follow from what else is."""
    where = f"{path}: {clock.name!r}"
    if clock.unit:
        factor = seconds_in(where, clock.unit)
        if given and seconds_in("time_unit", given) != factor:
            what = f"the file states {clock.unit}, and time_unit is {given}"
            raise FreerockError(where, what, "remove time_unit, or correct it")
        return (stamps if factor == 1 else stamps * factor), []
    known = stamps[np.isfinite(stamps)]
    if given:
        return stamps * seconds_in("time_unit", given), [f"time is in {given}, as time_unit says"]
    for unit, factor in EPOCHS.items():
        if known.size and SINCE_1970_S[0] < known[0] * factor < SINCE_1970_S[1]:
            return (stamps - known[0]) * factor, [f"time counts {unit} since 1970, by its size"]
    step = typical_step(known) if known.size > 1 else 0.0
    steps = [other.step_s for other in also if isinstance(other, Even)]
    units = [
        unit for unit, f in EPOCHS.items() if steps and step > 0 and not channels.differ(step * f, steps[0])
    ]
    if not units and clock.default and 0 < step < PLAIN_STEP_S:
        return stamps * seconds_in(where, clock.default), ["time has no unit and is taken for seconds"]
    if not units:
        remedy = "write the unit behind its name, as time [ms], or give time_unit"
        raise FreerockError(where, "the time states no unit", remedy)
    return stamps * EPOCHS[units[0]], [f"time is in {units[0]}, by the sampling rate that the file states"]


def _stamped(where: str, time_s: Floats, length: int) -> tuple[Grid, int]:
    """Grid of a channel's stamps, and how many of its samples have one; empty rows at the end don't count."""
    if len(time_s) != length:
        raise FreerockError(where, f"{length} samples but {len(time_s)} time stamps", channels.COPY_AGAIN)
    while length and np.isnan(time_s[length - 1]):
        length -= 1
    return regular_grid(where, time_s[:length]), length


def _check_other_clocks(
    path: Path, also: Iterable[Even | Stamps], step_s: float, columns: Mapping[Any, Floats]
) -> None:
    """Refuse a second sampling rate that contradicts the first; time without a unit may be in any."""
    for clock in also:
        if isinstance(clock, Even):
            steps, where = [clock.step_s], f"{clock.origin or 'the file'} states"
        else:
            step = typical_step(columns[clock.column])
            known = SECOND_UNITS.get(clock.unit.casefold())
            factors = [known] if known else [*EPOCHS.values()]
            steps, where = [step * factor for factor in factors], f"{clock.name!r} gives"
        if min(steps) > 0 and all(channels.differ(each, step_s) for each in steps):
            what = f"one clock gives {1 / step_s:.6g} Hz, and {where} {1 / max(steps):.6g} Hz"
            raise FreerockError(path, what, "correct the one that is wrong, or its unit, or leave it out")


def _placed(path: Path, grid: Grid, column: Floats, length: int) -> tuple[Floats, "np.ndarray[Any, Any]"]:
    """Samples of a channel at the instants of the grid, and which of them are out of range and become NaN."""
    late = np.count_nonzero(np.isfinite(column[length:]))
    if late:
        raise FreerockError(
            path, f"{late} samples at the end have no time stamp", "export the time column again"
        )
    samples = on_grid(path, grid, column[:length])
    with np.errstate(invalid="ignore"):
        over = np.flatnonzero(np.abs(samples) >= OVERLOAD)
    if over.size:
        samples = samples.copy()
        samples[over] = np.nan
    return samples, over
