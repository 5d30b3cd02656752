"""NI TDMS records, through npTDMS: channels with NI's waveform properties, or beside one of time stamps."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from nptdms import TdmsChannel, TdmsFile
from nptdms.log import log_manager
from nptdms.reader import TdmsReader

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN, Channel, Contents, Even, Stamps, is_possible, unfit
from freerock.records.headings import is_time, split_unit

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

    A file is truncated when its last segment is incomplete, or when a channel holds fewer samples than its
    wf_samples. (wf_samples may be smaller than the channel is long: streaming acquisition writes the length
    of its first chunk.)
    """
    with open(path, "rb") as stream:
        segments = _Increments(stream)
        segments.read_metadata()
        stream.seek(0)
        with TdmsFile.open(stream) as file:
            if file.file_status.incomplete_final_segment:
                raise FreerockError(path, "the file is truncated: its last segment is incomplete", COPY_AGAIN)
            groups = [group.channels() for group in file.groups()]
            found = [c for members in groups for c in _channels(path, members, segments.found)]
            starts = (_started(c.properties.get("wf_start_time")) for members in groups for c in members)
            yield Contents(found, "TDMS", [], next(filter(None, starts), ""))


def _channels(
    path: Path, members: list[TdmsChannel], increments: dict[str, list[float]]
) -> Iterator[Channel]:
    """The channels of a group, each with its clock or why it can't be read; time stamps are none of them."""
    stamps = next((c for c in members if is_time(c.name) and _kind(c) in (*NUMBERS, DATE)), None)
    beside: Stamps | None = None
    if stamps is not None and len(members) > 1:
        unit = "s" if _kind(stamps) == DATE else _unit(stamps)
        beside = Stamps(stamps.name, partial(_values, path, stamps), unit, "s")
    for c in members:
        group, steps = c.group_name, [*dict.fromkeys(increments.get(c.path, ()))]
        if beside and c is stamps:
            continue
        if _kind(c) not in NUMBERS:
            yield unfit(c.name, "holds no real numbers" if len(c) else "is empty", group)
        elif len(steps) > 1:
            told = ", ".join(f"{each:g}" for each in steps)
            why = f"changes its wf_increment between segments ({told} s): one file per sampling rate"
            yield unfit(c.name, why, group)
        else:
            clock = beside if beside and not steps else _even(c)
            also = (beside,) if beside and steps and stamps is not None and len(stamps) == len(c) else ()
            yield Channel(c.name, _unit(c), partial(_values, path, c), clock, group, also)


def _unit(channel: TdmsChannel) -> str:
    return str(channel.properties.get("unit_string", "")) or split_unit(channel.name)[1]


def _even(channel: TdmsChannel) -> Even:
    """Clock of a channel by NI's properties; an interval of 1 s that starts with LabVIEW's epoch is none."""
    step, origin = channel.properties.get("wf_increment", "absent"), channel.properties.get("wf_start_time")
    known = isinstance(step, int | float) and is_possible(step)
    if not known or (step == 1 and isinstance(origin, np.datetime64) and origin < UNSET):
        return Even(np.nan, unknown=f"{channel.name!r} gives no sampling rate (wf_increment is {step})")
    start = channel.properties.get("wf_start_offset", 0.0)
    known = isinstance(start, int | float) and np.isfinite(start)
    return Even(float(step), float(start) if known else 0.0, _started(origin))


def _kind(channel: TdmsChannel) -> str:
    """Kind of a channel's samples as NumPy names it; "" where it has none."""
    return channel.dtype.kind if len(channel) and channel.dtype is not None else ""


def _values(path: Path, channel: TdmsChannel) -> Floats:
    """All samples as doubles; dates as seconds since the first."""
    stated = max(channel.properties.get("wf_samples", 0), len(channel))
    samples = channel[:]
    if len(samples) < stated:
        lost = f"{len(samples)} of {stated} samples"
        raise FreerockError(path, f"the file is truncated: channel {channel.name!r} holds {lost}", COPY_AGAIN)
    if samples.dtype.kind == DATE:
        samples = (samples - samples[0]) / np.timedelta64(1, "s")
    return np.asarray(samples, float)


def _started(origin: object) -> str:
    """A start of recording in UTC; "" where it is LabVIEW's epoch, or none."""
    if not isinstance(origin, np.datetime64) or origin <= UNSET:
        return ""
    return f"{np.datetime_as_string(origin, 'ms')}Z"
