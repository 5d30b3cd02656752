"""How the models' inner loops are compiled."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from numba import njit, typeof

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(**options: Any) -> Callable[[Function], Function]:
    """Compile with a cache on disk, or without one where no folder for it can be written."""
    usual: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
    options = usual | options

    def decorate(function: Function) -> Function:
        made: Function
        try:
            made = njit(cache=True, **options)(function)
        except RuntimeError:
            made = njit(**options)(function)
        return made

    return decorate


_loaded = set[Any]()


def run(dispatcher: Any, *arguments: Any) -> Any:
    """What a compiled function gives; of a damaged cache on disk the files are deleted when it is loaded."""
    if dispatcher not in _loaded:
        try:
            dispatcher.compile(tuple(typeof(argument) for argument in arguments))
        except Exception:
            # a damaged file in the cache fails until it is deleted
            stem = Path(dispatcher.py_func.__code__.co_filename).stem
            for path in Path(dispatcher.stats.cache_path or "").glob(f"{stem}.*.nb[ic]"):
                path.unlink(missing_ok=True)
        _loaded.add(dispatcher)
    return dispatcher(*arguments)
