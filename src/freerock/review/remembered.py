"""What took long to make, kept in files by what it was made of: memory stays free, and the disk is cheap.

The files have no name: they go with the process, however it ends.
"""

import pickle
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from hashlib import sha256
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray


class OnDisk:
    """An array in a file, of which parts are read when they are requested."""

    def __init__(self, values: NDArray[Any]):
        self._file = TemporaryFile()  # noqa: SIM115 (as long as the array)
        self._dtype, self._shape = values.dtype, values.shape
        values.tofile(self._file)

    def __getitem__(self, part: slice) -> NDArray[Any]:
        return np.array(np.memmap(self._file, self._dtype, "r", shape=self._shape)[part])


class Remembered:
    """The latest of what was made.

    Parameters
    ----------
    most : int
        How many are kept.
    """

    def __init__(self, most: int):
        self._most = most
        self._kept: OrderedDict[Hashable, IO[bytes]] = OrderedDict()

    def get(self, of: Any, make: Callable[[], Any]) -> Any:
        """What was made of `of`, to the last bit; made now where it is not known. Each call gives its own."""
        key = content(of)
        if key in self._kept:
            self._kept.move_to_end(key)
            self._kept[key].seek(0)
            return pickle.load(self._kept[key])
        while len(self._kept) >= self._most:
            self._kept.popitem(last=False)[1].close()
        made = make()
        with suppress(OSError):  # no space: it is made again next time
            file = TemporaryFile()  # noqa: SIM115 (as long as it is remembered)
            pickle.dump(made, file)
            file.flush()
            self._kept[key] = file
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
