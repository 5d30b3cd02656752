"""NI TDMS records, through npTDMS: channels with NI's waveform properties, or beside one of time stamps."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from nptdms import TdmsChannel, TdmsFile
from nptdms.log import log_manager

from freerock import bounds
from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN, Channel, Contents, Even, Stamps
from freerock.records.headings import is_time

FORMAT = "TDMS"
NUMBERS, DATE = ("i", "u", "f"), "M"  # kinds of samples as NumPy names them
UNSET = np.datetime64("1905-01-01")  # LabVIEW counts from 1904

log_manager.set_level("ERROR")  # what npTDMS warns of is refused below, in one line


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a TDMS file.

    A file is truncated when its last segment is incomplete, when a channel holds fewer samples than its
    wf_samples, or when channels of one group and one sampling rate differ in length. (wf_samples may be
    smaller than the channel is long: streaming acquisition writes the length of its first chunk.)
    """
    with open(path, "rb") as stream, TdmsFile.open(stream) as file:
        if file.file_status.incomplete_final_segment:
            raise FreerockError(path, "the file is truncated: its last segment is incomplete", COPY_AGAIN)
        groups: dict[str, list[TdmsChannel]] = {group.name: group.channels() for group in file.groups()}
        found = {(group, c.name): c for group, members in groups.items() for c in members}
        channels = [
            Channel(c.name, _unit(c), (group, c.name), clock, group, also)
            for group, members in groups.items()
            for c, clock, also in _clocks(members)
        ]
        rates = {c.column: c.clock.step_s for c in channels if isinstance(c.clock, Even)}

        def read(columns: Sequence[tuple[str, str]]) -> dict[tuple[str, str], Floats]:
            return {column: _values(path, found[column], rates.get(column, 1.0)) for column in columns}

        unsound = [c.name for c in found.values() if not _starts(c)]
        notes = [f"wf_start_offset of {name} is no number and is taken for 0" for name in unsound]
        yield Contents(channels, read, FORMAT, notes, _start_time(found.values()))


def _unit(channel: TdmsChannel) -> str:
    return str(channel.properties.get("unit_string", ""))


def _clocks(
    members: Sequence[TdmsChannel],
) -> Iterator[tuple[TdmsChannel, Even | Stamps | str, tuple[Stamps, ...]]]:
    """Each channel of a group with its clock, or why it can't be read, and the stamps beside it."""
    stamps = next((c for c in members if is_time(c.name) and _kind(c) in (*NUMBERS, DATE)), None)
    beside = Stamps("", "", "")
    if stamps is not None:
        unit = "s" if _kind(stamps) == DATE else _unit(stamps)
        beside = Stamps(stamps.name, (stamps.group_name, stamps.name), unit)
    for c in members:
        if c is stamps and len(members) > 1:
            continue
        step = c.properties.get("wf_increment")
        if not len(c):
            yield c, "is empty", ()
        elif _kind(c) not in NUMBERS:
            yield c, "holds no real numbers", ()
        elif step is None and stamps not in (None, c):
            yield c, beside, ()
        else:
            start = float(c.properties.get("wf_start_offset", 0.0)) if _starts(c) else 0.0
            alike = stamps not in (None, c) and len(stamps) == len(c)
            yield c, Even(step, start), (beside,) if alike else ()


def _starts(channel: TdmsChannel) -> bool:
    """Whether the start offset of a channel is a number, or missing."""
    start = channel.properties.get("wf_start_offset", 0.0)
    return isinstance(start, int | float) and bool(np.isfinite(start))


def _kind(channel: TdmsChannel) -> str:
    """Kind of a channel's samples as NumPy names it; "" where it has none."""
    return channel.dtype.kind if len(channel) and channel.dtype is not None else ""


def _values(path: Path, channel: TdmsChannel, step: object) -> Floats:
    """All samples as doubles, chunk by chunk; dates as seconds since the first."""
    stated = channel.properties.get("wf_samples", 0)
    if len(channel) < stated:
        what = f"the file is truncated: channel {channel.name!r} holds {len(channel)} of {stated} samples"
        raise FreerockError(path, what, COPY_AGAIN)
    if not (isinstance(step, int | float) and bounds.SHORTEST_STEP_S < step < bounds.LONGEST_STEP_S):
        given = "absent" if step is None else step
        what = f"channel {channel.name!r} gives no sampling rate (wf_increment is {given})"
        remedy = "log it as a waveform, or set its property wf_increment to the sampling interval in seconds"
        raise FreerockError(path, what, remedy)
    values = np.empty(len(channel))
    done, origin = 0, None
    for chunk in channel.data_chunks():
        part = chunk[:]
        if part.dtype.kind == DATE:
            origin = part[0] if origin is None and part.size else origin
            part = (part - origin) / np.timedelta64(1, "s")
        values[done : done + len(part)] = part
        done += len(part)
    if done < len(values):
        what = f"the file is truncated: channel {channel.name!r} holds {done} of {len(values)} samples"
        raise FreerockError(path, what, COPY_AGAIN)
    return values


def _start_time(channels: Iterable[TdmsChannel]) -> str:
    starts = [c.properties["wf_start_time"] for c in channels if "wf_start_time" in c.properties]
    known = [start for start in starts if start > UNSET]
    return f"{np.datetime_as_string(known[0], 'ms')}Z" if known else ""
