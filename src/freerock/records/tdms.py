"""NI TDMS records, through npTDMS: channels with NI's waveform properties, or beside one of time stamps."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from nptdms import TdmsChannel, TdmsFile
from nptdms.log import log_manager
from nptdms.reader import TdmsReader

from freerock import bounds
from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN, Channel, Contents, Even, Stamps
from freerock.records.headings import KEY, is_time, split_unit

FORMAT = "TDMS"
NUMBERS, DATE = ("i", "u", "f"), "M"  # kinds of samples as NumPy names them
UNSET = np.datetime64("1905-01-01")  # LabVIEW counts from 1904

log_manager.set_level("ERROR")  # what npTDMS warns of is refused below, in one line


class _Increments(TdmsReader):  # type: ignore[misc]
    """Every wf_increment that the segments give a channel: npTDMS keeps the last."""

    def __init__(self, stream: Any) -> None:
        self.found: dict[str, list[float]] = defaultdict(list)
        super().__init__(stream)

    def _update_object_properties(self, segment_properties: Mapping[str, Any] | None) -> None:
        for path, properties in (segment_properties or {}).items():
            self.found[path] += [value for name, value in properties if name == "wf_increment"]
        super()._update_object_properties(segment_properties)


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a TDMS file.

    A file is truncated when its last segment is incomplete, when a channel holds fewer samples than its
    wf_samples, or when channels of one group and one sampling rate differ in length. (wf_samples may be
    smaller than the channel is long: streaming acquisition writes the length of its first chunk.)
    """
    with open(path, "rb") as stream:
        segments = _Increments(stream)
        segments.read_metadata()
        stream.seek(0)
        with TdmsFile.open(stream) as file:
            if file.file_status.incomplete_final_segment:
                raise FreerockError(path, "the file is truncated: its last segment is incomplete", COPY_AGAIN)
            groups: dict[str, list[TdmsChannel]] = {group.name: group.channels() for group in file.groups()}
            found = {(group, c.name): c for group, members in groups.items() for c in members}
            channels = [
                Channel(c.name, _unit(c), (group, c.name), clock, group, also)
                for group, members in groups.items()
                for c, clock, also in _clocks(members, segments.found)
            ]

            def read(columns: Sequence[tuple[str, str]]) -> dict[tuple[str, str], Floats]:
                return {column: _values(path, found[column]) for column in columns}

            unsound = [c.name for c in found.values() if not _starts(c)]
            notes = [f"wf_start_offset of {name} is no number and is taken for 0" for name in unsound]
            yield Contents(
                channels,
                read,
                FORMAT,
                notes,
                next(filter(None, (_started(c.properties.get("wf_start_time")) for c in found.values())), ""),
            )


def _unit(channel: TdmsChannel) -> str:
    return str(channel.properties.get("unit_string", "")) or split_unit(channel.name)[1]


def _clocks(
    members: Sequence[TdmsChannel], increments: Mapping[str, Sequence[float]]
) -> Iterator[tuple[TdmsChannel, Even | Stamps | str, tuple[Stamps, ...]]]:
    """Each channel of a group with its clock, or why it can't be read, and the stamps beside it."""
    stamps = next((c for c in members if is_time(c.name) and _kind(c) in (*NUMBERS, DATE)), None)
    beside = Stamps("", "", "")
    if stamps is not None:
        unit = "s" if _kind(stamps) == DATE else _unit(stamps)
        beside = Stamps(stamps.name, (stamps.group_name, stamps.name), unit, "s")
    for c in members:
        if c is stamps and len(members) > 1:
            continue
        step = c.properties.get("wf_increment")
        if not len(c):
            yield c, "is empty", ()
        elif _kind(c) not in NUMBERS:
            yield c, "holds no real numbers", ()
        elif len({*increments.get(c.path, ())}) > 1:
            told = ", ".join(f"{each:g}" for each in dict.fromkeys(increments[c.path]))
            yield c, f"changes its wf_increment between segments ({told} s): one file per sampling rate", ()
        elif step is None and stamps not in (None, c):
            yield c, beside, ()
        else:
            alike = stamps not in (None, c) and len(stamps) == len(c)
            yield c, _even(c, step), (beside,) if alike else ()


def _even(channel: TdmsChannel, step: object) -> Even:
    """Clock of a channel by NI's properties; an interval of 1 s that starts with LabVIEW's epoch is none."""
    origin = channel.properties.get("wf_start_time")
    known = isinstance(step, int | float) and bounds.SHORTEST_STEP_S < step < bounds.LONGEST_STEP_S
    if not known or (step == 1 and isinstance(origin, np.datetime64) and origin < UNSET):
        given = "absent" if step is None else step
        what = f"channel {channel.name!r} gives no sampling rate (wf_increment is {given})"
        return Even(
            0.0, asked=(what, f"log it as a waveform, set wf_increment to the interval in seconds{KEY}")
        )
    start = float(channel.properties.get("wf_start_offset", 0.0)) if _starts(channel) else 0.0
    return Even(float(step), start, _started(origin))  # type: ignore[arg-type]


def _starts(channel: TdmsChannel) -> bool:
    """Whether the start offset of a channel is a number, or missing."""
    start = channel.properties.get("wf_start_offset", 0.0)
    return isinstance(start, int | float) and bool(np.isfinite(start))


def _kind(channel: TdmsChannel) -> str:
    """Kind of a channel's samples as NumPy names it; "" where it has none."""
    return channel.dtype.kind if len(channel) and channel.dtype is not None else ""


def _values(path: Path, channel: TdmsChannel) -> Floats:
    """All samples as doubles; dates as seconds since the first."""
    stated = channel.properties.get("wf_samples", 0)
    samples = channel[:]
    if len(samples) < max(stated, len(channel)):
        lost = f"{len(samples)} of {max(stated, len(channel))} samples"
        raise FreerockError(path, f"the file is truncated: channel {channel.name!r} holds {lost}", COPY_AGAIN)
    if samples.dtype.kind == DATE:
        samples = (samples - samples[0]) / np.timedelta64(1, "s")
    return np.asarray(samples, float)


def _started(origin: object) -> str:
    """A start of recording in UTC; "" where it is LabVIEW's epoch, or none."""
    if not isinstance(origin, np.datetime64) or origin <= UNSET:
        return ""
    return f"{np.datetime_as_string(origin, 'ms')}Z"
