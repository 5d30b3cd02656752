"""How the models' inner loops are compiled.

What shapes machine code is in the names of its files in the cache: the options and all else in this room,
the file of the function, compiler and processor. Numba itself looks at time and size of the function's file.
"""

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import llvmlite.binding
import numba
from numba import njit, typeof

from freerock.errors import FreerockError

if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
    raise FreerockError(
        "NUMBA_DISABLE_JIT", "is set: nothing is compiled, and a fit would take hours", "unset it"
    )
SHAPING = {"NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_OPT", "NUMBA_SLP_VECTORIZE", "NUMBA_LOOP_VECTORIZE"}
Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(**options: Any) -> Callable[[Function], Function]:
    """Compile with a cache on disk, or without one where no folder for it can be written."""
    usual: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
    options = usual | options

    def decorate(function: Function) -> Function:
        made: Function
        function.__qualname__ += f"_{identity(function.__code__.co_filename)}"  # names the files of the cache
        try:
            made = njit(cache=True, **options)(function)
        except RuntimeError:
            made = njit(**options)(function)
        return made

    return decorate


@cache
def identity(file: str) -> str:
    """Checksum of what shapes the machine code of a file's functions, in 16 hexadecimal digits."""
    options = sorted(f"{name}={value}" for name, value in os.environ.items() if name in SHAPING)
    features = sorted(llvmlite.binding.get_host_cpu_features().items())
    processor = [llvmlite.binding.get_host_cpu_name(), str(features)]
    found = hashlib.sha256(
        "\n".join([numba.__version__, llvmlite.__version__, *processor, *options]).encode()
    )
    for path in (*sorted(Path(__file__).parent.glob("*.py")), Path(file)):
        found.update(f"\n{path.name} {hashlib.sha256(path.read_bytes()).hexdigest()}".encode())
    return found.hexdigest()[:16]


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
