"""MATLAB files: v4 to v7 through scipy, v7.3 (HDF5) through h5py; numeric arrays and structures of them."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatlabFunction, MatlabOpaque, matfile_version

from freerock.records.channels import Contents
from freerock.records.hdf5 import Array, arrays_in, as_text, of_arrays, vectors

FORMAT = "MAT"
AS_VECTORS = "save t = seconds(tt.Time) and x = tt.x as vectors"


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a MATLAB file.

    Channels are numeric vectors, columns of a matrix, named "name(:,2)", and fields of structures. Time is a
    vector called time, t and so on; else a scalar such as fs or dt states the sampling rate.
    """
    if h5py.is_hdf5(path):
        with h5py.File(path, locking=False) as file:
            yield of_arrays(path, *arrays_in(file), f"{FORMAT} v7.3")
        return
    version = "v5" if matfile_version(path)[0] else "v4"
    variables = {name: value for name, value in loadmat(path).items() if not name.startswith("__")}
    found = [_arrays(name, value) for name, value in variables.items()]
    arrays = {name: array for each in found for name, array in each.items()}
    yield of_arrays(path, arrays, {}, f"{FORMAT} {version}")


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
