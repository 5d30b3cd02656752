"""How the models' inner loops are compiled.

What shapes machine code is in the names of its files in the cache: the options and all else in this room,
the file of the function, compiler and processor. Numba itself looks at time and size of the function's file,
and never at what its own files hold: beside them lies their checksum.
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import llvmlite.binding
import numba
from numba import njit
from numba.core.caching import FunctionCache
from numba.core.runtime.nrt import rtsys

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
        made: Any
        function.__qualname__ += f"_{identity(function.__code__.co_filename)}"  # names the files of the cache
        made = njit(**options)(function)
        with suppress(RuntimeError):
            made._cache = _Cache(function)
            made.compile = _Sound(made)
        return made  # type: ignore[no-any-return]

    return decorate


class _Cache(FunctionCache):
    """That of numba, but a load prepares nothing that only compiling needs, which takes 0.2 s of a job."""

    def load_overload(self, signature: Any, context: Any) -> Any:
        rtsys.initialize(context)  # what compiled code allocates memory with
        with self._guard_against_spurious_io_errors():
            return self._load_overload(signature, context)


class _Sound:
    """Compiles a function for types of arguments; loads it only from files that are as they were written."""

    def __init__(self, dispatcher: Any) -> None:
        self.compile, self.misses = dispatcher.compile, lambda: sum(dispatcher.stats.cache_misses.values())
        function = dispatcher.py_func
        self.stem = f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}"
        self.checksum = Path(dispatcher.stats.cache_path, f"{self.stem}.sha256")
        self.seen = False

    def __call__(self, signature: Any) -> Any:
        if not self.seen:
            sound = False
            with suppress(OSError):
                sound = self.checksum.read_bytes() == self.found()
            with suppress(OSError):
                for path in () if sound else (self.checksum, *self.files()):
                    path.unlink(missing_ok=True)
        self.seen, before = True, self.misses()
        made = self.compile(signature)
        if self.misses() > before:
            with suppress(OSError):  # the cache is not written either
                partial = self.checksum.with_suffix(f".{os.getpid()}")
                partial.write_bytes(self.found())
                partial.replace(self.checksum)
        return made

    def files(self) -> list[Path]:
        """What the cache holds of the function."""
        return sorted(self.checksum.parent.glob(f"{self.stem}-*.nb[ic]"))

    def found(self) -> bytes:
        """Checksum of these files and of their names."""
        held = (f"{path.name} {hashlib.sha256(path.read_bytes()).hexdigest()}" for path in self.files())
        return hashlib.sha256("\n".join(held).encode()).hexdigest().encode()


@cache
def identity(file: str) -> str:
    """Checksum of what shapes the machine code of a file's functions, in 16 hexadecimal digits."""
    options = sorted(f"{name}={value}" for name, value in os.environ.items() if name in SHAPING)
    features = sorted(llvmlite.binding.get_host_cpu_features().items())
    processor = [llvmlite.binding.get_host_cpu_name(), str(features)]
    found = hashlib.sha256(
        "\n".join([numba.__version__, llvmlite.__version__, *processor, *options]).encode()
    )
    room = (path for path in Path(__file__).parent.iterdir() if path.suffix in (".py", ".csv"))
    for path in (*sorted(room), Path(file)):
        found.update(f"\n{path.name} {hashlib.sha256(path.read_bytes()).hexdigest()}".encode())
    return found.hexdigest()[:16]
