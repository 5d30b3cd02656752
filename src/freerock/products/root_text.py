"""A text among the attributes of a product, read without what reads its data."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from freerock.errors import FreerockError

MISSING = "there is no such file", "run snakemake to make it"
DAMAGED = "delete the file and run snakemake again"


@contextmanager
def errors_of(path: str | Path) -> Iterator[None]:
    """Raise a `FreerockError` with a remedy where a file can't be read."""
    if not Path(path).is_file():
        raise FreerockError(path, *MISSING)
    try:
        yield
    except (OSError, ValueError, RuntimeError, KeyError, AttributeError) as error:
        raise FreerockError(path, f"is not a readable netCDF file ({error})", DAMAGED) from error


def root_text(path: str | Path, name: str, usual: str | None = None) -> str:
    """A text among the root attributes of a file; where there is none, the usual one.

    Raises
    ------
    FreerockError
        No such file, or damaged: without the text too, where none is usual.
    """
    import h5py  # netCDF looks through all groups when it opens a file

    with errors_of(path), h5py.File(path) as file:
        value = np.asarray(file.attrs[name] if usual is None else file.attrs.get(name, usual)).item()
        return value.decode() if isinstance(value, bytes) else str(value)
