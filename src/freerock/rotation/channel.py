"""From a channel to the displacement of its target, with faults and noise of the signal."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from freerock.arrays import Flags, Floats
from freerock.config.processing import RotationOptions
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.noise.interference import (
    FAINT,
    MAINS_KEEP,
    SURE,
    Mains,
    other_line,
    other_mains,
    seen_mains,
    significant_mains,
    slow_line,
)
from freerock.noise.signal_noise import COARSE_STEP, StillSignal, lattice_step
from freerock.noise.still_phases import Phase
from freerock.rotation.beam import sensitivity
from freerock.rotation.flags import FLAGS, Fault, flag_samples, flagged_faults, shares
from freerock.rotation.sensor import Laser, distance_from_output, looks_like_current, recorded_of
from freerock.units import BASE

NO_NUMBER = "no sample is a number"
CHECK = "check the channel, the cable and the sensor's range"
LARGEST = 1e9  # in any unit: beyond it nothing was measured
ROUNDED = 0.32  # of a coarse converter's step: the line that rounding alone makes of a slow one is no higher
BLIND = 1e-9  # of the half width b: a beam this near a corner sees no turning about it
SUFFIX = {"V": "v", "mA": "ma", "m": "m", "rad": "rad"}  # of attributes in that unit


class Reading(NamedTuple):
    """What one channel shows.

    Parameters
    ----------
    displacement : ndarray, shape (n_time,)
        Of the target from rest [m], or the rotation itself [rad]; NaN where invalid.
    sigma : float or ndarray
        Standard error of one sample of it.
    flags : ndarray of uint8, shape (n_time,)
    faults : list of Fault
    quantity : str
        What was recorded, a key of `units.BASE`.
    recorded : ndarray, shape (n_time,)
        As recorded, in the unit used inside.
    rest_mid_s : list of float
        Middle of each rest [s].
    zero_stderr : float
        Standard error of the zero of the displacement: that of the levels at rest, and a quarter of the
        largest step between two.
    per_angle : float
        Displacement per rotation about θ = 0 [m/rad], NaN for a beam over a corner, blind to one side.
    attrs : dict
        Attributes of the dataset: noise, interference of the mains, zero.
    """

    displacement: Floats
    sigma: float | Floats
    flags: Flags
    faults: list[Fault]
    quantity: str
    recorded: Floats
    rest_mid_s: list[float]
    zero_stderr: float
    per_angle: float
    attrs: dict[str, float]


def read_channel(
    time_s: Floats,
    step: float,
    values: Floats,
    laser: Laser,
    block: Block,
    stated_unit: str,
    options: RotationOptions,
) -> Reading:
    """Read one channel; raises as `rotation.find_rotation` does.

    time_s and values have the shape (n_time,): time [s], every `step` seconds, and the signal as the file has
    it, in `stated_unit` ("" where it states none) or the unit that the laser declares.
    """
    recorded, quantity = recorded_of(values, laser, stated_unit)
    unit, suffix = BASE[quantity], SUFFIX[BASE[quantity]]
    flags = flagged(recorded, step, laser, quantity)
    valid = np.where(flags == 0, recorded, np.nan)
    lattice = lattice_step(valid)
    signal = StillSignal(time_s, valid, step, options.window_s, lattice)
    mains, lines_of_hz, mains_faults = _mains(signal, options.mains_hz, unit)
    mains_stderr = mains.stderr * signal.noise if mains else 0.0
    if mains:
        signal = replace(signal, values=signal.values - mains.over(time_s))
    rests = [phase for phase in signal.phases if phase.kind == "rest"]
    if not rests:
        remedy = "record the block at rest before the first or after the last release"
        raise FreerockError("laser signal", "the block never stands still, so θ = 0 is unknown", remedy)
    rest_mid_s, level = [phase.mid_s for phase in rests], np.array([phase.level for phase in rests])
    level_m, slope_m = distance_from_output(level, laser, quantity)
    level_stderr = max(phase.level_stderr for phase in rests) * float(np.max(slope_m))
    distance, slope = distance_from_output(signal.values, laser, quantity)
    displacement = laser.sign * (distance - np.interp(time_s, rest_mid_s, level_m))
    flags[np.isnan(displacement) & (flags == 0)] = FLAGS["out_of_range"]
    about_zero = np.array([-1e-12, 1e-12])
    per_angle = 1.0 if quantity == "rotation" else float(sensitivity(about_zero, block, laser).min())
    if quantity != "rotation" and not per_angle > BLIND * block.b:
        per_angle = math.nan
    per_output = float(np.mean(slope_m)) / per_angle
    faults = flagged_faults(time_s, flags) + mains_faults
    faults += _interference(signal, mains, lines_of_hz, unit, per_output)
    faults += moved_rests(signal, rests, unit, per_output)
    return Reading(
        displacement=displacement,
        sigma=math.hypot(signal.noise, mains_stderr) * slope,
        flags=flags,
        faults=faults,
        quantity=quantity,
        recorded=recorded,
        rest_mid_s=rest_mid_s,
        zero_stderr=math.hypot(level_stderr, float(np.abs(np.diff(level_m)).max(initial=0.0)) / 4),
        per_angle=per_angle,
        attrs={
            f"noise_{suffix}": signal.noise,
            "mains_hz": mains.frequency_hz if mains else 0.0,
            f"mains_amplitude_{suffix}": mains.amplitude if mains else 0.0,
            f"zero_{suffix}": float(np.mean(level)),
            f"zero_drift_{suffix}": float(np.ptp(level)),
        },
    )


def flagged(recorded: Floats, step: float, laser: Laser, quantity: str) -> Flags:
    """The flags of a channel in the unit used inside; refuses one from which no rotation can come."""
    unit, limits = BASE[quantity], laser.limits(quantity)
    finite = np.isfinite(recorded)
    if not finite.any():
        raise FreerockError("laser signal", NO_NUMBER, CHECK)
    numbers = recorded if finite.all() else recorded[finite]
    low, high = float(numbers.min()), float(numbers.max())
    largest = max(abs(low), abs(high))
    if largest > LARGEST:
        raise FreerockError("laser signal", f"reaches {largest:.3g} {unit}", CHECK)
    flags = flag_samples(recorded, limits, step=step)
    if limits and quantity == "voltage" and looks_like_current(recorded, laser):
        share = f"{100 * np.count_nonzero(recorded > limits.high) / recorded.size:.3g} % of the samples"
        what = f"{share} are beyond {limits.high:g} V: {low:.3g} to {high:.3g} looks like mA"
        raise FreerockError("laser signal", what, "declare units: mA of the laser, or name its channel")
    if flags.all():
        wanted = f"within {limits.low:g} to {limits.high:g} {unit}" if limits else "valid"
        raise FreerockError("laser signal", f"no sample {wanted} ({shares(flags)})", CHECK)
    if low == high:
        raise FreerockError("laser signal", f"constant at {low:.6g} {unit}", CHECK)
    return flags


def _mains(
    signal: StillSignal, mains_hz: float | None, unit: str
) -> tuple[Mains | None, float | None, list[Fault]]:
    """The interference of the mains to be removed; of what the lines are harmonics [Hz]; faults."""
    if mains_hz is None:
        return None, None, []
    mains, whole = significant_mains(signal, mains_hz), (float(signal.time_s[0]), float(signal.time_s[-1]))
    other = None if mains else other_mains(signal, mains_hz)
    if other:
        other_hz, found = other
        note = f"{found.frequency_hz:.2f} Hz, {found.amplitude:#.3g} {unit}: the mains seem to be at "
        note += f"{other_hz:g} Hz and not at {mains_hz:g} Hz, set mains_hz: {other_hz:g}"
        return None, other_hz, [Fault("other_mains", *whole, note)]
    seen = seen_mains(signal, mains_hz)
    if seen and abs(seen[0] - 1) >= MAINS_KEEP + SURE * seen[1]:
        rate_hz = 1 / signal.step
        note = f"the mains at {seen[0] * mains_hz:.2f} Hz: the sampling rate is {rate_hz / seen[0]:.5g} Hz "
        note += f"and not {rate_hz:.5g} Hz, or this is not the mains"
        return None, None, [Fault("sampling_rate", *whole, note)]
    return mains, mains_hz if mains or seen else None, []


def _interference(
    signal: StillSignal, mains: Mains | None, lines_of_hz: float | None, unit: str, per_output: float
) -> list[Fault]:
    """Sinusoids at rest: the mains, which have been removed, and the strongest that is not from them."""
    faults, whole = [], (float(signal.time_s[0]), float(signal.time_s[-1]))
    if mains:
        note = f"{mains.frequency_hz:.2f} Hz, {mains.amplitude:#.3g} {unit}, removed"
        faults.append(Fault("mains_interference", *whole, note, mains.amplitude * per_output))
    line = other_line(signal, lines_of_hz)
    rounded = ROUNDED * signal.lattice if signal.lattice > COARSE_STEP * signal.noise else 0.0
    if line and line[1] > max(FAINT * signal.noise, rounded):
        note = f"{line[0]:.1f} Hz, {line[1]:#.3g} {unit}, not from the mains: folded, or a vibration"
        faults.append(Fault("aliasing", *whole, note, line[1] * per_output))
    slow = slow_line(signal.untouched, signal.step)
    if slow and slow[1] > FAINT * signal.noise:
        note = f"{slow[0]:.1f} Hz, {slow[1]:#.3g} {unit}, before anything was moved: "
        note += "the floor or the stand of the laser shakes"
        faults.append(Fault("vibration", *whole, note, slow[1] * per_output))
    return faults


def moved_rests(signal: StillSignal, rests: Sequence[Phase], unit: str, per_output: float) -> list[Fault]:
    """Rest levels that differ from the one before: by drift if the slopes at rest predict it, else shifted.

    per_output is the rotation per unit of the signal [rad].
    """
    faults, slopes = list[Fault](), list[tuple[float, float]]()
    for phase in rests:  # slope within it and its standard error, per second
        part = phase.core(signal.time_s, 0.2)
        valid = np.isfinite(signal.values[part])
        y, t = signal.values[part][valid], signal.time_s[part][valid] - phase.mid_s
        if t.size < 10:
            slopes.append((0.0, math.inf))
            continue
        t -= t.mean()
        slopes.append((float(t @ y) / float(t @ t), signal.noise / math.sqrt(t @ t)))
    for (one, (slope, error)), (two, (slope_2, error_2)) in pairwise(zip(rests, slopes, strict=True)):
        moved, span = two.level - one.level, two.mid_s - one.mid_s
        if abs(moved) < max(SURE * math.hypot(one.level_stderr, two.level_stderr), signal.noise):
            continue
        by_drift = (slope + slope_2) / 2 * span
        unsure = math.hypot(error, error_2) / 2 * span
        drifted = abs(by_drift) > 3 * unsure and abs(moved - by_drift) < 3 * unsure + abs(by_drift)
        name = "drift" if drifted else "rest_shift"
        note = f"{moved:+#.3g} {unit}"
        faults.append(Fault(name, one.end_s, two.start_s, note, moved * per_output))
    return faults
