"""Record to rotation: θ(t) with its uncertainty, its flags and the faults of its signal.

In this order: units, flags, interference of the mains, zero at rest, geometry of the beam. Nothing is
filtered, so nothing is delayed or rounded off.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import SLOWEST_S, Floats, numbers
from freerock.config.processing import ROTATION_OPTIONS, RotationOptions
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.channel import Reading, Rotation, read_channel
from freerock.rotation.faults import flagged_faults
from freerock.rotation.flags import FLAGS
from freerock.rotation.lasers import rotation_of_one, rotation_of_two
from freerock.rotation.sensor import Laser, lasers_of
from freerock.rotation.view import sensor_attributes, view_of
from freerock.units import BASE

if TYPE_CHECKING:
    import xarray as xr

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
        Time is the record's less the delay of the laser's response. Over dimension time: theta [rad] and
        sigma_theta [rad] (NaN where flagged), flags (sum of
        `flags.FLAGS`); what was recorded, named by its quantity (voltage [V], current [mA], displacement
        [m], rotation [rad]; of the second laser with _2); of two lasers translation [m] along the beams, away
        from the sensors. Over dimension fault, what is wrong with the signal and when: fault (name),
        fault_start and fault_end [s], fault_note, fault_angle [rad] (its effect on θ, NaN where unknown).
        Attributes: sampling_rate_hz, noise_v (white), mains_hz and mains_amplitude_v (0 if off), zero_v (mean
        reading at rest), zero_drift_v (its range), in _ma, _m or _rad for other quantities, of the first
        laser; rest_phases (their number), zero_stderr_rad; what `view.view_in` reads, as sensor_beam.

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
    time_s, signals = numbers("time", time_s), _channels(signal, lasers)
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
    dataset = _dataset(time_s - _delay_s(lasers), step, readings, found)
    return dataset.assign_attrs(sensor_attributes(view_of(lasers, block)))


def _named(reading: Reading, laser: Laser) -> Reading:
    """The reading of one of two lasers, its faults noted with where its beam is."""
    where = f"laser at {laser.position:g} m: "
    return reading._replace(faults=[fault._replace(note=where + fault.note) for fault in reading.faults])


def _channels(signal: ArrayLike | Sequence[ArrayLike], lasers: Sequence[Laser]) -> list[Floats]:
    """The channel of each laser."""
    channels: Any = signal if np.ndim(signal[0]) else [signal]  # type: ignore[index]
    if len(channels) != len(lasers):
        what = f"{len(channels)} channels for {len(lasers)} lasers"
        raise FreerockError("laser signal", what, "name a channel for each laser")
    return [numbers("laser signal", each) for each in channels]


def _delay_s(lasers: Sequence[Laser]) -> float:
    """By how much the record is late [s]."""
    times = {laser.response_ms for laser in lasers}
    if len(times) > 1:
        what = "the two lasers differ in their response"
        raise FreerockError("laser signal", what, "give both the same response_ms")
    return times.pop() / 1e3 / 2


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


def _dataset(time_s: Floats, step: float, readings: Sequence[Reading], found: Rotation) -> "xr.Dataset":
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
        },
    )
