"""What took long to make, kept in files by what it was made of: memory stays free, and the disk is cheap."""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from copy import copy, deepcopy
from dataclasses import fields, is_dataclass
from hashlib import sha256
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any, NamedTuple
from weakref import finalize

import numpy as np
import xarray as xr
from numpy.typing import NDArray

LARGE_BYTES = 1 << 13  # from which an array is kept in a file


class OnDisk:
    """An array in a file, of which parts are read when they are requested."""

    def __init__(self, values: NDArray[Any]):
        folder = Path(mkdtemp(prefix="freerock-review-"))
        finalize(self, rmtree, folder, ignore_errors=True)
        self._path = folder / "values.npy"
        np.save(self._path, values)

    def __getitem__(self, part: slice) -> NDArray[Any]:
        return np.array(np.load(self._path, mmap_mode="r")[part])


class Remembered:
    """The latest of what was made: what is large of it in a folder that goes when the process ends.

    Parameters
    ----------
    most : int
        How many are kept.
    """

    def __init__(self, most: int):
        self._most, self._numbers = most, count()
        self._folder = Path(mkdtemp(prefix="freerock-review-"))
        finalize(self, rmtree, self._folder, ignore_errors=True)
        self._kept: OrderedDict[Hashable, tuple[Path, Any]] = OrderedDict()

    def get(self, of: Any, make: Callable[[], Any]) -> Any:
        """What was made of `of`, to the last bit; made now where it is not known. Each call gives its own."""
        key = content(of)
        if key in self._kept:
            self._kept.move_to_end(key)
            return _read(self._kept[key][1])
        while len(self._kept) >= self._most:
            rmtree(self._kept.popitem(last=False)[1][0], ignore_errors=True)
        made, folder = make(), self._folder / str(next(self._numbers))
        try:
            folder.mkdir()
            self._kept[key] = folder, _written(made, folder)
        except OSError:  # no space: it is made again next time
            rmtree(folder, ignore_errors=True)
        return made


class _Array(NamedTuple):
    """An array that is kept in a file."""

    path: Path


class _Dataset(NamedTuple):
    """Variables of a dataset as (dimensions, values, attributes), coordinates likewise; its attributes."""

    variables: dict[Hashable, Any]
    coordinates: dict[Hashable, Any]
    attributes: dict[Hashable, Any]


def _written(value: Any, folder: Path) -> Any:
    """A value whose large arrays are written into a folder; the rest is a copy."""
    if isinstance(value, np.ndarray) and value.nbytes >= LARGE_BYTES and not value.dtype.hasobject:
        path = folder / f"{len(list(folder.iterdir()))}.npy"
        np.save(path, value)
        return _Array(path)
    if isinstance(value, xr.Dataset):
        data, beside = (
            {name: (each.dims, each.values, dict(each.attrs)) for name, each in group.items()}
            for group in (value.data_vars, value.coords)
        )
        return _Dataset(_written(data, folder), _written(beside, folder), dict(value.attrs))
    return _each(value, lambda part: _written(part, folder))


def _read(value: Any) -> Any:
    """What was written, anew."""
    if isinstance(value, _Array):
        return np.load(value.path)
    if isinstance(value, _Dataset):
        return xr.Dataset(_read(value.variables), _read(value.coordinates), dict(value.attributes))
    return _each(value, _read)


def _each(value: Any, change: Callable[[Any], Any]) -> Any:
    """A copy of a value with each of its parts changed."""
    if is_dataclass(value) and not isinstance(value, type):
        made = copy(value)
        for field in fields(value):
            object.__setattr__(made, field.name, change(getattr(value, field.name)))
        return made
    if isinstance(value, dict):
        return {key: change(each) for key, each in value.items()}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*map(change, value))
    if isinstance(value, list | tuple):
        return type(value)(map(change, value))
    return deepcopy(value)


def content(value: Any) -> Hashable:
    """What a value holds, as a key: equal for equal numbers, wherever they stand."""
    if is_dataclass(value):
        return type(value).__name__, *(content(getattr(value, field.name)) for field in fields(value))
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, sha256(value.tobytes()).hexdigest()
    if isinstance(value, Mapping):
        return tuple((key, content(each)) for key, each in sorted(value.items()))
    if isinstance(value, list | tuple):
        return tuple(map(content, value))
    return value if isinstance(value, Hashable) else repr(value)
