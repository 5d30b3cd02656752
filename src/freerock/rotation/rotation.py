"""Record to rotation: θ(t) with its uncertainty, its flags and the faults of its signal.

In this order: units, flags, hum, zero at rest, geometry of the beam. Nothing is filtered, so nothing is
delayed or rounded off.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.beam import (
    displacement_from_rotation,
    is_unsigned,
    mirrored,
    on_target,
    rotation_from_displacement,
    sensitivity,
)
from freerock.rotation.flags import (
    FLAGS,
    Fault,
    ac_cutoff,
    flag_samples,
    flagged_faults,
    lost_at_large_angles,
    shares,
)
from freerock.rotation.mains import MOST_SEGMENTS, SEGMENT_S, fit_hum, mains_ratio, other_line
from freerock.rotation.sensor import Laser, distance_from_output
from freerock.rotation.still import stationary_phases, stretches
from freerock.units import BASE, in_base_units

CHECK = "check the channel, the cable and the sensor's range"
SURE = 5.0  # standard errors by which a rest level differs from another, a hum from none
LARGEST = 1e9  # in any unit: beyond it nothing was measured
NOISE_SAMPLES = 200_000  # suffice to know the noise within 0.2 %
MAINS_KEEP = 0.005  # of their frequency: the mains stay so close to it
RATE_SAMPLES = 1 << 18  # suffice to see a hum
PIECE = 1 << 14  # samples at a time: what fits the processor's cache is several times faster
LATE = 1.5  # times the interval between the lobes before: one was missed
BLIND = 1e-9  # of the half width b: a beam this near a corner sees no turning about it
SLOWEST_S = 0.05  # a longer sampling interval shows no rocking
FAINT = 0.1  # of the noise of one sample: a hum below this is not worth a word
SUFFIX = {"V": "v", "mA": "ma", "m": "m", "rad": "rad"}  # of attributes in that unit


def rotation(
    time_s,
    signal,
    laser: Laser | Sequence[Laser],
    block: Block,
    units: str | Sequence[str] | None = None,
    *,
    mains_hz: float | None = 50.0,
    window_s: float = 0.25,
    max_disagreement_deg: float = 0.5,
):
    """Rotation of the block from the channel of its laser, or of two, with uncertainty, flags and faults.

    In this order: invalid samples are flagged; hum at the mains frequency and its harmonics, fitted as
    sinusoids to the stationary phases, is subtracted where it is significant (no filter, so no delay); the
    reading at rest is θ = 0, interpolated linearly between rest phases and constant outside them; the
    displacement is inverted in closed form.

    Two lasers with beams of one kind, on one face, tell rotation from translation, whatever the translation:
    tan θ = (s₁ - s₂)/(Y₁ - Y₂) for horizontal beams, with X for vertical ones, since what a beam reads
    besides is common to both.

    The standard error is that of one sample: white noise in the stationary phases and the error of the hum
    subtracted. The error of the zero, common to all samples of a run, stands apart in `zero_stderr_rad`: the
    error of the rest levels, and a quarter of the largest step between two that follow each other, since the
    way in between is not known.

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
    mains_hz : float or None
        Nominal mains frequency [Hz]; None leaves hum alone.
    window_s : float
        Window of `stationary_phases` [s].
    max_disagreement_deg : float
        Two lasers disagree where the translation they find would turn the angle of the first alone by more
        than this [degree].

    Returns
    -------
    xarray.Dataset
        Over dimension time: theta [rad] and sigma_theta [rad] (NaN where flagged), flags (sum of
        `faults.FLAGS`); what was recorded, named by its quantity (voltage [V], current [mA], displacement
        [m], rotation [rad]; of the second laser with _2); of two lasers translation [m] along the beams, away
        from the sensors. Over dimension fault, what is wrong with the signal and when: fault (name),
        fault_start and fault_end [s], fault_note, fault_angle [rad] (its effect on θ, NaN where unknown).
        Attributes: sampling_rate_hz, noise_v (white), hum_hz and hum_amplitude_v (0 if off), zero_v (mean
        reading at rest), zero_drift_v (its range), in _ma, _m or _rad for other quantities, of the first
        laser; rest_phases (their number), zero_stderr_rad.

    Raises
    ------
    FreerockError
        Uneven time, or samples further apart than `SLOWEST_S`; no unit or a contradiction; no valid sample; a
        constant signal; an AC-coupled channel; no rest phase; two lasers that don't fit together.
    """
    import xarray as xr

    lasers = (laser,) if isinstance(laser, Laser) else tuple(laser)
    several = isinstance(signal, list | tuple) and len(signal) and np.ndim(signal[0])
    signals = [np.asarray(each, float) for each in (signal if several else np.atleast_2d(signal))]
    stated = _stated(units, lasers)
    if len(signals) != len(lasers):
        raise FreerockError(
            "laser signal",
            f"{len(signals)} channels for {len(lasers)} lasers",
            "name a channel for each laser",
        )
    time_s = np.asarray(time_s, float)
    step = _even_step(time_s, signals)
    options = {"mains_hz": mains_hz, "window_s": window_s}
    readings = [
        _reading(time_s, step, each, own, block, unit, **options)
        for each, own, unit in zip(signals, lasers, stated, strict=True)
    ]
    first = readings[0]
    faults = [fault for reading in readings for fault in reading.faults]
    flags = np.bitwise_or.reduce([reading.flags for reading in readings])
    arrays = {}
    if len(lasers) == 1:
        theta, sigma = _single(time_s, first, lasers[0], block)
        zero_stderr = first.zero_stderr / first.per_angle
    else:
        theta, sigma, translation, apart = _pair(time_s, readings, lasers, block, max_disagreement_deg)
        zero_stderr = float(np.hypot(*(r.zero_stderr for r in readings))) / abs(
            lasers[0].position_m - lasers[1].position_m
        )
        faults += apart
        arrays["translation"] = translation
    lost = np.isnan(theta) & (flags == 0)
    if lost.any():
        flags[lost] = FLAGS["target_lost"]
        faults += flagged_faults(time_s, np.where(lost, flags, 0))
    faults += lost_at_large_angles(time_s, theta, flags)
    faults.sort(key=lambda fault: (fault.start_s, fault.name))
    arrays = {"theta": theta, "sigma_theta": sigma, "flags": flags} | arrays
    for number, reading in enumerate(readings, 1):
        arrays[reading.quantity + ("" if number == 1 else f"_{number}")] = reading.recorded

    return xr.Dataset(
        {name: ("time", values, _ATTRS.get(name.removesuffix("_2"))) for name, values in arrays.items()}
        | {
            "fault_start": ("fault", np.array([f.start_s for f in faults], float), {"units": "s"}),
            "fault_end": ("fault", np.array([f.end_s for f in faults], float), {"units": "s"}),
            "fault_angle": ("fault", np.array([f.angle for f in faults], float), {"units": "rad"}),
            "fault_note": ("fault", np.array([f.note for f in faults], str)),
        },
        coords={
            "time": ("time", time_s, {"units": "s", "long_name": "time from the start of the record"}),
            "fault": ("fault", np.array([f.name for f in faults], str)),
        },
        attrs={
            "sampling_rate_hz": 1 / step,
            **first.attrs,
            "rest_phases": len(first.rest_mid_s),
            "zero_stderr_rad": zero_stderr,
        },
    )


_ATTRS = {
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


class _Reading(NamedTuple):
    """One channel: displacement of the target [m] (or rotation [rad]) from rest, and what was found.

    The error of the zero is one of the displacement; `per_angle` is the displacement per rotation about θ = 0
    [m/rad], NaN for a beam over a corner, blind to one side.
    """

    displacement: np.ndarray
    sigma: float | np.ndarray
    flags: np.ndarray
    faults: list
    quantity: str
    recorded: np.ndarray
    rest_mid_s: list
    zero_stderr: float
    per_angle: float
    attrs: dict


def _stated(units, lasers):
    """Unit of each channel as the file states it, or as declared where there is no file."""
    if units is None:
        return [laser.units or "V" for laser in lasers]
    return [units] if isinstance(units, str) else list(units)


def _even_step(time_s, signals):
    """Sampling interval [s] of an evenly spaced record."""
    shapes = {each.shape for each in signals}
    if shapes != {time_s.shape} or time_s.ndim != 1 or time_s.size < 2:
        raise FreerockError(
            "laser signal",
            f"time has shape {time_s.shape} and the signal {' and '.join(map(str, shapes))}",
            "give two arrays of one equal length, of at least two samples",
        )
    step = float(time_s[-1] - time_s[0]) / (time_s.size - 1)
    count = step * np.arange(min(PIECE, time_s.size))
    apart = [np.ptp(time_s[i : i + PIECE] - count[: time_s.size - i]) for i in range(0, time_s.size, PIECE)]
    begins = time_s[::PIECE] - time_s[0] - step * np.arange(0, time_s.size, PIECE)
    if not (step > 0 and max(apart) < step and np.all(np.abs(begins) < step)):
        raise FreerockError(
            "laser signal", "time is not evenly spaced", "resample it, or correct the sampling rate"
        )
    if step > SLOWEST_S:
        raise FreerockError(
            "laser signal",
            f"sampled every {step:g} s, which shows no rocking",
            "give the unit of the time column, as time [ms]",
        )
    return step


def _reading(time_s, step, values, laser, block, stated, *, mains_hz, window_s):
    """Displacement of the target from rest, with everything the signal says about itself."""
    recorded, quantity = in_base_units(values, laser.units, stated)
    unit, limits = BASE[quantity], laser.limits(quantity)
    finite = np.isfinite(recorded)
    if not finite.any():
        raise FreerockError("laser signal", "no sample is a number", CHECK)
    numbers = recorded if finite.all() else recorded[finite]
    low, high = float(numbers.min()), float(numbers.max())
    largest = max(abs(low), abs(high))
    if largest > LARGEST:
        raise FreerockError("laser signal", f"reaches {largest:.3g} {unit}", CHECK)
    cutoff = ac_cutoff(step, recorded)
    if cutoff:
        raise FreerockError(
            "laser signal",
            f"the channel is AC-coupled: a held angle decays (cut-off {cutoff:.2g} Hz)",
            "set the channel to DC coupling and record again",
        )
    flags = flag_samples(recorded, limits, step=step)
    if flags.all():
        told = f"within {limits.low:g} to {limits.high:g} {unit}" if limits else "valid"
        what = f"no sample {told} ({shares(flags)})"
        raise FreerockError("laser signal", what, CHECK)
    if low == high:
        raise FreerockError("laser signal", f"constant at {low:.6g} {unit}", CHECK)
    clean = np.where(flags == 0, recorded, np.nan)

    phases = stationary_phases(time_s, clean, window_s=window_s)
    suffix, hum, hum_stderr, noise, wrong_rate = SUFFIX[unit], None, 0.0, math.nan, []
    if phases:
        still = _inside(phases, time_s, clean, window_s / 2)
        noise = _white_noise(*still, step)
    if phases and mains_hz is not None:
        wrong_rate = _wrong_rate(phases, time_s, clean, step, window_s / 2, mains_hz)
    if phases and mains_hz is not None and mains_hz * step < 0.5 and not wrong_rate:
        hum = fit_hum(*still, mains_hz, step)
        if hum and hum.amplitude > max(SURE * hum.amplitude_stderr, FAINT) * noise:
            hum_stderr = hum.stderr * noise
            clean -= hum.over(time_s[0], step, time_s.size)
            phases = stationary_phases(time_s, clean, window_s=window_s)
            noise = _white_noise(*_inside(phases, time_s, clean, window_s / 2), step)
        else:
            hum = None
    rest = [phase for phase in phases if phase.kind == "rest"]
    if not rest:
        raise FreerockError(
            "laser signal",
            "the block never stands still, so θ = 0 is unknown",
            "record the block at rest before the first or after the last release",
        )

    mid, level = [phase.mid_s for phase in rest], np.array([phase.level for phase in rest])
    level_m, slope_m = distance_from_output(level, laser, quantity)
    displacement = np.empty(time_s.size)
    slope = slope_m if np.ndim(slope_m) == 0 else np.empty(time_s.size)
    for part in _pieces(time_s.size):
        distance, slope_of_part = distance_from_output(clean[part], laser, quantity)
        displacement[part] = laser.sign * (distance - np.interp(time_s[part], mid, level_m))
        if np.ndim(slope):
            slope[part] = slope_of_part
    beyond = np.isnan(displacement) & (flags == 0)
    if beyond.any():
        flags[beyond] = FLAGS["out_of_range"]
    per_angle = 1.0
    if quantity != "rotation":
        about_zero = sensitivity(np.array([-1e-12, 1e-12]), block, laser).min()
        per_angle = float(about_zero) if about_zero > BLIND * block.b else math.nan
    per_output = float(np.mean(slope_m)) / per_angle

    faults = flagged_faults(time_s, flags)
    whole = float(time_s[0]), float(time_s[-1])
    if hum:
        note = f"{hum.frequency_hz:.2f} Hz, {hum.amplitude:.3g} {unit}, removed"
        faults.append(Fault("hum", *whole, note, hum.amplitude * per_output))
    faults += wrong_rate
    line = other_line(_segments(phases, time_s, clean, step, window_s / 2), step, mains_hz if hum else None)
    if line and line[1] > FAINT * noise:
        note = f"{line[0]:.1f} Hz, {line[1]:.3g} {unit}, not from the mains: folded, or a vibration"
        faults.append(Fault("aliasing", *whole, note, line[1] * per_output))
    faults += _moved_rests(rest, time_s, clean, noise, step, unit, per_output)
    step_between = float(np.abs(np.diff(level_m)).max(initial=0.0)) / 4
    level_stderr = max(phase.level_stderr for phase in rest) * float(np.max(slope_m))
    attrs = {
        f"noise_{suffix}": noise,
        "hum_hz": hum.frequency_hz if hum else 0.0,
        f"hum_amplitude_{suffix}": hum.amplitude if hum else 0.0,
        f"zero_{suffix}": float(np.mean(level)),
        f"zero_drift_{suffix}": float(np.ptp(level)),
    }
    return _Reading(
        displacement=displacement,
        sigma=math.hypot(noise, hum_stderr) * slope,
        flags=flags,
        faults=faults,
        quantity=quantity,
        recorded=recorded,
        rest_mid_s=mid,
        zero_stderr=math.hypot(level_stderr, step_between),
        per_angle=per_angle,
        attrs=attrs,
    )


def _pieces(n):
    """Slices of n samples, each of what fits the processor's cache."""
    return (slice(start, start + PIECE) for start in range(0, n, PIECE))


def _single(time_s, reading, laser, block):
    """θ and its standard error [rad] from one channel."""
    if reading.quantity == "rotation":
        return reading.displacement, np.where(np.isnan(reading.displacement), np.nan, reading.sigma)
    side = None
    if is_unsigned(block, laser):
        sigma = float(np.nanmax(reading.sigma))
        side = _lobe_sides(-reading.displacement, sigma, time_s, reading.rest_mid_s, laser)
    theta, sigma = np.empty((2, time_s.size))
    sigma[:] = reading.sigma
    for part in _pieces(time_s.size):
        of_part = None if side is None else side[part]
        theta[part] = rotation_from_displacement(reading.displacement[part], block, laser, of_part)
        with np.errstate(divide="ignore", invalid="ignore"):  # infinite where a beam over a corner is blind
            sigma[part] /= sensitivity(theta[part], block, laser)
    return theta, sigma


def _pair(time_s, readings, lasers, block, max_disagreement_deg):
    """θ, its standard error [rad], the translation along the beams [m], and where the two disagree."""
    first, second = readings
    one, other = lasers
    if "rotation" in (first.quantity, second.quantity) or (one.beam, one.face) != (other.beam, other.face):
        raise FreerockError(
            "laser signal", "the two beams differ in kind or in face", "use two of one kind, on one face"
        )
    apart = one.position_m - other.position_m
    if apart == 0:
        raise FreerockError("laser signal", "the two beams are at one position_m", "give both positions")
    theta, sigma, translation = np.empty((3, time_s.size))
    wrong = np.zeros(time_s.size, bool)
    sigma[:] = np.hypot(first.sigma, second.sigma) / abs(apart)
    for part in _pieces(time_s.size):
        displacement = first.displacement[part]
        angle = np.arctan((displacement - second.displacement[part]) / apart)
        angle = -angle if mirrored(one) else angle
        alone = displacement_from_rotation(angle, block, one)
        both = np.isfinite(alone) & on_target(angle, block, other)
        theta[part] = angle = np.where(both, angle, np.nan)
        sigma[part] *= np.cos(angle) ** 2
        translation[part] = displacement - alone
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.abs(translation[part]) / sensitivity(angle, block, one)
            wrong[part] = (error > math.radians(max_disagreement_deg)) & (error > SURE * sigma[part])
    faults, step = [], time_s[1] - time_s[0]
    if wrong.any():
        index = np.flatnonzero(wrong)
        for i, j in stretches(np.diff(index) * step < 0.5) or [(0, index.size - 2)]:
            part = index[i : j + 2]
            angle = float(np.nanmax(np.abs(translation[part]) / sensitivity(theta[part], block, one)))
            largest = 1e3 * float(np.nanmax(np.abs(translation[part])))
            note = f"up to {math.degrees(angle):.2f}°, {largest:.2g} mm"
            faults.append(
                Fault("lasers_disagree", float(time_s[part[0]]), float(time_s[part[-1]]), note, angle)
            )
    return theta, sigma, translation, faults


def _moved_rests(rest, time_s, clean, noise, step, unit, per_output):
    """Rest levels that differ from the one before: by drift if the slopes at rest say so, else shifted."""
    faults, slopes = [], [_slope(phase, time_s, clean, noise, step) for phase in rest]
    for (one, (slope, error)), (two, (slope_2, error_2)) in pairwise(zip(rest, slopes, strict=True)):
        moved, span = two.level - one.level, two.mid_s - one.mid_s
        if abs(moved) < max(SURE * math.hypot(one.level_stderr, two.level_stderr), noise):
            continue
        by_drift = (slope + slope_2) / 2 * span
        unsure = math.hypot(error, error_2) / 2 * span
        drifted = abs(by_drift) > 3 * unsure and abs(moved - by_drift) < 3 * unsure + abs(by_drift)
        name = "drift" if drifted else "rest_shift"
        note = f"{moved:+.3g} {unit}"
        faults.append(Fault(name, one.end_s, two.start_s, note, moved * per_output))
    return faults


def _slope(phase, time_s, clean, noise, step):
    """Slope of the signal within a phase and its standard error, per second."""
    trim = min(0.1, (phase.end_s - phase.start_s) / 4)
    part = slice(*np.searchsorted(time_s, (phase.start_s + trim, phase.end_s - trim)))
    y = clean[part]
    t = time_s[part] - phase.mid_s
    valid = np.isfinite(y)
    t, y = t[valid], y[valid]
    if t.size < 10:
        return 0.0, math.inf
    t = t - t.mean()
    square = float(np.sum(t * t))
    return float(np.sum(t * y)) / square, noise / math.sqrt(square)


def _segments(phases, time_s, clean, step, margin_s):
    """Whole stretches of the still phases, of one length; of a rest after a motion, its second half only."""
    n = round(SEGMENT_S / step)
    found = []
    for first, last in _quiet(phases, time_s, margin_s):
        found += [slice(i, i + n) for i in range(first, last - n + 1, n)]
    kept = found[:: -(-len(found) // MOST_SEGMENTS) or 1]
    parts = [clean[part] for part in kept if np.isfinite(clean[part]).all()]
    return np.array(parts).reshape(-1, n)


def _quiet(phases, time_s, margin_s):
    """First and last sample of the still phases; of a rest after a motion, of its second half."""
    for phase in phases:
        swung = phase.kind != "held" and phase.start_s > time_s[0] + margin_s
        start = phase.mid_s if swung else phase.start_s + margin_s
        yield np.searchsorted(time_s, (start, phase.end_s - margin_s)).tolist()


def _wrong_rate(phases, time_s, clean, step, margin_s, mains_hz):
    """A hum of the mains at another frequency than theirs, by the longest quiet stretch."""
    first, last = max(_quiet(phases, time_s, margin_s), key=lambda ends: ends[1] - ends[0])
    part = slice(first, min(last, first + RATE_SAMPLES))
    seen = mains_ratio(time_s[part], clean[part], mains_hz)
    if seen is None or abs(seen[0] - 1) < MAINS_KEEP + SURE * seen[1]:
        return []
    hum, rate = f"{seen[0] * mains_hz:.2f} Hz", f"{1 / step / seen[0]:.5g} Hz and not {1 / step:.5g} Hz"
    note = f"the mains hum at {hum}: the sampling rate is {rate}, or this is no hum"
    return [Fault("sampling_rate", float(time_s[0]), float(time_s[-1]), note)]


def _inside(phases, time_s, volts, margin_s):
    """Valid samples within the phases, away from their ends: times, and deviations from the phase's level."""
    times, deviations = [], []
    for phase in phases:
        part = slice(*np.searchsorted(time_s, (phase.start_s + margin_s, phase.end_s - margin_s)))
        valid = np.isfinite(volts[part])
        kept = slice(None) if valid.all() else valid
        times.append(time_s[part][kept])
        deviations.append(volts[part][kept] - phase.level)
    return np.concatenate(times), np.concatenate(deviations)


def _white_noise(time_s, deviation, step):
    """Standard deviation of white noise [V] from differences of neighbours, those beyond 6 MADs left out."""
    i = np.arange(0, time_s.size - 1, max(1, time_s.size // NOISE_SAMPLES))
    difference = (deviation[i + 1] - deviation[i])[time_s[i + 1] - time_s[i] < 1.5 * step]
    limit = 6 * np.median(np.abs(difference)) / 0.6745
    return float(np.sqrt(np.mean(difference[np.abs(difference) <= limit] ** 2) / 2))


def _lobe_sides(rise, sigma, time_s, rest_mid_s, laser):
    """Sign of θ for a reading that has none: lobes change side at each touch-down, anew after every rest.

    A lobe is where the rise exceeds 8 σ (or 1 % of its maximum), a touch-down where it falls below half of
    that; what is smaller keeps the side of the lobe before it. Where the next lobe is `LATE` times as long in
    coming as the one before, one was too faint between them, as those of the nearer corner are.
    """
    first = 1.0 if laser.release_side == "positive" else -1.0
    side = np.full(rise.size, first)
    high = max(8 * sigma, 0.01 * np.nanmax(rise))
    smooth = np.convolve(rise, np.full(5, 0.2), "same")  # to tell lobes from noise; θ itself is not smoothed
    index = np.flatnonzero((smooth > high) | (smooth < high / 2))
    lobes = [(index[i], index[j]) for i, j in stretches(smooth[index] > high)]
    sign, interval = first, math.inf
    for (begin, last), (start, end) in pairwise(lobes):
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
