"""What took long to make, kept in files by what it was made of: memory stays free, and the disk is cheap."""

import pickle
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from dataclasses import fields, is_dataclass
from hashlib import sha256
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray


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
    """The latest of what was made, in a folder that goes when the process ends.

    Parameters
    ----------
    most : int
        How many are kept.
    """

    def __init__(self, most: int):
        self._most, self._numbers = most, count()
        self._folder = Path(mkdtemp(prefix="freerock-review-"))
        finalize(self, rmtree, self._folder, ignore_errors=True)
        self._kept: OrderedDict[Hashable, Path] = OrderedDict()

    def get(self, of: Any, make: Callable[[], Any]) -> Any:
        """What was made of `of`, to the last bit; made now where it is not known. Each call gives its own."""
        key = content(of)
        if key in self._kept:
            self._kept.move_to_end(key)
            with open(self._kept[key], "rb") as file:
                return pickle.load(file)
        while len(self._kept) >= self._most:
            self._kept.popitem(last=False)[1].unlink()
        made, path = make(), self._folder / str(next(self._numbers))
        try:
            with open(path, "wb") as file:
                pickle.dump(made, file, pickle.HIGHEST_PROTOCOL)
            self._kept[key] = path
        except OSError:  # no space: it is made again next time
            path.unlink(missing_ok=True)
        return made


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
