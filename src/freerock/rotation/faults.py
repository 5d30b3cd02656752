"""Faults of a signal: name, start, end and effect on θ."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freerock.arrays import Flags, Floats
from freerock.noise.converter import converter_step
from freerock.noise.still import between_breaks
from freerock.rotation.flags import FLAGS
from freerock.units import BASE

if TYPE_CHECKING:
    import xarray as xr

MERGED_S = 0.01  # invalid stretches this close are one fault


class Fault(NamedTuple):
    """What is wrong from when to when [s], in words, and by how much θ is wrong [rad], NaN where unknown."""

    name: str
    start_s: float
    end_s: float
    note: str
    angle: float = math.nan


@dataclass(frozen=True)
class SignalQuality:
    """Quality of θ(t) of a record.

    Standard error of its zero [rad], faults of its signal, and step of its converter [rad], 0 where that is
    too fine to be seen.
    """

    zero_stderr: float = 0.0
    faults: tuple[Fault, ...] = ()
    converter_step: float = 0.0


def signal_quality(record: "xr.Dataset") -> SignalQuality:
    """The quality of the signal of a dataset of `rotation.find_rotation`."""
    recorded = next(record[name].values for name in BASE if name in record)
    step = converter_step(recorded, record["theta"].values)
    return SignalQuality(record.attrs["zero_stderr_rad"], tuple(listed_faults(record)), step)


def listed_faults(record: "xr.Dataset | xr.DataTree") -> list[Fault]:
    """The faults that a dataset of `rotation.find_rotation` holds."""
    names = ("fault", "fault_start", "fault_end", "fault_note", "fault_angle")
    columns = (np.asarray(record[name]).tolist() for name in names)
    return [Fault(*row) for row in zip(*columns, strict=True)]


def flagged_faults(time_s: Floats, flags: Flags) -> list[Fault]:
    """A fault per stretch of samples with the same flag; stretches closer than `MERGED_S` are one fault."""
    faults: list[Fault] = []
    every = np.flatnonzero(flags)
    step = (time_s[-1] - time_s[0]) / max(time_s.size - 1, 1)
    apart = max(1, round(MERGED_S / step))
    for name, mask in FLAGS.items():
        index = every[(flags[every] & mask) > 0]
        if index.size == 0:
            continue
        for i, j in zip(*between_breaks(np.diff(index) > apart), strict=True):
            note = f"{j - i + 1} sample{'s' if j > i else ''}"
            faults.append(Fault(name, float(time_s[index[i]]), float(time_s[index[j]]), note))
    return faults
