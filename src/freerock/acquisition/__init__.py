"""Record files: one reader per format behind `read_record`."""

from importlib import import_module
from pathlib import Path

from freerock.errors import FreerockError

READERS = {".tdms": "tdms"}  # suffix: module of this package with a function read(path, channel)


def read_record(path, channel: str | None = None):
    """Read a record file.

    Parameters
    ----------
    path : path-like
        The file; its suffix tells the format.
    channel : str, optional
        Read only this channel, named "channel" or "group/channel"; all channels that are numbers by default.

    Returns
    -------
    xarray.Dataset
        Over dimension time [s], from the file's own start offset (0 when it gives none): one variable per
        channel, with attribute units as the file states it ("" when it doesn't). Attributes: format,
        sampling_rate_hz and, where known, start_time (ISO 8601, UTC).

    Raises
    ------
    FreerockError
        A missing, truncated, empty or unreadable file; an unknown format; a missing channel; no
        sampling rate.
    """
    path = Path(path)
    if path.suffix.lower() not in READERS:
        raise FreerockError(path, f"unknown format {path.suffix!r}", f"use one of {', '.join(READERS)}")
    if not path.is_file():
        raise FreerockError(
            path, "no such file", "put it there, or correct the file column of the campaign's CSV"
        )
    if path.stat().st_size == 0:
        raise FreerockError(path, "the file is empty", "copy it again from the acquisition computer")
    reader = import_module(f"freerock.acquisition.{READERS[path.suffix.lower()]}")
    return reader.read(path, channel or None)
