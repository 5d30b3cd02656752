"""What took long to make, kept by what it was made of."""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any

import numpy as np


class Remembered:
    """The latest of what was made.

    Parameters
    ----------
    most : int
        How many are kept.
    """

    def __init__(self, most: int):
        self._most = most
        self._kept: OrderedDict[Hashable, Any] = OrderedDict()

    def get(self, of: Any, make: Callable[[], Any]) -> Any:
        """What was made of `of`, to the last bit; made now where it is not known."""
        key = content(of)
        if key not in self._kept:
            self._kept[key] = make()
        self._kept.move_to_end(key)
        while len(self._kept) > self._most:
            self._kept.popitem(last=False)
        return self._kept[key]


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
