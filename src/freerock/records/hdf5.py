"""HDF5 and netCDF records, this project's own among them; HDF5 through h5py, classic netCDF through scipy."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import netcdf_file

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import Channel, Contents, Even, Stamps, names_in_short
from freerock.records.headings import KEY, also_stated, is_time, split_unit, stated_rate, states_rate

FORMAT = "HDF5"
CLASSIC = b"CDF"
LABELS = ("columns", "column_names", "labels", "channel_names", "names", "channels")
UNITS = ("units", "unit", "Units", "Unit", "unit_string")

Attributes = Mapping[str, Any]


@dataclass(frozen=True)
class Array:
    """An array of a file: how many samples its vectors have, and a way to all of them; or why it is none."""

    shape: tuple[int, ...]
    load: Any  # callable without arguments; None where it is no vector
    unfit: str = ""


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an HDF5 or netCDF file.

    Channels are vectors of numbers, columns of matrices and fields of records. Time is one called time, t and
    so on in the channel's group or in one above it; else an attribute of the channel, or an attribute or
    single number of these groups, states the sampling rate (sampling_rate, fs, dt, …). Packed values
    (scale_factor, add_offset, _FillValue) are unpacked.
    """
    with open(path, "rb") as file:
        classic = file.read(3) == CLASSIC
    if classic:
        with netcdf_file(path, mmap=False) as file:
            arrays = {
                n: a for n, v in file.variables.items() for n, a in vectors(n, v.data, v._attributes).items()
            }
            attributes = {name: v._attributes for name, v in file.variables.items()}
            yield of_arrays(path, arrays, attributes | {"": file._attributes}, "netCDF classic")
        return
    with h5py.File(path, locking=False) as file:
        arrays, attributes = arrays_in(file)
        yield of_arrays(path, arrays, attributes, FORMAT)


def arrays_in(
    file: h5py.File, plain: Callable[[Attributes], str] = lambda _: ""
) -> tuple[dict[str, Array], Any]:
    """Vectors of an HDF5 file and attributes, by path; `plain` says by attributes why one is none."""
    arrays: dict[str, Array] = {}
    attributes: dict[str, Attributes] = {"": dict(file.attrs)}

    def look(name: str, item: h5py.HLObject) -> None:
        if name.startswith(("#refs#", "#subsystem#")):
            return
        attributes[name] = dict(item.attrs)
        if isinstance(item, h5py.Dataset) and item.shape is not None:
            why = plain(attributes[name])
            arrays.update(
                {name: Array(item.shape, item, why)} if why else vectors(name, item, attributes[name])
            )

    file.visititems(look)
    return arrays, attributes


def vectors(name: str, data: Any, attributes: Attributes) -> dict[str, Array]:
    """The vectors and single numbers of a dataset by path: itself, its columns or its fields."""
    shape = tuple(n for n in data.shape if n != 1)
    if data.dtype.names:
        fields = [field for field in data.dtype.names if data.dtype[field].kind in "iuf"]
        if len(shape) > 1 or not fields:
            return {
                name: Array(data.shape, None, f"holds records of shape {data.shape}, type {data.dtype}"[:120])
            }
        return {f"{name}/{f}": Array(shape, partial(_field, data, f)) for f in fields}
    if data.dtype.kind not in "iuf":
        return {name: Array(shape, None, f"holds {data.dtype}, no real numbers")}
    if len(shape) < 2:
        return {name: Array(shape, lambda: np.asarray(data[()]).reshape(-1))}
    if len(shape) > 2 or shape[0] == shape[1]:
        return {name: Array(data.shape, None, f"has shape {data.shape}, neither a vector nor columns")}
    n, wide = min(shape), shape[0] < shape[1]
    labels = next((_texts(attributes[key]) for key in LABELS if key in attributes), [])
    names = [f"{name}/{label}" for label in labels] if len({*labels}) == n else []

    def column(i: int) -> Any:
        whole = np.asarray(data[()]).reshape(shape)
        return whole[i] if wide else whole[:, i]

    return {
        (names[i] if names else f"{name}(:,{i + 1})"): Array((max(shape),), partial(column, i))
        for i in range(n)
    }


def _field(data: Any, name: str) -> Any:
    return np.asarray(data[name]).reshape(-1)


def of_arrays(
    path: Path, arrays: Mapping[str, Array], attributes: Mapping[str, Attributes], kind: str
) -> Contents:
    """Channels of the vectors among arrays by path; attributes are of arrays and of groups, "" the file."""
    found = [name for name, a in arrays.items() if not a.unfit and len(a.shape) == 1 and a.shape[0] > 1]
    single: dict[str, dict[str, float]] = {}  # by group
    for name, array in arrays.items():
        group, _, last = name.rpartition("/")
        if not array.unfit and prod(array.shape) == 1 and states_rate({last: 1.0}):
            single.setdefault(group, {})[last] = float(np.asarray(array.load()).reshape(-1)[0])
    found.sort(key=lambda name: name.endswith(")"))  # columns of matrices last
    times = [name for name in found if is_time(name.rpartition("/")[2])]
    channels: list[Channel] = []
    start = _text(attributes.get("", {}).get("time_coverage_start"))  # of datasets, as CF has it
    without = f"no vector of time and no sampling rate (variables: {names_in_short(arrays)})"
    for name in [name for name in found if name not in times]:
        folders, own = _above(name), attributes.get(name, {})
        beside = {last: x for folder in folders for last, x in single.get(folder, {}).items()}
        levels: list[Mapping[str, object]]
        levels = [_numbers(own), *(_numbers(attributes.get(folder, {})) for folder in folders), beside]
        near = next((n for f in folders if (n := [t for t in times if t.rpartition("/")[0] == f])), [])
        fit = [time for time in near if arrays[time].shape == arrays[name].shape]
        clock: Even | Stamps | str
        if len(fit) == 1:
            unit = _unit(attributes, fit[0])
            clock = Stamps(fit[0], fit[0], unit, "s")
            begun = unit.partition(" since ")[2]
            start = "" if begun.startswith("1970-01-01") else begun or start
        elif near:
            told = [f"{time} {arrays[time].shape[0]}" for time in near]
            clock = f"has {arrays[name].shape[0]} samples, its time {names_in_short(told)}"
        else:
            rate = next((rate for values in levels if (rate := stated_rate(path, values))), None)
            clock = rate or Even(
                0.0, asked=(without, f"save the time as t, or the sampling rate in Hz as fs{KEY}")
            )
        group, _, last = name.rpartition("/")
        also = tuple(rate for values in levels for rate in also_stated(path, values))
        channels.append(Channel(last, _unit(attributes, name), name, clock, group, also))
    left_out = [
        (name, a.unfit) for name, a in arrays.items() if a.unfit and (prod(a.shape) > 1 or a.load is None)
    ]
    channels += [Channel(n.rpartition("/")[2], "", n, why, n.rpartition("/")[0]) for n, why in left_out]
    if not any(not isinstance(c.clock, str) for c in channels):
        why = names_in_short(f"{c.name} {c.clock}" for c in channels) or names_in_short(arrays) or "none"
        remedy = "save the time and each signal as a vector of numbers"
        raise FreerockError(path, f"no vector of numbers that could be a signal ({why})", remedy)

    def read(names: Sequence[str]) -> dict[str, Floats]:
        return {name: _unpacked(arrays[name].load(), attributes.get(name, {})) for name in names}

    return Contents(channels, read, kind, [], start)


def _unpacked(array: Any, attributes: Attributes) -> Floats:
    """A vector as doubles, unpacked by CF."""
    values, stated = np.array(array, float), _numbers(attributes)
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


def _unit(attributes: Mapping[str, Attributes], name: str) -> str:
    """Unit of an array by its attributes, else by its name."""
    stated = (_text(attributes.get(name, {}).get(key)) for key in UNITS)
    return next(filter(None, stated), "") or split_unit(name.rpartition("/")[2].partition("(:")[0])[1]


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


def _texts(value: Any) -> list[str]:
    return [_text(each) for each in np.asarray(value).reshape(-1)]


def _text(value: Any) -> str:
    value = np.asarray(value).reshape(-1)[0] if value is not None and np.size(value) else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
