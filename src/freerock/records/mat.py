"""MATLAB files: v4 to v7 through scipy, v7.3 (HDF5) through h5py; plain numeric arrays only.

Objects, function handles, structures and cells are passed over.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat, whosmat
from scipy.io.matlab import matfile_version

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import (
    SAMPLES_AT_ONCE,
    Channel,
    Contents,
    Even,
    SampleColumn,
    Stamps,
)
from freerock.records.hdf5 import numeric_arrays
from freerock.records.headings import also_stated, is_time, rises, split_unit, stated_rate, states_rate

FORMAT = "MAT"
NUMERIC = ("double", "single", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64")
PLAIN = "save(…) the time and the signals as numeric vectors"


Arrays = Mapping[str, NDArray[Any] | h5py.Dataset]
Load = Callable[[Sequence[str]], Arrays]
Place = tuple[str, int | None]  # a vector's name, or a matrix's and the number of its column


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a MATLAB file.

    Channels are numeric vectors, or the columns of a matrix, named "name(:,2)". Time is a vector called time,
    t and so on, or the first column of the only matrix where it rises steadily; else a scalar such as fs or
    dt states the sampling rate.
    """
    if h5py.is_hdf5(path):
        with h5py.File(path, locking=False) as file:
            arrays = {name: found for name, found in numeric_arrays(file).items() if "/" not in name}
            shapes = {name: found.shape[::-1] for name, found in arrays.items()}
            yield _contents(path, shapes, lambda names: {n: arrays[n] for n in names}, "v7.3")
    else:
        shapes = {name: shape for name, shape, kind in whosmat(path) if kind in NUMERIC}
        version = "v5" if matfile_version(path)[0] else "v4"
        yield _contents(path, shapes, lambda names: loadmat(path, variable_names=names), version)


def _contents(path: Path, all_shapes: Mapping[str, tuple[int, ...]], load: Load, version: str) -> Contents:
    """Channels among arrays by name: vectors and matrices. Scalars may state the sampling rate."""
    shapes = {name: tuple(map(int, shape)) for name, shape in all_shapes.items() if 0 not in shape}
    scalars = [name for name, shape in shapes.items() if prod(shape) == 1 and states_rate({name: 1.0})]
    vectors = [name for name, shape in shapes.items() if 1 == min(shape) < max(shape)]
    matrices = [name for name, shape in shapes.items() if len(shape) == 2 and 1 < min(shape) < max(shape)]
    times = [name for name in vectors if is_time(name)]
    notes: list[str] = []
    clock: Even | Stamps | None
    scalar = {name: float(np.asarray(array).flat[0]) for name, array in _loaded(load, scalars).items()}
    if times:
        clock = Stamps(times[0], (times[0], None), split_unit(times[0])[1])
    else:
        clock = stated_rate(path, scalar)
    columns: list[Place] = [(name, i) for name in matrices for i in range(min(shapes[name]))]
    channels: list[Place] = [*((name, None) for name in vectors if name not in times), *columns]
    if clock is None and len(matrices) == 1 and not vectors:
        first = columns[0]
        if rises(_column(_loaded(load, matrices), first)[:SAMPLES_AT_ONCE]):
            clock = Stamps(_title(first), first, "")
            channels.remove(first)
            notes.append(f"{_title(first)} rises steadily and is taken for time")
    if not channels:
        raise FreerockError(path, "no numeric vector that could be a signal", PLAIN)
    if clock is None:
        what = f"no vector of time and no sampling rate (variables: {', '.join(shapes)})"
        raise FreerockError(path, what, "save the time as t, or the sampling rate in Hz as fs")

    def read(wanted: Sequence[Place]) -> dict[Place, SampleColumn]:
        arrays = _loaded(load, list(dict.fromkeys(name for name, _ in wanted)))
        for name, array in arrays.items():
            if np.iscomplexobj(array):
                raise FreerockError(path, f"variable {name!r} holds no real numbers", "name the channel")
        return {column: _column(arrays, column) for column in wanted}

    also = also_stated(path, scalar)
    made = [Channel(_title(column), "", column, clock, also=also) for column in channels]
    return Contents(made, read, f"{FORMAT} {version}", notes)


def _loaded(load: Load, names: Sequence[str]) -> Arrays:
    loaded = load(names) if names else {}
    return {name: loaded[name] for name in names}


@dataclass(frozen=True)
class _Stored:
    """A vector, or a column of a matrix along its longer side, in an HDF5 file."""

    array: h5py.Dataset
    column: int

    def __len__(self) -> int:
        return int(max(self.array.shape))

    def __getitem__(self, part: slice) -> Floats:
        longest = self.array.shape.index(len(self))
        where = [part if axis == longest else self.column for axis in range(self.array.ndim)]
        return np.asarray(self.array[tuple(where)], float)


def _column(arrays: Arrays, column: Place) -> SampleColumn:
    """A vector, or a column of a matrix along its longer side, as doubles."""
    name, i = column
    array = arrays[name]
    if isinstance(array, h5py.Dataset):
        return _Stored(array, i or 0)
    if i is None:
        return array.ravel().astype(float, copy=False)
    return (array[:, i] if array.shape[0] >= array.shape[1] else array[i]).astype(float)


def _title(column: Place) -> str:
    name, i = column
    return name if i is None else f"{name}(:,{i + 1})"
