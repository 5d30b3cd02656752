"""NI TDMS records, through npTDMS: channels with NI's waveform properties (wf_increment and so on)."""

import numpy as np
import xarray as xr
from nptdms import TdmsFile

from freerock.errors import FreerockError

COPY_AGAIN = "copy it again from the acquisition computer"


def read(path, channel=None):
    """Read a TDMS file; arguments, result and errors as of `freerock.acquisition.read_record`.

    A file is truncated when its last segment is incomplete, when a channel holds fewer samples than its
    wf_samples, or when channels of one group and one sampling rate differ in length. (wf_samples may be
    smaller than the channel is long: streaming acquisition writes the length of its first chunk.)
    """
    try:
        with TdmsFile.open(path) as file:
            return _dataset(path, file, channel)
    except FreerockError:
        raise
    except Exception as error:  # npTDMS raises whatever the damaged bytes lead it into
        what = f"not a readable TDMS file ({type(error).__name__}: {error})"
        raise FreerockError(path, what, COPY_AGAIN) from error


def _dataset(path, file, channel):
    if file.file_status.incomplete_final_segment:
        raise FreerockError(path, "the file is truncated: its last segment is incomplete", COPY_AGAIN)
    everything = [c for group in file.groups() for c in group.channels()]
    if not everything:
        raise FreerockError(path, "the file holds no channel", COPY_AGAIN)
    names = _names(everything)
    wanted = _wanted(path, names, channel)
    for name, c in wanted.items():
        _refuse_short(path, name, c)

    steps = {name: _step(path, name, c) for name, c in wanted.items()}
    lengths = {name: len(c) for name, c in wanted.items()}
    step, length = next(iter(steps.values())), next(iter(lengths.values()))
    if len(set(steps.values())) > 1:
        raise FreerockError(
            path, f"channels of several sampling rates: {', '.join(wanted)}", "name the channel"
        )
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {n}" for name, n in lengths.items())
        raise FreerockError(path, f"channels of unequal length: {told}", COPY_AGAIN)

    first = next(iter(wanted.values())).properties
    start = float(first.get("wf_start_offset", 0.0))
    attrs = {"format": "TDMS", "sampling_rate_hz": 1 / step}
    if "wf_start_time" in first:
        attrs["start_time"] = f"{np.datetime_as_string(first['wf_start_time'], 'ms')}Z"
    return xr.Dataset(
        {
            name: ("time", np.asarray(c[:], float), {"units": str(c.properties.get("unit_string", ""))})
            for name, c in wanted.items()
        },
        coords={"time": ("time", start + step * np.arange(length), {"units": "s"})},
        attrs=attrs,
    )


def _names(channels):
    """Channels by name; by group/name where two groups share a name."""
    short = [c.name for c in channels]
    return {c.name if short.count(c.name) == 1 else f"{c.group_name}/{c.name}": c for c in channels}


def _wanted(path, names, channel):
    """The channel asked for, else all that hold numbers; those must hold samples."""
    present = ", ".join(names)
    if channel is None:
        wanted = {name: c for name, c in names.items() if _is_number(c)}
        if not wanted:
            raise FreerockError(path, f"no channel holds a number (channels: {present})", COPY_AGAIN)
        return wanted
    full = {f"{c.group_name}/{c.name}": name for name, c in names.items()}
    name = channel if channel in names else full.get(channel)
    if name is None:
        remedy = "correct the channel column of the campaign's CSV"
        raise FreerockError(path, f"no channel {channel!r}; its channels are {present}", remedy)
    if len(names[name]) and not _is_number(names[name]):
        raise FreerockError(path, f"channel {name!r} holds no real numbers", "name a channel that does")
    return {name: names[name]}


def _is_number(channel):
    return len(channel) > 0 and channel.dtype is not None and channel.dtype.kind in "iuf"


def _refuse_short(path, name, channel):
    if len(channel) == 0:
        raise FreerockError(path, f"channel {name!r} is empty", COPY_AGAIN)
    told = channel.properties.get("wf_samples", 0)
    if len(channel) < told:
        what = f"the file is truncated: channel {name!r} holds {len(channel)} of {told} samples"
        raise FreerockError(path, what, COPY_AGAIN)


def _step(path, name, channel):
    """Sampling interval [s]."""
    step = channel.properties.get("wf_increment")
    if not (isinstance(step, int | float) and np.isfinite(step) and step > 0):
        raise FreerockError(
            path,
            f"channel {name!r} gives no sampling rate (wf_increment is {'absent' if step is None else step})",
            "log it as a waveform, or set its property wf_increment to the sampling interval in seconds",
        )
    return float(step)
