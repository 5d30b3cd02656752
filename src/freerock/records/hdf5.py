"""HDF5 and netCDF records, this project's own among them; HDF5 through h5py, classic netCDF through scipy."""

from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import loadmat, netcdf_file
from scipy.io.matlab import MatlabFunction, MatlabOpaque, matfile_version

from freerock.arrays import Floats
from freerock.errors import number_of
from freerock.records.channels import Channel, Contents, Even, Load, Stamps, names_in_short, unfit
from freerock.records.headings import also_stated, is_time, split_unit, stated_rate, states_rate

AS_VECTORS = "save t = seconds(tt.Time) and x = tt.x as vectors"
LABELS = ("columns", "column_names", "labels", "channel_names", "names", "channels")
UNITS = ("units", "unit", "Units", "Unit", "unit_string")

Attributes = Mapping[str, Any]


@dataclass(frozen=True)
class Array:
    """An array of a file: its shape without sides of 1, and a way to its numbers; or why it has none."""

    shape: tuple[int, ...]
    load: Callable[[], Any] | None
    unfit: str = ""


Arrays = Mapping[str, Array]  # by path


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of an HDF5 or netCDF file.

    Channels are vectors of numbers, columns of matrices and fields of records. Time is one called time, t and
    so on in the channel's group or in one above it; else an attribute of the channel, or an attribute or
    single number of these groups, states the sampling rate (sampling_rate, fs, dt, …). Packed values
    (scale_factor, add_offset, _FillValue) are unpacked.
    """
    if h5py.is_hdf5(path):
        with h5py.File(path, locking=False) as file:
            yield of_arrays(path, *arrays_in(file), "MAT v7.3" if path.suffix.lower() == ".mat" else "HDF5")
    elif path.suffix.lower() == ".nc":
        with netcdf_file(path, mmap=False) as file:
            found = [vectors(name, each.data, each._attributes) for name, each in file.variables.items()]
            arrays = {name: array for each in found for name, array in each.items()}
            attributes = {name: each._attributes for name, each in file.variables.items()}
            yield of_arrays(path, arrays, attributes | {"": file._attributes}, "netCDF classic")
    else:
        version = "v5" if matfile_version(path)[0] else "v4"
        variables = {name: value for name, value in loadmat(path).items() if not name.startswith("__")}
        parts = [_arrays(name, value) for name, value in variables.items()]
        yield of_arrays(path, dict(ChainMap(*parts[::-1])), {}, f"MAT {version}")


def arrays_in(file: h5py.File) -> tuple[dict[str, Array], dict[str, Attributes]]:
    """Vectors of an HDF5 file and attributes, by path."""
    arrays: dict[str, Array] = {}
    attributes: dict[str, Attributes] = {"": dict(file.attrs)}

    def look(name: str, item: h5py.HLObject) -> None:
        if name.startswith(("#refs#", "#subsystem#")):  # of MATLAB
            return
        attributes[name] = dict(item.attrs)
        if isinstance(item, h5py.Dataset) and item.shape is not None:
            arrays.update(vectors(name, item, attributes[name]))

    file.visititems(look)
    return arrays, attributes


def _arrays(name: str, value: Any) -> dict[str, Array]:
    """The vectors in a variable by path, those of a structure's fields among them."""
    if isinstance(value, MatlabOpaque):
        kind, name = (as_text(value[field].flat[0]) for field in ("s2", "s0"))
        return {name: Array((), None, f"is a MATLAB {kind}: {AS_VECTORS}")}
    if isinstance(value, MatlabFunction) or not isinstance(value, np.ndarray):
        return {name: Array((), None, "is no array of numbers")}
    if value.dtype.names and value.size == 1:
        fields = (_arrays(f"{name}/{field}", value[field].flat[0]) for field in value.dtype.names)
        return {path: array for found in fields for path, array in found.items()}
    if value.dtype.names or value.dtype.kind == "O":
        what = "an array of structures" if value.dtype.names else "a cell array"
        return {name: Array((), None, f"is {what} of shape {value.shape}: save its parts as vectors")}
    return vectors(name, value, {}) if value.size else {}


def vectors(name: str, data: Any, attributes: Attributes) -> dict[str, Array]:
    """The vectors and single numbers of a dataset by path: itself, its columns or its fields."""
    shape = tuple(n for n in data.shape if n != 1)
    kind = as_text(attributes.get("MATLAB_class"))
    if "MATLAB_object_decode" in attributes or kind in ("char", "cell", "function_handle"):
        return {name: Array((), None, f"is a MATLAB {kind}: {AS_VECTORS}")}
    if data.dtype.names:
        fields = [field for field in data.dtype.names if data.dtype[field].kind in "iuf"]
        if len(shape) < 2 and fields:
            return {f"{name}/{field}": Array(shape, partial(_column, data, shape, field)) for field in fields}
    elif data.dtype.kind in "iuf" and len(shape) < 2:
        return {name: Array(shape, partial(_column, data, shape, ()))}
    elif data.dtype.kind in "iuf" and len(shape) == 2 and shape[0] != shape[1]:
        given = next((attributes[key] for key in LABELS if key in attributes), ())
        labels = [as_text(each) for each in np.asarray(given).reshape(-1)]
        fits = len({*labels}) == min(shape)
        names = [f"/{label}" for label in labels] if fits else [f"(:,{i + 1})" for i in range(min(shape))]
        columns = [Array((max(shape),), partial(_column, data, shape, i)) for i in range(min(shape))]
        return {f"{name}{each}": column for each, column in zip(names, columns, strict=True)}
    return {name: Array((), None, f"has shape {data.shape} and type {data.dtype}, no vectors of numbers")}


def _column(data: Any, shape: tuple[int, ...], key: Any) -> Any:
    """A vector by the name of its field, (), or the place of its column in a matrix."""
    whole = np.asarray(data[() if isinstance(key, int) else key]).reshape(shape)
    return whole if not isinstance(key, int) else whole[key] if shape[0] < shape[1] else whole[:, key]


def of_arrays(path: Path, arrays: Arrays, attributes: Mapping[str, Attributes], kind: str) -> Contents:
    """Channels of the vectors among arrays by path; attributes are of arrays and of groups, "" the file."""
    stated = {name: _stated(each) for name, each in attributes.items()}
    loads, left_out = dict[str, Load](), list[Channel]()
    for name, array in sorted(arrays.items(), key=lambda each: each[0].endswith(")")):  # of matrices last
        group, _, last = name.rpartition("/")
        if array.load is None:
            left_out.append(unfit(last, array.unfit, group))
        elif array.shape and max(array.shape) > 1:
            loads[name] = partial(_unpacked, array.load, stated.get(name, {}))
        elif not array.shape and states_rate(last):
            stated.setdefault(group, {})[last] = float(array.load().item())
    units = {name: _unit(stated.get(name, {}), name) for name in loads}
    times = [name for name in loads if is_time(name.rpartition("/")[2])]
    clocks = {name: Stamps(name, loads[name], units[name], "s") for name in times}
    without = f"no vector of time and no sampling rate (variables: {names_in_short(arrays)})"
    start = str(stated.get("", {}).get("time_coverage_start", ""))  # of datasets, as CF has it
    signals = []
    for name in [name for name in loads if name not in clocks]:
        group, _, last = name.rpartition("/")
        parts = name.split("/")[:-1]
        folders = ["/".join(parts[:n]) for n in range(len(parts), -1, -1)]  # the next one first
        beside = ([t for t in times if t.rpartition("/")[0] == folder] for folder in folders)
        near = next(filter(None, beside), [])
        fit = [each for each in near if arrays[each].shape == arrays[name].shape]
        values = dict(ChainMap(*(stated.get(each, {}) for each in (name, *folders))))
        if len(fit) == 1:
            clock: Even | Stamps = clocks[fit[0]]
            begun = units[fit[0]].partition(" since ")[2]
            start = "" if begun.startswith("1970-01-01") else begun or start
        elif near:
            told = names_in_short(f"{time} {arrays[time].shape[0]}" for time in near)
            why = f"has {number_of(arrays[name].shape[0], 'sample')}, its time {told}"
            left_out.append(unfit(last, why, group))
            continue
        else:
            clock = stated_rate(path, values) or Even(np.nan, unknown=without)
        signals.append(Channel(last, units[name], loads[name], clock, group, also_stated(path, values)))
    return Contents([*signals, *left_out], kind, [], start)


def _unpacked(load: Load, stated: Mapping[str, float | str]) -> Floats:
    """A vector as doubles, unpacked by CF."""
    values = np.array(load(), float)
    for fill in (stated.get("_FillValue"), stated.get("missing_value")):
        if isinstance(fill, float):
            values[values == fill] = np.nan
    return values * float(stated.get("scale_factor", 1.0)) + float(stated.get("add_offset", 0.0))


def _unit(stated: Mapping[str, float | str], name: str) -> str:
    """Unit of an array by its attributes, else by its name."""
    found = next(filter(None, (stated.get(key) for key in UNITS)), "")
    return str(found) or split_unit(name.rpartition("/")[2].partition("(:")[0])[1]


def _stated(attributes: Attributes) -> dict[str, float | str]:
    """The attributes that are single numbers, or texts."""
    found: dict[str, float | str] = {}
    for name, value in attributes.items():
        array = np.asarray(value)
        if array.dtype.kind in "iuf" and array.size == 1:
            found[name] = float(array.item())
        elif array.dtype.kind in "SUO":
            found[name] = as_text(value)
    return found


def as_text(value: Any) -> str:
    """An attribute, or its first item, as text; "" for none."""
    value = np.asarray(value).reshape(-1)[0] if value is not None and np.size(value) else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
