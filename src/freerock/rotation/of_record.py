"""A record file to θ(t): its channels are read, checked and turned into a rotation."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from freerock.config.processing import RotationOptions
from freerock.errors import FreerockError
from freerock.files import check_file
from freerock.models.block import Block
from freerock.records.read import read_record
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser, laser_of

if TYPE_CHECKING:
    import xarray as xr

# Attributes in which a reader says what it found out.
READERS_NOTES = ("reading", "above", "time_base", "start_time")


def rotation_of(settings: Mapping[str, Any]) -> "xr.Dataset":
    """θ(t) of a record, with what its reader found out.

    Parameters
    ----------
    settings : mapping
        raw (folder), file, sha256 (as listed, else empty), channels, lasers, block, rotation: sections of the
        configuration as plain values.

    Returns
    -------
    xarray.Dataset
        As `freerock.rotation.rotation.find_rotation` gives it.

    Raises
    ------
    FreerockError
        The file is not the one listed, can't be read, or its signal can't become a rotation.
    """
    path = Path(settings["raw"], settings["file"])
    if settings["sha256"]:
        check_file(settings["raw"], settings["file"], settings["sha256"])
    lasers = [laser_of(section, settings["raw"]) for section in settings["lasers"]]
    block, options = Block(**settings["block"]), RotationOptions(**settings["rotation"])
    return rotation_in(path, settings["channels"], lasers, block, options)


def rotation_in(
    path: Path, names: Sequence[str], lasers: Sequence[Laser], block: Block, options: RotationOptions
) -> "xr.Dataset":
    """As `rotation_of`, of a file whose channels have these names, "" where it has one channel alone."""
    channels = [_channel(path, name, options) for name in names]
    time_s = channels[0]["time"].values
    begun = {channel.attrs.get("start_time") for channel in channels}
    if len(begun) > 1 or not all(np.array_equal(channel["time"].values, time_s) for channel in channels):
        raise FreerockError(path, "the two channels have different time bases", "name two of one group")
    signals, units = [each.values for each in channels], [each.attrs["units"] for each in channels]
    record = find_rotation(time_s, signals, lasers, block, units, options)
    found_out = channels[0].attrs
    return record.assign_attrs({key: found_out[key] for key in READERS_NOTES if key in found_out})


def _channel(path: Path, name: str, options: RotationOptions) -> "xr.DataArray":
    """A channel by its name, "" for the only one, with the attributes of its file.

    Samples out of range are infinite here, so that they are counted as such.
    """
    read = read_record(path, name or None, time_unit=options.time_unit, rate_hz=options.sampling_rate_hz)
    if len(read.data_vars) > 1:
        several = f"has the channels {', '.join(map(str, read.data_vars))}"
        raise FreerockError(path, several, "name one in the channel column of the campaign's CSV")
    (signal,) = read.data_vars.values()
    signal = signal.copy(data=np.array(signal.values))  # a reader may give an array that can't be written to
    signal.values[signal.attrs.pop("out_of_range", [])] = np.inf
    return signal.assign_attrs(read.attrs)
