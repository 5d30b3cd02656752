"""Laser volts to rotation: θ(t) with its uncertainty and its flags.

Kinematics: the block turns as a rigid body about a base corner, as a real block on a hard base does. (The
foundation models restrain the base centre instead; the two differ by b(1 - cos θ) horizontally.)
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.phases import stationary_phases, stretches

FLAGS = {"error_level": 1, "out_of_range": 2, "saturated": 4, "target_lost": 8}

SATURATED_RUN = 5  # equal samples in a row at an extreme of the record
MAINS_BAND_HZ = 0.1  # the mains frequency is sought this far either side of its nominal value
MAINS_HARMONICS = 3


@dataclass(frozen=True)
class Laser:
    """A triangulation laser and where its beam meets the block.

    Parameters
    ----------
    beam : str
        "horizontal" (meets a side face) or "vertical" (meets the top from above).
    position_m : float
        Height Y of a horizontal beam above the base plane, or distance X of a vertical beam to the right of
        the block's centre line at rest [m].
    range_m : float
        Measuring range between `volts_at_start` and `volts_at_end` [m].
    face : str
        "left" or "right": face met by a horizontal beam.
    sign : int
        +1 when the volts grow with the distance from the sensor, -1 when they fall.
    release_side : str
        "positive" (clockwise) or "negative": side of the first lobe after every rest; used only where the
        reading has no sign, for a vertical beam between the corners.
    volts_at_start, volts_at_end : float
        Output at the start and at the end of the measuring range [V].
    valid_low_v, valid_high_v : float
        Limits of valid output [V].
    error_level_v, error_tolerance_v : float
        Output that means "no target" and its tolerance [V].

    Raises
    ------
    FreerockError
        A value that no sensor has.
    """

    beam: str
    position_m: float
    range_m: float
    face: str = "left"
    sign: int = 1
    release_side: str = "positive"
    volts_at_start: float = 0.0
    volts_at_end: float = 10.0
    valid_low_v: float = -0.1
    valid_high_v: float = 10.1
    error_level_v: float = 10.2
    error_tolerance_v: float = 0.01

    def __post_init__(self):
        for key, choices in _CHOICES.items():
            if getattr(self, key) not in choices:
                raise FreerockError(
                    f"laser.{key}",
                    f"{getattr(self, key)!r} is unknown",
                    f"use one of {', '.join(map(str, choices))}",
                )
        if self.beam == "horizontal" and not self.position_m > 0:
            raise FreerockError("laser.position_m", f"height {self.position_m} m", "give a height above 0")
        if not self.range_m > 0:
            raise FreerockError("laser.range_m", f"range {self.range_m} m", "give a range above 0")
        if not self.volts_at_end > self.volts_at_start:
            raise FreerockError(
                "laser.volts_at_end",
                "not above volts_at_start",
                "give the output at both ends; use sign: -1 to invert",
            )

    @property
    def metres_per_volt(self) -> float:
        """Distance from the sensor per volt, with its sign [m/V]."""
        return self.sign * self.range_m / (self.volts_at_end - self.volts_at_start)


_CHOICES = {
    "beam": ("horizontal", "vertical"),
    "face": ("left", "right"),
    "sign": (1, -1),
    "release_side": ("positive", "negative"),
}


def displacement_from_rotation(theta, block: Block, laser: Laser):
    """Displacement of the target along the beam, positive away from the sensor, of a block that has turned.

    Origin under the base centre at rest, x to the right, y up. A block turned by θ > 0 about its right
    corner (b, 0) has its left face on x = b - 2b/cos θ + y tan θ and its top on
    y = 2h/cos θ + (b - x) tan θ; turned by θ < 0 about its left corner it has its left face on
    x = -b - y tan|θ| and its top on y = 2h/cos θ + (b + x) tan|θ|. The right face mirrors the left one.
    From there, with T = |θ|, for the left face at height Y and the top at X::

        left face   s = Y tan T - 2b (1/cos T - 1)   (θ > 0)      s = -Y tan T   (θ < 0)
        top         -s = 2h (1/cos T - 1) + a tan T,   a = b - X  (θ > 0),  a = b + X  (θ < 0)

    The beam is on the left face while 2b sin θ <= Y <= 2b sin θ + 2h cos θ (θ > 0; the lower edge rises)
    and Y <= 2h cos θ (θ < 0; the upper edge sinks). With |X| < b the vertical beam is on the top while
    b - X <= 2b cos θ - 2h sin θ (θ > 0; mirrored for θ < 0). With |X| >= b the target is an outrigger level
    with the top, as long as need be outwards, that begins at the block's edge: there the beam is on it
    while 2h sin θ <= X - b (X, θ > 0; mirrored for X, θ < 0), and always when the other side goes down.

    Parameters
    ----------
    theta : array_like
        Rotation [rad], positive clockwise.
    block : Block
    laser : Laser

    Returns
    -------
    ndarray
        Displacement [m]; NaN where the beam is off the target.
    """
    theta = np.asarray(theta, float)
    turn = -theta if _mirrored(laser) else theta
    t = np.abs(turn)
    rise = 2 * np.sin(t / 2) ** 2 / np.cos(t)  # 1/cos - 1 without loss of digits
    if laser.beam == "horizontal":
        s = laser.position_m * np.tan(turn) - np.where(turn > 0, block.width_m * rise, 0.0)
    else:
        s = -(block.height_m * rise + _lever(turn, block, laser) * np.tan(t))
    return np.where(_on_target(turn, block, laser), s, np.nan)


def rotation_from_displacement(displacement_m, block: Block, laser: Laser, side=None):
    """Rotation of the block from the displacement of its target, inverting `displacement_from_rotation`.

    With T = tan(|θ|/2) the closed forms are quadratics in T, solved without loss of digits::

        horizontal  T = s / (Y + sqrt(Y² + s² - 4bs))   (s > 0)     T = s / (Y + sqrt(Y² + s²))   (s < 0)
        top         T = q / (a ± sqrt(a² + q (4h + q))),  q = -s, the sign of the root that of a

    Parameters
    ----------
    displacement_m : array_like
        Displacement [m], positive away from the sensor.
    block : Block
    laser : Laser
    side : array_like, optional
        +1 or -1: sign of θ of each sample, needed only for a vertical beam with |X| < b, whose reading is the
        same for both; `laser.release_side` throughout by default.

    Returns
    -------
    ndarray
        Rotation [rad], positive clockwise; NaN where the beam would be off the target, see there.
    """
    s = np.asarray(displacement_m, float)
    with np.errstate(invalid="ignore", divide="ignore"):
        if laser.beam == "horizontal":
            y = laser.position_m
            turn = 2 * np.arctan(s / (y + np.sqrt(y**2 + s**2 - 2 * block.width_m * np.maximum(s, 0.0))))
        else:
            side = (
                _side(s, block, laser) if side is None or not is_unsigned(block, laser) else np.asarray(side)
            )
            a = _lever(side, block, laser)
            root = np.copysign(np.sqrt(a**2 + s * (s - 2 * block.height_m)), a)
            turn = 2 * side * np.arctan(-s / (a + root))
        turn = np.where(_on_target(turn, block, laser), turn, np.nan)
    return -turn if _mirrored(laser) else turn


def is_unsigned(block: Block, laser: Laser) -> bool:
    """Whether the reading is the same for θ and -θ: a vertical beam between the corners."""
    return laser.beam == "vertical" and abs(laser.position_m) < block.b


def sensitivity(theta, block: Block, laser: Laser):
    """|ds/dθ|: displacement of the target per rotation [m/rad], by differentiating the closed forms."""
    turn = -np.asarray(theta, float) if _mirrored(laser) else np.asarray(theta, float)
    lift = np.sin(np.abs(turn))
    if laser.beam == "horizontal":
        slope = laser.position_m - np.where(turn > 0, block.width_m * lift, 0.0)
    else:
        slope = _lever(turn, block, laser) + block.height_m * lift
    return np.abs(slope) / np.cos(turn) ** 2


def _mirrored(laser: Laser) -> bool:
    return laser.beam == "horizontal" and laser.face == "right"


def _lever(turn, block, laser):
    """Horizontal distance a of a vertical beam from the corner turned about, towards the block."""
    return np.where(turn > 0, block.b - laser.position_m, block.b + laser.position_m)


def _side(s, block, laser):
    """Sign of θ told by a vertical reading: by its own sign on an outrigger, else the release side."""
    if is_unsigned(block, laser):
        return np.full(s.shape, 1.0 if laser.release_side == "positive" else -1.0)
    return np.where(s > 0, 1.0, -1.0) * np.sign(laser.position_m)  # what is lowered turns towards the beam


def _on_target(turn, block, laser):
    t = np.abs(turn)
    lift = np.sin(t)
    if laser.beam == "horizontal":
        foot = np.where(turn > 0, block.width_m * lift, 0.0)
        return (foot <= laser.position_m) & (laser.position_m <= foot + block.height_m * np.cos(t))
    a = _lever(turn, block, laser)
    if is_unsigned(block, laser):
        return a <= block.width_m * np.cos(t) - block.height_m * lift
    return (a > 0) | (block.height_m * lift <= -a)


def distance_from_volts(volts, laser: Laser):
    """Distance of the target from the start of the measuring range [m] (from its end where `sign` is -1)."""
    return (np.asarray(volts, float) - laser.volts_at_start) * abs(laser.metres_per_volt)


def flag_volts(volts, laser: Laser):
    """Flag invalid samples, before anything else is done to them.

    Parameters
    ----------
    volts : ndarray, shape (n_time,)
        Sensor output [V].
    laser : Laser

    Returns
    -------
    ndarray of uint8, shape (n_time,)
        Sum of `FLAGS`: "error_level" (the sensor reports no target), "out_of_range" (outside the valid
        output, or not a number), "saturated" (at least five samples in a row equal to the record's largest
        or smallest valid one, reached or left abruptly, unless samples repeat elsewhere too: a coarse
        converter). 0 is valid.
    """
    volts = np.asarray(volts, float)
    error = np.abs(volts - laser.error_level_v) <= laser.error_tolerance_v
    outside = ~error & ~((volts >= laser.valid_low_v) & (volts <= laser.valid_high_v))
    flags = error * np.uint8(FLAGS["error_level"]) + outside * np.uint8(FLAGS["out_of_range"])

    valid = flags == 0
    if valid.any():
        extreme = valid & ((volts == volts[valid].min()) | (volts == volts[valid].max()))
        usable = np.concatenate(([np.nan], np.where(valid, volts, np.nan), [np.nan]))
        jump = np.abs(np.diff(usable))  # into each sample, and out of the last
        usual = jump[1:-1][~(extreme[1:] & extreme[:-1]) & np.isfinite(jump[1:-1])]
        if np.count_nonzero(usual == 0) <= 0.01 * usual.size:
            abrupt = 0.1 * np.median(usual) if usual.size else 0.0
            for first, last in stretches(extreme):
                clipped = jump[first] >= abrupt or jump[last + 1] >= abrupt
                if clipped and last - first + 1 >= SATURATED_RUN:
                    flags[first : last + 1] |= FLAGS["saturated"]
    return flags


def rotation(
    time_s, volts, laser: Laser, block: Block, *, mains_hz: float | None = 50.0, window_s: float = 0.25
):
    """Rotation of the block from the volts of its laser, with uncertainty and flags.

    In this order: invalid samples are flagged; hum at the mains frequency and its harmonics, fitted as
    sinusoids to the stationary phases, is subtracted (no filter, so no delay); the reading at rest is θ = 0,
    interpolated linearly between rest phases and constant outside them; the displacement is inverted in
    closed form. The standard error is that of one sample, from the white noise in the stationary phases; the
    error of the zero, common to all samples, stands apart in `zero_stderr_rad`.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Evenly spaced time [s].
    volts : ndarray, shape (n_time,)
        Sensor output [V].
    laser : Laser
    block : Block
    mains_hz : float or None
        Nominal mains frequency [Hz]; None leaves hum alone.
    window_s : float
        Window of `stationary_phases` [s].

    Returns
    -------
    xarray.Dataset
        Over dimension time: theta [rad] and sigma_theta [rad] (NaN where flagged), flags (sum of `FLAGS`),
        voltage [V] as recorded. Attributes: sampling_rate_hz, noise_v (white), hum_hz and hum_amplitude_v (0
        if off), rest_phases (their number), zero_v (mean reading at rest), zero_drift_v (its range),
        zero_stderr_rad.

    Raises
    ------
    FreerockError
        Uneven time; no valid sample; a constant signal; no rest phase.
    """
    import xarray as xr

    time_s, volts = np.asarray(time_s, float), np.asarray(volts, float)
    step = _even_step(time_s, volts)
    flags = flag_volts(volts, laser)
    _refuse_useless(volts, flags, laser)
    clean = np.where(flags == 0, volts, np.nan)

    phases = stationary_phases(time_s, clean, window_s=window_s)
    hum_hz, hum_v = 0.0, 0.0
    if phases and mains_hz is not None and mains_hz * step < 0.5:
        hum_hz, hum_v, hum = _fit_hum(*_inside(phases, time_s, clean, window_s / 2), mains_hz, step)
        clean -= hum(time_s)
        phases = stationary_phases(time_s, clean, window_s=window_s)
    rest = [phase for phase in phases if phase.kind == "rest"]
    if not rest:
        raise FreerockError(
            "laser signal",
            "the block never stands still, so θ = 0 is unknown",
            "record the block at rest before the first or after the last release",
        )
    still, deviation = _inside(phases, time_s, clean, window_s / 2)
    noise_v = _white_noise(still, deviation, step)
    mid, level = [phase.mid_s for phase in rest], [phase.level for phase in rest]
    displacement = (clean - np.interp(time_s, mid, level)) * laser.metres_per_volt
    scale = abs(laser.metres_per_volt)

    side = (
        _lobe_sides(-displacement, noise_v * scale, time_s, mid, laser) if is_unsigned(block, laser) else None
    )
    theta = rotation_from_displacement(displacement, block, laser, side)
    flags[np.isnan(theta) & (flags == 0)] = FLAGS["target_lost"]
    with np.errstate(
        divide="ignore", invalid="ignore"
    ):  # a beam over a corner is blind to one side: infinite error
        sigma = noise_v * scale / sensitivity(theta, block, laser)
        about_zero = sensitivity(np.array([-1e-12, 1e-12]), block, laser).min()
        zero_stderr = max(phase.level_stderr for phase in rest) * scale / about_zero

    return xr.Dataset(
        {
            "theta": ("time", theta, _THETA_ATTRS),
            "sigma_theta": (
                "time",
                sigma,
                {"units": "rad", "long_name": "standard error of one sample of rotation"},
            ),
            "flags": ("time", flags, _FLAG_ATTRS),
            "voltage": ("time", volts, {"units": "V", "long_name": "laser output as recorded"}),
        },
        coords={"time": ("time", time_s, {"units": "s", "long_name": "time from the start of the record"})},
        attrs={
            "sampling_rate_hz": 1 / step,
            "noise_v": noise_v,
            "hum_hz": hum_hz,
            "hum_amplitude_v": hum_v,
            "rest_phases": len(rest),
            "zero_v": float(np.mean(level)),
            "zero_drift_v": float(np.ptp(level)),
            "zero_stderr_rad": float(zero_stderr),
        },
    )


_THETA_ATTRS = {
    "units": "rad",
    "long_name": "rotation of the block, positive clockwise",
    "ancillary_variables": "sigma_theta flags",
}
_FLAG_ATTRS = {
    "long_name": "why a sample is invalid (0: valid)",
    "flag_masks": np.array(list(FLAGS.values()), np.uint8),
    "flag_meanings": " ".join(FLAGS),
}


def _even_step(time_s, volts):
    """Sampling interval [s] of an evenly spaced record."""
    if time_s.shape != volts.shape or time_s.ndim != 1 or time_s.size < 2:
        raise FreerockError(
            "laser signal",
            f"time has shape {time_s.shape} and volts {volts.shape}",
            "give two arrays of one equal length, of at least two samples",
        )
    step = float(time_s[-1] - time_s[0]) / (time_s.size - 1)
    even = time_s[0] + step * np.arange(time_s.size)
    if not (step > 0 and np.all(np.abs(time_s - even) < step)):
        raise FreerockError(
            "laser signal", "time is not evenly spaced", "resample it, or correct the sampling rate"
        )
    return step


def _refuse_useless(volts, flags, laser):
    """Refuse a signal that carries no rotation at all."""
    remedy = "check the channel, the cable and the sensor's range"
    finite = volts[np.isfinite(volts)]
    if finite.size == 0:
        raise FreerockError("laser signal", "no sample is a number", remedy)
    if flags.all() and np.any(flags != FLAGS["saturated"]):
        shares = [
            f"{np.mean(flags & mask > 0):.0%} {name}" for name, mask in FLAGS.items() if (flags & mask).any()
        ]
        raise FreerockError(
            "laser signal",
            f"no sample within {laser.valid_low_v:g} to {laser.valid_high_v:g} V ({', '.join(shares)})",
            remedy,
        )
    if np.ptp(finite) == 0:
        raise FreerockError("laser signal", f"constant at {finite[0]:.6g} V", remedy)


def _inside(phases, time_s, volts, margin_s):
    """Valid samples within the phases, away from their ends: times, and deviations from the phase's level."""
    times, deviations = [], []
    for phase in phases:
        part = slice(*np.searchsorted(time_s, (phase.start_s + margin_s, phase.end_s - margin_s)))
        valid = np.isfinite(volts[part])
        times.append(time_s[part][valid])
        deviations.append(volts[part][valid] - phase.level)
    return np.concatenate(times), np.concatenate(deviations)


def _fit_hum(time_s, deviation, mains_hz, step):
    """Fit mains hum: its frequency and fundamental amplitude, and the function of time that gives its volts.

    The frequency is the peak of the periodogram near the nominal one; with it, amplitudes and phases of the
    fundamental and its harmonics follow by linear least squares.
    """
    block = max(1, round(0.1 / step))  # demodulated and averaged over 0.1 s first: cheap, and as sharp
    n = time_s.size // block * block
    span = time_s[-1] - time_s[0]
    beat = (deviation[:n] * np.exp(-2j * np.pi * mains_hz * time_s[:n])).reshape(-1, block).mean(axis=1)
    centre = time_s[:n].reshape(-1, block).mean(axis=1)
    reach = int(np.ceil(8 * span * MAINS_BAND_HZ))
    offsets = np.arange(-reach - 1, reach + 2) / (8 * span)
    power = np.array([abs(np.sum(beat * np.exp(-2j * np.pi * offset * centre))) ** 2 for offset in offsets])
    top = 1 + int(np.argmax(power[1:-1]))
    below, peak, above = power[top - 1 : top + 2]
    curvature = below - 2 * peak + above
    shift = np.clip(0.5 * (below - above) / curvature, -0.5, 0.5) if curvature < 0 else 0.0
    hum_hz = mains_hz + offsets[top] + shift / (8 * span)

    harmonics = [m for m in range(1, MAINS_HARMONICS + 1) if m * hum_hz * step < 0.5]
    columns = [part(2 * np.pi * m * hum_hz * time_s) for m in harmonics for part in (np.cos, np.sin)]
    basis = np.stack(columns, axis=1)
    weights = np.linalg.lstsq(basis.T @ basis, basis.T @ deviation, rcond=None)[0]
    cosines, sines = weights[::2], weights[1::2]

    def hum(t):
        angle = 2 * np.pi * hum_hz * t
        parts = zip(harmonics, cosines, sines, strict=True)
        return sum(c * np.cos(m * angle) + s * np.sin(m * angle) for m, c, s in parts)

    return float(hum_hz), float(np.hypot(cosines[0], sines[0])), hum


def _white_noise(time_s, deviation, step):
    """Standard deviation of white noise [V] from differences of neighbours, those beyond 6 MADs left out."""
    difference = np.diff(deviation)[np.diff(time_s) < 1.5 * step]
    limit = 6 * np.median(np.abs(difference)) / 0.6745
    return float(np.sqrt(np.mean(difference[np.abs(difference) <= limit] ** 2) / 2))


def _lobe_sides(rise, sigma, time_s, rest_mid_s, laser):
    """Sign of θ for a reading that has none: lobes change side at each touch-down, anew after every rest.

    A lobe is where the rise exceeds 8 σ (or 1 % of its maximum), a touch-down where it falls below half of
    that; what is smaller keeps the side of the lobe before it.
    """
    first = 1.0 if laser.release_side == "positive" else -1.0
    side = np.full(rise.size, first)
    high = max(8 * sigma, 0.01 * np.nanmax(rise))
    smooth = np.convolve(rise, np.full(5, 0.2), "same")  # to tell lobes from noise; θ itself is not smoothed
    index = np.flatnonzero((smooth > high) | (smooth < high / 2))
    lobes = [(index[i], index[j]) for i, j in stretches(smooth[index] > high)]
    sign = first
    for (_, last), (start, _) in pairwise(lobes):
        rested = any(time_s[last] < mid < time_s[start] for mid in rest_mid_s)
        sign = first if rested else -sign
        side[last + int(np.nanargmin(rise[last : start + 1])) :] = sign
    return side
