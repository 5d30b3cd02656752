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
from types import FunctionType
from typing import IO, Any
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


class _Writer(pickle.Pickler):
    """Writes anything but functions, which stay in memory: one that was defined in another has no name."""

    def __init__(self, file: IO[bytes]):
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self.functions: list[FunctionType] = []

    def persistent_id(self, value: Any) -> int | None:
        """Number of a function among those that stay."""
        if not isinstance(value, FunctionType):
            return None
        self.functions.append(value)
        return len(self.functions) - 1


class _Reader(pickle.Unpickler):
    """Reads what `_Writer` wrote."""

    def __init__(self, file: IO[bytes], functions: list[FunctionType]):
        super().__init__(file)
        self._functions = functions

    def persistent_load(self, number: int) -> FunctionType:
        """The function of a number."""
        return self._functions[number]


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
        self._kept: OrderedDict[Hashable, tuple[Path, list[FunctionType]]] = OrderedDict()

    def get(self, of: Any, make: Callable[[], Any]) -> Any:
        """What was made of `of`, to the last bit; made now where it is not known. Each call gives its own."""
        key = content(of)
        if key in self._kept:
            self._kept.move_to_end(key)
            path, functions = self._kept[key]
            with open(path, "rb") as file:
                return _Reader(file, functions).load()
        while len(self._kept) >= self._most:
            self._kept.popitem(last=False)[1][0].unlink()
        made, path = make(), self._folder / str(next(self._numbers))
        try:
            with open(path, "wb") as file:
                writer = _Writer(file)
                writer.dump(made)
            self._kept[key] = path, writer.functions
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
