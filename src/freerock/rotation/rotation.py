"""A record file to θ(t) with its uncertainty, its flags and the faults of its signal.

In this order: units, flags, interference of the mains, zero at rest, geometry of the beam. Nothing is
filtered, so nothing is delayed or rounded off.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import SLOWEST_S, Floats, Mask, numbers
from freerock.config.processing import ROTATION_OPTIONS, RotationOptions
from freerock.errors import FreerockError, number_of
from freerock.files import check_file
from freerock.models.block import Block
from freerock.noise.still_phases import stretches
from freerock.records.channels import NAME_ONE
from freerock.records.read import read_record
from freerock.rotation.beam import (
    displaced,
    is_unsigned,
    mirrored,
    on_target,
    rotation_from_displacement,
    sensitivity,
)
from freerock.rotation.channel import Reading, read_channel
from freerock.rotation.flags import FLAGS, Fault, flagged_faults
from freerock.rotation.sensor import Laser, laser_of, lasers_of
from freerock.rotation.view import KEYS, View, view_of
from freerock.units import BASE

if TYPE_CHECKING:
    import xarray as xr

# Attributes in which a reader says what it found out.
READERS_NOTES = ("reading", "above", "time_base", "start_time")


class Rotation(NamedTuple):
    """θ(t) from one reading or two.

    Parameters
    ----------
    theta, sigma : ndarray, shape (n_time,)
        Rotation and the standard error of one sample of it [rad].
    zero_stderr : float
        Standard error of the zero of θ [rad].
    translation : ndarray, shape (n_time,), or None
        Of the block along the beams, away from the sensors [m]; None where one reading can't show it.
    faults : sequence of Fault
        Where the readings contradict each other.
    """

    theta: Floats
    sigma: Floats
    zero_stderr: float
    translation: Floats | None = None
    faults: Sequence[Fault] = ()


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
    channels: list[xr.DataArray] = []
    for name in names:
        read = read_record(path, name or None, time_unit=options.time_unit, rate_hz=options.sampling_rate_hz)
        if len(read.data_vars) > 1:
            several = f"has the channels {', '.join(map(str, read.data_vars))}"
            raise FreerockError(path, several, NAME_ONE)
        (signal,) = read.data_vars.values()
        signal.values[signal.attrs.pop("out_of_range", [])] = np.inf  # counted as such
        channels.append(signal.assign_attrs(read.attrs))
    time_s = channels[0]["time"].values
    begun = {channel.attrs.get("start_time") for channel in channels}
    if len(begun) > 1 or not all(np.array_equal(channel["time"].values, time_s) for channel in channels):
        raise FreerockError(path, "the two channels have different time bases", "name two of one group")
    signals, units = [each.values for each in channels], [each.attrs["units"] for each in channels]
    record = find_rotation(time_s, signals, lasers, block, units, options)
    found_out = channels[0].attrs
    return record.assign_attrs({key: found_out[key] for key in READERS_NOTES if key in found_out})


LATE = 1.5  # times the interval between the swings before: one was missed
AROUND = 3  # samples on either side: a mean of samples moves more slowly at a touch-down than beside it
OTHER_SIDE = 0.25  # of the faster side, that the other side of a touch-down moves: one outlier flips no sign
SURE = 5.0  # standard errors of θ that a disagreement exceeds
TOGETHER_S = 0.5  # disagreements this close are one fault
ATTRS = {
    "theta": {
        "units": "rad",
        "long_name": "rotation of the block, positive clockwise",
        "ancillary_variables": "sigma_theta flags",
    },
    "sigma_theta": {"units": "rad", "long_name": "standard error of one sample of rotation"},
    "flags": {
        "long_name": "why a sample is invalid (0: valid)",
        "flag_masks": np.array(list(FLAGS.values()), np.uint8),
        "flag_meanings": " ".join(FLAGS),
    },
    "translation": {"units": "m", "long_name": "translation along the beams, away from the sensors"},
    **{quantity: {"units": unit, "long_name": f"{quantity} as recorded"} for quantity, unit in BASE.items()},
}


def find_rotation(
    time_s: ArrayLike,
    signal: ArrayLike | Sequence[ArrayLike],
    laser: Laser | Sequence[Laser],
    block: Block,
    units: str | Sequence[str] | None = None,
    options: RotationOptions = ROTATION_OPTIONS,
) -> "xr.Dataset":
    """Rotation of the block from the channel of its laser, or of two, with uncertainty, flags and faults.

    docs/signals.md describes the steps. The standard error is that of one sample: white noise at rest and the
    error of the mains interference subtracted. The error of the zero, common to all samples of a run, stands
    apart in `zero_stderr_rad`. Two lasers with beams of one kind, on one face, separate rotation and
    translation: tan θ = (s₁ - s₂)/(Y₁ - Y₂) for horizontal beams, with X for vertical ones, since a
    translation adds the same to both readings.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Evenly spaced time [s].
    signal : ndarray, shape (n_time,) or (2, n_time)
        Channel of the laser, or of each of two.
    laser : Laser or sequence of two Laser
    block : Block
    units : str or sequence of str, optional
        Unit of each channel as the file states it, "" where it states none; left out, it is what the laser
        declares, else volts.
    options : RotationOptions, optional

    Returns
    -------
    xarray.Dataset
        Time is the record's less the delay of the laser's response. Over dimension time: theta and
        sigma_theta [rad] (NaN where flagged), flags (sum of `flags.FLAGS`); what was recorded, by its
        quantity (voltage [V], current [mA], displacement [m], rotation [rad]; of the second laser with _2);
        of two lasers translation [m] along the beams, away from the sensors. Over dimension fault: fault
        (name), fault_start and fault_end [s], fault_note, fault_angle [rad] (effect on θ, NaN if unknown).
        Attributes: sampling_rate_hz, noise_v (white), mains_hz and mains_amplitude_v (0 if off), zero_v (mean
        reading at rest), zero_drift_v (its range), in _ma, _m or _rad for other quantities, of the first
        laser; rest_phases (their number), zero_stderr_rad; what a view takes of the laser, as sensor_beam.

    Raises
    ------
    FreerockError
        Uneven time, or samples further apart than `SLOWEST_S`; no unit or a contradiction; no valid sample; a
        constant signal; no rest phase; two lasers that don't fit together.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
    >>> volts = freerock.read_record("raw/palermo_virtual/config2_marble.tdms")["laser"]
    >>> data = freerock.find_rotation(volts["time"], volts, laser, block, volts.units)
    >>> print(f"{data['theta'].max().item():.3f} rad, {data.attrs['noise_v']:.4f} V")
    0.181 rad, 0.0020 V
    """
    lasers = lasers_of(laser)
    channels: Any = signal if np.ndim(signal[0]) else [signal]  # type: ignore[index]
    if len(channels) != len(lasers):
        what = f"{number_of(len(channels), 'channel')} for {number_of(len(lasers), 'laser')}"
        raise FreerockError("laser signal", what, "name a channel for each laser")
    if any(own.response_ms != lasers[0].response_ms for own in lasers):
        raise FreerockError("laser signal", "the two lasers differ in their response", "give both the same")
    time_s, signals = numbers("time", time_s), [numbers("laser signal", each) for each in channels]
    step = _even_step(time_s, signals)
    if units is None:
        units = [own.units or "V" for own in lasers]
    stated = [units] if isinstance(units, str) else units
    readings = [
        read_channel(time_s, step, each, own, block, unit, options)
        for each, own, unit in zip(signals, lasers, stated, strict=True)
    ]
    if len(lasers) == 1:
        found = rotation_of_one(time_s, readings[0], lasers[0], block)
    else:
        found = rotation_of_two(time_s, readings, lasers, block, options.max_disagreement_deg)
        readings = [_named(*each) for each in zip(readings, lasers, strict=True)]
    return _dataset(time_s - lasers[0].response_ms / 1e3 / 2, step, readings, found, view_of(lasers, block))


def _named(reading: Reading, laser: Laser) -> Reading:
    """The reading of one of two lasers, its faults noted with where its beam is."""
    where = f"laser at {laser.position:g} m: "
    return reading._replace(faults=[fault._replace(note=where + fault.note) for fault in reading.faults])


def _even_step(time_s: Floats, signals: Sequence[Floats]) -> float:
    """Sampling interval [s] of an evenly spaced record."""
    shapes = {each.shape for each in signals}
    if shapes != {time_s.shape} or time_s.ndim != 1 or time_s.size < 2:
        what = f"time has shape {time_s.shape} and the signal {' and '.join(map(str, shapes))}"
        remedy = "give two arrays of one equal length, of at least two samples"
        raise FreerockError("laser signal", what, remedy)
    step = float(time_s[-1] - time_s[0]) / (time_s.size - 1)
    if not (step > 0 and np.ptp(time_s - step * np.arange(time_s.size)) < step):
        remedy = "resample it, or correct the sampling rate"
        raise FreerockError("laser signal", "time is not evenly spaced", remedy)
    if step > SLOWEST_S:
        what = f"sampled every {step:g} s, which shows no rocking"
        raise FreerockError("laser signal", what, "give the unit of the time column, as time [ms]")
    return step


def _dataset(
    time_s: Floats, step: float, readings: Sequence[Reading], found: Rotation, view: View | None
) -> "xr.Dataset":
    """What `find_rotation` returns."""
    import xarray as xr

    flags = np.bitwise_or.reduce([reading.flags for reading in readings])
    faults = [fault for reading in readings for fault in reading.faults] + list(found.faults)
    lost = np.isnan(found.theta) & (flags == 0)
    flags[lost] = FLAGS["target_lost"]
    faults += flagged_faults(time_s, np.where(lost, flags, 0))
    faults.sort(key=lambda fault: (fault.start_s, fault.name))
    arrays = {"theta": found.theta, "sigma_theta": found.sigma, "flags": flags}
    if found.translation is not None:
        arrays["translation"] = found.translation
    for number, reading in enumerate(readings, 1):
        arrays[reading.quantity + ("" if number == 1 else f"_{number}")] = reading.recorded
    seconds = {"units": "s"}
    sensor = {key: getattr(view.laser, key) for key in KEYS} if view else {}
    return xr.Dataset(
        {name: ("time", values, ATTRS.get(name.removesuffix("_2"))) for name, values in arrays.items()}
        | {
            "fault_start": ("fault", np.array([f.start_s for f in faults], float), seconds),
            "fault_end": ("fault", np.array([f.end_s for f in faults], float), seconds),
            "fault_angle": ("fault", np.array([f.angle for f in faults], float), {"units": "rad"}),
            "fault_note": ("fault", np.array([f.note for f in faults], str)),
        },
        coords={
            "time": ("time", time_s, seconds | {"long_name": "time from the start of the record"}),
            "fault": ("fault", np.array([f.name for f in faults], str)),
        },
        attrs={
            "sampling_rate_hz": 1 / step,
            **readings[0].attrs,
            "rest_phases": len(readings[0].rest_mid_s),
            "zero_stderr_rad": found.zero_stderr,
            **{f"sensor_{key}": value for key, value in sensor.items() if value is not None},
        },
    )


def rotation_of_one(time_s: Floats, reading: Reading, laser: Laser, block: Block) -> Rotation:
    """θ from one channel, time_s of shape (n_time,) [s]; NaN where the beam does not meet the block."""
    zero_stderr = reading.zero_stderr / reading.per_angle
    if reading.quantity == "rotation":
        theta = reading.displacement
        return Rotation(theta, np.where(np.isnan(theta), np.nan, reading.sigma), zero_stderr)
    side = None
    if is_unsigned(block, laser):
        largest = float(np.nanmax(reading.sigma))
        side = _swing_sides(-reading.displacement, largest, time_s, reading.rest_mid_s, laser)
    theta = rotation_from_displacement(reading.displacement, block, laser, side)
    with np.errstate(divide="ignore", invalid="ignore"):  # infinite where a beam over a corner is blind
        return Rotation(theta, reading.sigma / sensitivity(theta, block, laser), zero_stderr)


def _swing_sides(rise: Floats, sigma: float, time_s: Floats, rest_mid_s: list[float], laser: Laser) -> Floats:
    """Sign of θ for a reading that has none: swings change side at each touch-down, anew after every rest.

    A swing is where the rise exceeds 8 σ (or 1 % of its maximum), a touch-down where it falls below half of
    that; as no sample may lie there, also where it falls below twice the largest step around it. What is
    smaller keeps the side of the swing before it. Where the next swing takes `LATE` times as long to come as
    the one before, one was too faint between them, as those of the nearer corner are.
    """
    first = 1.0 if laser.release_side == "positive" else -1.0
    side = np.full(rise.size, first)
    high = max(8 * sigma, 0.01 * np.nanmax(rise))
    smooth = np.convolve(rise, np.full(5, 0.2), "same")  # only to find the swings; θ itself is not smoothed
    low = smooth < np.maximum(high / 2, 2 * _fastest(smooth))
    index = np.flatnonzero((smooth > high) | low)
    swings = [(index[i], index[j]) for i, j in stretches(~low[index])]
    sign, interval = first, math.inf
    for (begin, last), (start, end) in pairwise(swings):
        rested = any(time_s[last] < mid < time_s[start] for mid in rest_mid_s)
        between = (start + end - begin - last) / 2
        if not rested and between > LATE * interval:
            middle = (last + start) // 2
            side[last + int(np.nanargmin(rise[last : middle + 1])) :] = -sign
            side[middle + int(np.nanargmin(rise[middle : start + 1])) :] = sign
            interval = between / 2
            continue
        sign, interval = (first, math.inf) if rested else (-sign, between)
        side[last + int(np.nanargmin(rise[last : start + 1])) :] = sign
    return side


def _fastest(values: Floats) -> Floats:
    """The largest step around each value between a fall and a rise, as a touch-down lies; else 0."""
    steps = np.nan_to_num(np.diff(values, prepend=values[:1]))
    fall, rise = np.maximum(-steps, 0.0), np.maximum(np.append(steps[1:], 0.0), 0.0)
    before, after = fall.copy(), rise.copy()
    for by in range(1, AROUND + 1):
        np.maximum(before[by:], fall[:-by], out=before[by:])
        np.maximum(after[:-by], rise[by:], out=after[:-by])
    fastest = np.maximum(before, after)
    return np.where(np.minimum(before, after) > OTHER_SIDE * fastest, fastest, 0.0)


def rotation_of_two(
    time_s: Floats,
    readings: Sequence[Reading],
    lasers: Sequence[Laser],
    block: Block,
    max_disagreement_deg: float,
) -> Rotation:
    """Separate rotation from translation: tan θ = (s₁ - s₂)/(Y₁ - Y₂), see `rotation.find_rotation`.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Evenly spaced time [s].
    readings, lasers : sequence
        Two of each.
    block : Block
    max_disagreement_deg : float
        See `RotationOptions` [degree].

    Raises
    ------
    FreerockError
        The beams differ in kind or in face, or are at one place.
    """
    first, second = readings
    one, other = lasers
    if "rotation" in (first.quantity, second.quantity) or (one.beam, one.face) != (other.beam, other.face):
        what = "the two beams differ in kind or in face"
        raise FreerockError("laser signal", what, "use two of one kind, on one face")
    apart = one.position - other.position
    if apart == 0:
        raise FreerockError("laser signal", "the two beams are at one position_m", "give both positions")
    angle = np.arctan((first.displacement - second.displacement) / apart)
    theta = -angle if mirrored(one) else angle
    on_one, on_other = (on_target(theta, block, each) for each in lasers)
    translation = np.where(on_one, first.displacement - displaced(theta, block, one), np.nan)
    theta = np.where(on_one & on_other, theta, np.nan)
    sigma = np.hypot(first.sigma, second.sigma) / abs(apart) * np.cos(theta) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        apart_rad = np.abs(translation) / sensitivity(theta, block, one)
        wrong = (apart_rad > math.radians(max_disagreement_deg)) & (apart_rad > SURE * sigma)
    faults = _disagreements(time_s, wrong, translation, theta, block, one) if wrong.any() else []
    zero_stderr = float(np.hypot(first.zero_stderr, second.zero_stderr)) / abs(apart)
    return Rotation(theta, sigma, zero_stderr, translation, faults)


def _disagreements(
    time_s: Floats, wrong: Mask, translation: Floats, theta: Floats, block: Block, laser: Laser
) -> list[Fault]:
    """A fault for every stretch in which the lasers disagree."""
    faults, index = [], np.flatnonzero(wrong)
    step = time_s[1] - time_s[0]
    for i, j in stretches(np.diff(index) * step < TOGETHER_S) or [(0, index.size - 2)]:
        part = index[i : j + 2]
        angle = float(np.nanmax(np.abs(translation[part]) / sensitivity(theta[part], block, laser)))
        largest = 1e3 * float(np.nanmax(np.abs(translation[part])))
        note = f"up to {math.degrees(angle):.2f}°, {largest:.2g} mm"
        faults.append(Fault("lasers_disagree", float(time_s[part[0]]), float(time_s[part[-1]]), note, angle))
    return faults
