"""The door to record files: a module per format, named in `formats.toml`; begin a new one from `tdms`.

Samples are put on a uniform grid. It is right where they were taken evenly and only their stamps are coarse,
jittery or missing.
"""

import tomllib
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats, Indices
from freerock.errors import FreerockError, number_of
from freerock.records import channels
from freerock.records.cells import OVERLOAD
from freerock.records.channels import COPY_AGAIN, Contents, Even, Grid, Named, Stamps
from freerock.records.headings import SECOND_UNITS, by_word, seconds_in

if TYPE_CHECKING:
    import xarray as xr


FORMATS = tomllib.loads(Path(__file__).with_name("formats.toml").read_text(encoding="utf-8"))
# By suffix: the module of this room with contents(path), which yields `channels.Contents`; other programs.
READERS, NOT_READ = by_word(FORMATS["readers"]), by_word(FORMATS["not_read"])
LABVIEW = b"LabVIEW Measurement"
STATE_RATE = "head the time as Time [s], state the rate in the file as fs in Hz, or give sampling_rate_hz"
Clocks = tuple[Even | Stamps, tuple[Even | Stamps, ...], int]  # of a channel, others, its length

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
        handled, see `regular_grid`).

    Raises
    ------
    FreerockError
        A missing, truncated, empty or unreadable file; an unknown format; a missing channel; several time
        bases; no sampling rate, or a unit of time that is not understood; time stamps that no even grid fits.
        Nothing else leaves this function.

    Examples
    --------
    >>> record = read_record("raw/palermo_virtual/config2_marble.tdms")
    >>> print(*record.data_vars, record.attrs["sampling_rate_hz"])
    laser 2000.0
    """
    path = Path(path)
    with _opened(path) as contents:
        wanted = channels.chosen(path, channels.by_name(path, contents), channel)
        columns = {name: c.load() for name, c in wanted.items()}
        for name in [name for name, column in columns.items() if not column.size]:
            raise FreerockError(path, f"channel {name!r} is empty", COPY_AGAIN)
        clocks = {name: (c.clock, c.also, columns[name].size) for name, c in wanted.items()}
        given = contents.notes, time_unit, rate_hz
        known = {clock: _grid(path, clock, given) for clock in dict.fromkeys(clocks.values())}
        grids = {name: known[clock] for name, clock in clocks.items()}
        origins = {clock.origin if isinstance(clock, Even) else "" for clock, *_ in known}
        if len(origins) > 1 or len({*grids.values()}) > 1:
            several = f"channels of several time bases: {channels.names_in_short(columns)}"
            raise FreerockError(path, several, "name the channel")
        placed = {name: on_grid(path, grids[name], column) for name, column in columns.items()}
        units = {name: c.units for name, c in wanted.items()}
        return _dataset(contents, next(iter(grids.values())), placed, units, min(origins))


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

    Examples
    --------
    >>> print(*list_channels("raw/palermo_virtual/config2_marble.tdms"))
    laser
    """
    with _opened(Path(path)) as contents:
        return channels.by_name(Path(path), contents)


@contextmanager
def _opened(path: Path) -> Iterator[Contents]:
    """What the reader of a file's format finds in it, while the file is open."""
    if path.is_dir():
        raise FreerockError(path, "is a folder", "name the files in it")
    if not path.is_file():
        raise FreerockError(path, "no such file", "put it there, or correct its name")
    suffix = path.suffix.lower()
    if program := NOT_READ.get(suffix):
        raise FreerockError(path, f"{suffix} files of {program} are not read", "export it there as CSV")
    if suffix not in READERS:
        raise FreerockError(path, f"unknown format {path.suffix!r}", f"use one of {', '.join(READERS)}")
    with open(path, "rb") as file:
        begins = file.read(len(LABVIEW))
    if not begins:
        raise FreerockError(path, "the file is empty", COPY_AGAIN)
    labview = READERS[suffix] == "text" and begins == LABVIEW
    reader = import_module(f"freerock.records.{'lvm' if labview else READERS[suffix]}")
    try:
        with warnings.catch_warnings(action="ignore"), reader.contents(path) as contents:
            yield contents
    except FreerockError:
        raise
    except Exception as error:  # the libraries raise whatever damaged bytes lead them into
        what = f"not a readable {suffix} file ({type(error).__name__}: {str(error)[:200]})"
        raise FreerockError(path, what, COPY_AGAIN) from error


def _grid(path: Path, clocks: Clocks, given: tuple[list[str], str, float | None]) -> Grid:
    """Grid of samples by their clock, or by the unit of time and the rate given; adds to the notes."""
    (clock, others, length), (notes, time_unit, rate_hz) = clocks, given
    also = [*others, *([Even(1 / rate_hz, origin="sampling_rate_hz")] if rate_hz else [])]
    if isinstance(clock, Stamps):
        where = f"{path}: {clock.name!r}"
        time_s, told = _in_seconds(where, clock, also, time_unit)
        notes.append(told)
        if len(time_s) != length:
            what = f"{number_of(length, 'sample')} but {number_of(len(time_s), 'time stamp')}"
            raise FreerockError(where, what, COPY_AGAIN)
        while length and np.isnan(time_s[length - 1]):  # empty rows at the end
            length -= 1
        grid = regular_grid(where, time_s[:length])
    elif clock.unknown and not rate_hz:
        raise FreerockError(path, clock.unknown, STATE_RATE)
    else:
        grid = Grid(clock.start_s, 1 / rate_hz if rate_hz and clock.unknown else clock.step_s, length)
    if not channels.is_possible(grid.step_s):
        raise FreerockError(path, f"the sampling interval is {grid.step_s:g} s", "correct the unit of time")
    for clock in also:  # a second rate; time without a unit may be in any
        if isinstance(clock, Even):
            steps, where = [clock.step_s], f"{clock.origin or 'the file'} states"
        else:
            known = SECOND_UNITS.get(clock.unit.casefold())
            step, factors = typical_step(clock.load()), [known] if known else EPOCHS.values()
            steps, where = [step * factor for factor in factors], f"{clock.name!r} gives"
        if min(steps) > 0 and all(channels.differ(each, grid.step_s) for each in steps):
            what = f"one clock gives {1 / grid.step_s:.6g} Hz, and {where} {1 / max(steps):.6g} Hz"
            raise FreerockError(path, what, "correct the one that is wrong, or its unit, or leave it out")
    return grid


def _in_seconds(where: str, clock: Stamps, also: Sequence[Even | Stamps], given: str) -> tuple[Floats, str]:
    """Stamps [s], and what was found out: a unit that is not stated may follow from what else is."""
    stamps = clock.load()
    if clock.unit:
        factor = seconds_in(where, clock.unit)
        if given and seconds_in("time_unit", given) != factor:
            what = f"the file states {clock.unit}, and time_unit is {given}"
            raise FreerockError(where, what, "remove time_unit, or correct it")
        return stamps if factor == 1 else stamps * factor, ""
    if given:
        return stamps * seconds_in("time_unit", given), f"time is in {given}, as time_unit says"
    known = stamps[np.isfinite(stamps)]
    step = typical_step(known) if known.size > 1 else 0.0
    steps = [other.step_s for other in also if isinstance(other, Even)]
    for unit, factor in EPOCHS.items():
        if known.size and SINCE_1970_S[0] < known[0] * factor < SINCE_1970_S[1]:
            return (stamps - known[0]) * factor, f"time counts {unit} since 1970, by its size"
        if steps and step > 0 and not channels.differ(step * factor, steps[0]):
            return stamps * factor, f"time is in {unit}, by the sampling rate that the file states"
    if clock.default and 0 < step < PLAIN_STEP_S:
        return stamps, "time has no unit and is taken for seconds"
    raise FreerockError(where, "the time states no unit", "write it as time [ms], or give time_unit")


def _dataset(
    contents: Contents, grid: Grid, placed: Mapping[str, Floats], units: Mapping[str, str], origin: str
) -> "xr.Dataset":
    """Channels on one grid as a dataset over time; a sample out of range is NaN."""
    import xarray as xr  # half a second, which listing the channels does without

    found: dict[str, tuple[str, Floats, dict[str, object]]] = {}
    notes = contents.notes
    for name, samples in placed.items():
        beyond = np.abs(samples) >= OVERLOAD
        over, values = np.flatnonzero(beyond), np.where(beyond, np.nan, samples)
        found[name] = ("time", values, {"units": units[name]})
        if over.size:
            found[name][2]["out_of_range"] = over.astype(np.int64)
            over_told = number_of(over.size, "sample")
            notes.append(f"{over_told} of {name} out of range, the first at {over[0]}")
    attrs = {
        "format": contents.format,
        "start_time": origin or contents.start_time,
        "sampling_rate_hz": 1 / grid.step_s,
        "reading": "; ".join(filter(None, dict.fromkeys(notes))),
        "above": "\n".join(contents.above),
        "time_base": "; ".join(grid.faults),
    }
    time_s = np.arange(grid.size) * grid.step_s + grid.start_s
    attrs = {key: value for key, value in attrs.items() if value != ""}
    return xr.Dataset(found, {"time": ("time", time_s, {"units": "s"})}, attrs)


MILD_JITTER = 0.25  # of the sampling interval: largest deviation of a stamp from the grid
GAP = 1.5  # sampling intervals between two stamps from which a sample is missing
ROUNDED_SHARE = 0.01  # rarer than that, an odd interval is a fault and not rounding
ROUNDED_STAMPS = 10  # different stamps that show rounding at least
NAMEABLE = 1e-3  # of the sampling interval: smaller deviations are not worth a note

EXPORT = "export the time column again"
SPLIT = "split it into one file per recording"


def regular_grid(where: object, time_s: ArrayLike) -> Grid:
    """Uniform grid of the time stamps of a record.

    Samples count as evenly taken where their stamps are rounded to few digits, or leave the grid by
    MILD_JITTER of a sampling interval at most. Missing stamps leave instants empty. A stretch after a gap is
    moved on to the grid, by less than half a sampling interval.

    Parameters
    ----------
    where : str
        File or column named in errors.
    time_s : array, shape (n,)
        Stamps [s].

    Raises
    ------
    FreerockError
        Fewer than two stamps, missing or infinite ones, time that runs backwards or stands still, jitter that
        is not mild, a rate that drifts, gaps longer than the recording.
    """
    time = np.asarray(time_s, float)
    if time.size < 2:
        what = f"no sampling rate from {number_of(time.size, 'time stamp')}"
        raise FreerockError(where, what, "record more samples")
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        what = f"{number_of(bad.size, 'time stamp')} missing or infinite, the first at sample {bad[0]}"
        raise FreerockError(where, what, EXPORT)
    back = np.flatnonzero(time[1:] < time[:-1])
    if back.size:
        two = f"from {time[back[0]]:.6g} to {time[back[0] + 1]:.6g} s"
        raise FreerockError(where, f"time runs backwards {two} after sample {back[0]}", SPLIT)
    if time[-1] == time[0]:
        raise FreerockError(where, f"all time stamps are {time[0]:.6g} s", EXPORT)
    return _rounded(time) or _pieces(where, time)


def typical_step(time_s: Floats) -> float:
    """Typical interval between time stamps [s]."""
    return float(np.median(np.diff(time_s)))


def on_grid(where: object, grid: Grid, samples: Floats) -> Floats:
    """Samples at the instants of the grid, NaN where none was taken.

    Raises
    ------
    FreerockError
        Two samples with one stamp that differ; samples without a stamp at the end.
    """
    stamped = grid.size if grid.places is None else grid.places.size
    if late := int(np.count_nonzero(np.isfinite(samples[stamped:]))):
        raise FreerockError(where, f"{number_of(late, 'sample')} at the end without a time stamp", EXPORT)
    samples = samples[:stamped]
    if grid.places is None:
        return samples
    repeated = np.flatnonzero(np.diff(grid.places) == 0)
    differ = (samples[repeated] != samples[repeated + 1]) & ~np.isnan(samples[repeated + 1])
    if differ.any():
        n = repeated[differ][0]
        what = f"samples {n} and {n + 1} have one time stamp and differ"
        raise FreerockError(where, what, "export the time column with more digits")
    first = np.ones(samples.size, bool)
    first[repeated + 1] = False  # the first of two stays
    placed = np.full(grid.size, np.nan)
    placed[grid.places[first]] = samples[first]
    return placed


def _rounded(time: Floats) -> Grid | None:
    """Grid of stamps that were rounded to few decimal digits, else None."""
    steps = np.diff(time)
    digit = steps[steps > 0].min()
    counts = np.rint(steps / digit)
    often = np.mean(counts > counts.min())
    decimal = abs(np.log10(digit) - np.rint(np.log10(digit))) < 1e-3
    exact = np.abs(steps - counts * digit).max() <= 1e-3 * digit
    shown = np.count_nonzero(steps) >= ROUNDED_STAMPS and ROUNDED_SHARE <= often <= 1 - ROUNDED_SHARE
    if not (decimal and exact and shown and np.ptp(counts) == 1):
        return None
    step, start, off = _line(time, np.arange(time.size, dtype=float), np.zeros(time.size, np.intp), digit)
    if off > digit:
        return None
    fault = f"time stamps rounded to {digit:.3g} s; evenly spaced by {step:.6g} s on average"
    return Grid(float(start[0]), step, time.size, faults=(fault,))


def _line(time: Floats, number: Floats, piece: Indices, typical: float) -> tuple[float, Floats, float]:
    """Straight lines of one slope through the stamps of each stretch over their numbers.

    Returns the slope (typical where they give none), the start of each stretch and the largest deviation [s].
    """
    sums = [np.bincount(piece, weights) for weights in (None, time, number)]
    mean_time, mean_number = sums[1] / sums[0], sums[2] / sums[0]
    centred = number - mean_number[piece]
    product = centred @ centred
    step = centred @ (time - mean_time[piece]) / product if product else typical
    start = mean_time - step * mean_number
    return float(step), start, float(np.abs(time - start[piece] - step * number).max())


def _pieces(where: object, time: Floats) -> Grid:
    """Grid of stamps in stretches between gaps, with one sampling interval for all."""
    steps = np.diff(time, prepend=time[0])
    typical = float(np.median(steps[steps > 0]))
    number = np.cumsum(steps > 0, dtype=float)
    piece = np.cumsum(steps > GAP * typical, dtype=np.intp)
    told = number_of(piece[-1], "gap")
    step, start, off = _line(time, number, piece, typical)
    deviation = off / step
    if not deviation <= MILD_JITTER:
        what = f"the stamps leave an even grid of {step:.6g} s by up to {deviation:.2g} sampling intervals"
        raise FreerockError(where, what, "export with the logger's own clock, or resample it evenly")
    places = (number + np.rint((start - start[0]) / step)[piece]).astype(np.intp)
    size, taken = int(places[-1]) + 1, int(number[-1]) + 1
    if size > 2 * taken:
        raise FreerockError(where, f"{size - taken} of {size} samples are missing in {told}", SPLIT)

    faults = []
    if deviation > NAMEABLE:
        faults.append(f"time stamps jitter by up to {100 * deviation:.2g} % of the sampling interval")
    if time.size > taken:
        faults.append(f"{number_of(time.size - taken, 'repeated sample')} dropped")
    if size > taken:
        begins = time[np.flatnonzero(np.diff(places) > 1)[0]]
        faults.append(
            f"{number_of(size - taken, 'sample')} missing in {told}, the first after {begins:.6g} s"
        )
    even = size == time.size and taken == size
    first = time[0] if deviation <= NAMEABLE else start[0]
    return Grid(float(first), step, size, None if even else places, tuple(faults))
