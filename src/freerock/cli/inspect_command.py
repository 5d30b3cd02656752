"""The content of a record file, channel by channel.

example:
  freerock inspect raw/palermo_virtual/config2_marble.tdms

Formats: docs/records.md. The record file is only read.
"""

import math
import shutil
from argparse import Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from freerock.arrays import Floats
from freerock.config.values import Invalid, check_inside
from freerock.errors import FreerockError, attempt, printable
from freerock.figures.looks import extremes
from freerock.files import sha256
from freerock.records.read import list_channels, read_record

if TYPE_CHECKING:
    import xarray as xr


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("file", metavar="FILE", help="a record file")
    add("--no-plot", action="store_true", help="print only")


def run(chosen: Namespace) -> None:
    """Print what is in a record file, and draw it."""
    look = look_into(chosen.file)
    check_readable(look)
    print(look_text(look))
    if not chosen.no_plot:
        picture = Path("results/inspect") / f"{look.path.name}.png"
        draw_looks([look], picture)
        print(f"\nwritten: {picture}")


@dataclass(frozen=True)
class ChannelLook:
    """A channel in short.

    Parameters
    ----------
    name, units : str
        As the file states them.
    n_samples, n_missing : int
        Samples, and those of them that are no number.
    start_s, rate_hz : float
        First instant [s] and sampling rate [Hz].
    low, high : float
        Extremes [units], NaN without any number.
    time_s, values : ndarray, shape (n_drawn,)
        Samples that show the course: the extremes of each of some hundreds of stretches.
    remarks : tuple of str
        What the reader found out by itself.
    """

    name: str
    units: str
    n_samples: int
    n_missing: int
    start_s: float
    rate_hz: float
    low: float
    high: float
    time_s: Floats
    values: Floats
    remarks: tuple[str, ...]

    @property
    def duration_s(self) -> float:
        """Number of samples over the sampling rate [s]."""
        return self.n_samples / self.rate_hz


@dataclass(frozen=True)
class RecordLook:
    """A record file: its name, checksum, format and channels, and by name why others can't be read.

    `damaged` names those of the others that hold numbers.
    """

    path: Path
    sha256: str
    n_bytes: int
    format: str
    channels: Sequence[ChannelLook]
    faults: Mapping[str, FreerockError]
    damaged: Sequence[str]


def look_into(path: str | Path, time_unit: str = "", rate_hz: float | None = None) -> RecordLook:
    """Read every channel of a record file, each for itself.

    Parameters
    ----------
    path : path-like
    time_unit, rate_hz : str, float, optional
        Unit of time and sampling rate [Hz] where the file states none.

    Raises
    ------
    FreerockError
        The file can't be read at all, see `freerock.records.read.read_record`.
    """
    path, kind, channels, faults = Path(path), "", list[ChannelLook](), dict[str, FreerockError]()
    listed = list_channels(path)
    for name in listed:
        record = attempt(partial(read_record, path, name, time_unit=time_unit, rate_hz=rate_hz))
        if isinstance(record, FreerockError):
            faults[name] = record
        else:
            kind = record.attrs["format"]
            channels.append(_in_short(name, record))
    damaged = [name for name in faults if not listed[name].fault]
    return RecordLook(path, sha256(path), path.stat().st_size, kind, channels, faults, damaged)


def look_to_take(path: Path, time_unit: str = "", rate_hz: float | None = None) -> RecordLook:
    """A record file that a campaign may take, whose unit of time and rate may be known, as in `look_into`.

    Raises
    ------
    FreerockError
        As `look_into`; its name can't be one in a raw folder, or none of its channels can be read.
    """
    try:
        check_inside(path.name)
    except Invalid as error:
        raise FreerockError(path, error.what, error.remedy) from None
    look = look_into(path, time_unit, rate_hz)
    check_readable(look)
    return look


def check_readable(look: RecordLook) -> None:
    """Refuse a record file none of whose channels can be read, by the first that holds numbers."""
    if not look.channels:
        name = next(iter([*look.damaged, *look.faults]))
        error = look.faults[name]
        raise FreerockError(f"{look.path}: {name}", error.what, error.remedy)


def looks_to_take(
    paths: Iterable[str | Path], time_unit: str = "", rate_hz: float | None = None
) -> tuple[list[RecordLook], list[FreerockError]]:
    """What is in each of some files, read as by `look_into`, and why others can't be taken."""
    found = [attempt(look_to_take, Path(path), time_unit, rate_hz) for path in paths]
    refused = [each for each in found if isinstance(each, FreerockError)]
    return [each for each in found if isinstance(each, RecordLook)], refused


def take(look: RecordLook, copy: Path) -> None:
    """Copy a record file; refused where it is no longer as it was looked into."""
    shutil.copyfile(look.path, copy)
    if sha256(copy) != look.sha256:
        raise FreerockError(look.path, "changed while it was copied", "copy it when it is complete")


def _in_short(name: str, record: "xr.Dataset") -> ChannelLook:
    """The one channel of a dataset, in short."""
    (signal,), times = record.data_vars.values(), record["time"].values
    values = signal.values
    known, drawn = values[np.isfinite(values)], extremes(values)
    above, *told = (str(record.attrs.get(key, "")) for key in ("above", "reading", "time_base"))
    return ChannelLook(
        name,
        str(signal.attrs["units"]),
        n_samples=values.size,
        n_missing=values.size - known.size,
        start_s=float(times[0]),
        rate_hz=float(record.attrs["sampling_rate_hz"]),
        low=float(known.min()) if known.size else math.nan,
        high=float(known.max()) if known.size else math.nan,
        time_s=times[drawn],
        values=values[drawn],
        remarks=tuple(filter(None, [above, *"; ".join(told).split("; ")])),
    )


def look_text(look: RecordLook) -> str:
    """A record as printed: the file, a line per channel, and what the reader found out."""
    head = f"{look.path}: {look.format}, {look.n_bytes} bytes"
    lines = [head, f"sha256 {look.sha256}", ""]
    rows = [("channel", "unit", "rate", "duration", "from", "to", "missing")]
    for channel in look.channels:
        rate, duration = f"{channel.rate_hz:g} Hz", f"{channel.duration_s:.3f} s"
        low, high = (f"{bound:.6g}" for bound in (channel.low, channel.high))
        name, unit, missing = " ".join(channel.name.split()), channel.units or "–", str(channel.n_missing)
        rows.append((name, unit, rate, duration, low, high, missing))
    lines += aligned(rows)
    lines += [f"{name}: {error.what}; {error.remedy}" for name, error in look.faults.items()]
    remarks = dict.fromkeys(text for channel in look.channels for text in channel.remarks)
    return printable("\n".join([*lines, *remarks]))


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of text as lines with columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def draw_looks(looks: Iterable[RecordLook], path: Path) -> None:
    """Draw the channels of some records over time, as PNG."""
    from freerock.figures.quick_look import draw

    panels = [
        (look.path.name, f"{channel.name} / {channel.units or '?'}", channel.time_s, channel.values)
        for look in looks
        for channel in look.channels
    ]
    draw(panels, path)
