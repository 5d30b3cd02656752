"""HDF5 and netCDF records, this project's own among them; HDF5 through h5py, classic netCDF through scipy."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import netcdf_file

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import (
    COPY_AGAIN,
    Channel,
    Contents,
    Even,
    SampleColumn,
    Stamps,
    names_in_short,
)
from freerock.records.headings import also_stated, is_time, split_unit, stated_rate, states_rate

FORMAT = "HDF5"
CLASSIC = b"CDF"

Attributes = Mapping[str, Any]


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an HDF5 or netCDF file.

    Channels are vectors of numbers. Time is a vector called time, t and so on in the channel's group or in
    one above it; else an attribute of the channel, or an attribute or single number of these groups, states
    the sampling rate (sampling_rate, fs, dt, …). Packed values (scale_factor, add_offset, _FillValue) are
    unpacked.
    """
    with open(path, "rb") as file:
        classic = file.read(3) == CLASSIC
    if classic:
        with netcdf_file(path, mmap=False) as file:
            arrays = {name: v for name, v in file.variables.items() if v.data.dtype.kind in "iuf"}
            attributes = {name: v._attributes for name, v in arrays.items()}
            yield _contents(path, arrays, attributes | {"": file._attributes}, "netCDF classic")
        return
    with h5py.File(path, locking=False) as file:
        arrays = numeric_arrays(file)
        above = {folder for name in arrays for folder in _above(name)}
        attributes = {name: dict(file[name or "/"].attrs) for name in [*arrays, *above]}
        yield _contents(path, arrays, attributes, FORMAT)


def numeric_arrays(file: h5py.File) -> dict[str, h5py.Dataset]:
    """Datasets of real numbers by their paths in an HDF5 file."""
    found: dict[str, h5py.Dataset] = {}

    def look(name: str, item: h5py.HLObject) -> None:
        real = isinstance(item, h5py.Dataset) and item.shape is not None and item.dtype.kind in "iuf"
        if real and not name.startswith("#refs#"):
            found[name] = item

    file.visititems(look)
    return found


def _contents(
    path: Path, arrays: Mapping[str, Any], attributes: Mapping[str, Attributes], kind: str
) -> Contents:
    """Channels of the vectors among arrays by path; attributes are of arrays and of groups, "" the file."""
    vectors = [name for name, array in arrays.items() if len(array.shape) == 1 and array.shape[0] > 1]
    single: dict[str, dict[str, float]] = {}  # by group
    for name, array in arrays.items():
        group, _, last = name.rpartition("/")
        if prod(array.shape) == 1 and states_rate({last: 1.0}):
            single.setdefault(group, {})[last] = float(np.asarray(array[()]).item())
    times = {name.rpartition("/")[0]: name for name in vectors if is_time(name.rpartition("/")[2])}
    channels: list[Channel] = []
    without: list[str] = []
    start = ""
    for name in vectors:
        if name in times.values():
            continue
        folders = _above(name)
        time = next((times[folder] for folder in folders if folder in times), None)
        clock: Even | Stamps | str | None
        beside = {last: x for folder in folders for last, x in single.get(folder, {}).items()}
        levels: list[Mapping[str, object]]
        levels = [_numbers(attributes[name]), *(_numbers(attributes[folder]) for folder in folders), beside]
        if time:
            unit = _text(attributes[time].get("units")) or split_unit(time.rpartition("/")[2])[1]
            clock = Stamps(time, time, unit)
            if arrays[name].shape != arrays[time].shape:
                clock = f"has {arrays[name].shape[0]} samples, its time {arrays[time].shape[0]}"
            start = start or _start_time(unit)
        else:
            clock = next((rate for values in levels if (rate := stated_rate(path, values))), None)
        if clock is None:
            without.append(name)
            continue
        group, _, last = name.rpartition("/")
        units = _text(attributes[name].get("units"))
        also = tuple(rate for values in levels for rate in also_stated(path, values))
        channels.append(Channel(last, units, name, clock, group, also))
    if not vectors:
        raise FreerockError(path, "the file holds no vector of numbers", COPY_AGAIN)
    if without and not channels:
        what = f"no vector of time and no sampling rate (vectors: {names_in_short(without)})"
        raise FreerockError(path, what, "add a vector time, or an attribute sampling_rate in Hz")

    def read(names: Sequence[str]) -> dict[str, SampleColumn]:
        return {name: _Packed(arrays[name], attributes[name]) for name in names}

    start = start or _text(attributes.get("", {}).get("time_coverage_start"))  # of datasets, as CF has it
    return Contents(channels, read, kind, start_time=start)


@dataclass(frozen=True)
class _Packed:
    """A vector in a file, which attributes unpack by CF."""

    array: Any
    attributes: Attributes

    def __len__(self) -> int:
        return int(self.array.shape[0])

    def __getitem__(self, part: slice) -> Floats:
        values, stated = np.array(self.array[part], float), _numbers(self.attributes)
        for fill in (stated.get("_FillValue"), stated.get("missing_value")):
            if isinstance(fill, float):
                values[values == fill] = np.nan
        values *= float(stated.get("scale_factor", 1.0))
        values += float(stated.get("add_offset", 0.0))
        return values


def _above(name: str) -> list[str]:
    """The groups above an array, the next one first."""
    parts = name.split("/")[:-1]
    return ["/".join(parts[:n]) for n in range(len(parts), -1, -1)]


def _numbers(attributes: Attributes) -> dict[str, float | str]:
    """The attributes that are single numbers, or texts."""
    found: dict[str, float | str] = {}
    for name, value in attributes.items():
        array = np.asarray(value)
        if array.dtype.kind in "iuf" and array.size == 1:
            found[name] = float(array.reshape(-1)[0])
        elif array.dtype.kind in "SU":
            found[name] = _text(value)
    return found


def _text(value: Any) -> str:
    value = np.asarray(value).reshape(-1)[0] if value is not None and np.size(value) else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _start_time(unit: str) -> str:
    """Start in a unit of time such as "seconds since 2017-05-01"; 1970 stands for an unknown one."""
    start = unit.partition(" since ")[2]
    return "" if start.startswith("1970-01-01") else start
