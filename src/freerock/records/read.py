"""The door to record files: `READERS` names the module of each format. A new one begins best from `tdms`."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN, Contents, Named, by_name
from freerock.records.dataset import dataset

if TYPE_CHECKING:
    import xarray as xr

# Suffix: module of this room with FORMAT, its name, and contents(path), which yields `channels.Contents`.
READERS = {
    ".tdms": "tdms",
    ".lvm": "lvm",
    ".mat": "mat",
    **dict.fromkeys([".csv", ".tsv", ".txt"], "text"),
    **dict.fromkeys([".xlsx", ".xlsm"], "excel"),
    **dict.fromkeys([".h5", ".hdf5", ".nc"], "hdf5"),
}


def read_record(path: str | Path, channel: str | None = None) -> "xr.Dataset":
    """Read a record file.

    Parameters
    ----------
    path : path-like
        The file; its suffix gives the format.
    channel : str, optional
        Read only this channel, named "channel" or "group/channel"; by default all channels that are numbers,
        provided that they share one time base.

    Returns
    -------
    xarray.Dataset
        Over dimension time [s], from the file's own start offset (0 when it gives none): one variable per
        channel, with attribute units as the file states it ("" when it doesn't). Attributes: format,
        sampling_rate_hz and, where there is something to say: start_time (ISO 8601, with Z for UTC where the
        file states the zone), reading (what was found out about the file: delimiter, decimal comma, column of
        time), time_base (faults of the time stamps and how they were handled, see `timebase`).

    Raises
    ------
    FreerockError
        A missing, truncated, empty or unreadable file; an unknown format; a missing channel; several time
        bases; no sampling rate; time stamps that no even grid fits. Nothing else leaves this function.
    """
    path = Path(path)
    with _opened(path) as contents:
        return dataset(path, contents, channel or None)


def list_channels(path: str | Path) -> Named:
    """The channels of a record file, without reading their samples where the format allows it.

    Parameters
    ----------
    path : path-like
        The file; its suffix gives the format.

    Returns
    -------
    freerock.records.channels.Named
        Channel by the names that `read_record` accepts; if a channel can't be read, `clock` states why.

    Raises
    ------
    FreerockError
        As of `read_record`, as far as the samples need not be read.
    """
    path = Path(path)
    with _opened(path) as contents:
        return by_name(path, contents)


@contextmanager
def _opened(path: Path) -> Iterator[Contents]:
    """What the reader of a file's format finds in it, while the file is open."""
    if path.is_dir():
        raise FreerockError(path, "is a folder", "name the files in it")
    if not path.is_file():
        raise FreerockError(path, "no such file", "put it there, or correct its name")
    if path.suffix.lower() not in READERS:
        raise FreerockError(path, f"unknown format {path.suffix!r}", f"use one of {', '.join(READERS)}")
    if path.stat().st_size == 0:
        raise FreerockError(path, "the file is empty", COPY_AGAIN)
    reader = import_module(f"freerock.records.{READERS[path.suffix.lower()]}")
    try:
        with warnings.catch_warnings(action="ignore"), reader.contents(path) as contents:
            yield contents
    except FreerockError:
        raise
    except Exception as error:  # the libraries raise whatever damaged bytes lead them into
        what = f"not a readable {reader.FORMAT} file ({type(error).__name__}: {str(error)[:200]})"
        raise FreerockError(path, what, COPY_AGAIN) from error
