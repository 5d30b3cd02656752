"""Motion of the ground under the block: sampled accelerograms and analytic pulses.

Both are segments on which the acceleration is linear plus a harmonic, so that an integrator can stop
where the motion is not smooth and evaluate it exactly elsewhere. A positive horizontal acceleration
keeps the sign of eq. (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024): the ground
accelerates to the left, and the block tilts clockwise, to the right. A positive vertical
acceleration is upward.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import GRAVITY

PULSES = ("sine", "half_sine", "cosine")
VARYING = (1, 2, 6, 7)  # coefficients of what changes in time


@dataclass(frozen=True)
class GroundMotion:
    """Ground acceleration by segments; the ground is still before the first and after the last.

    With τ since the start of a segment, each component is
    c0 + c1 τ + A sin(ω τ + φ).

    Parameters
    ----------
    breaks : ndarray, shape (n_segments + 1,)
        Increasing instants at which segments begin and end [s].
    coefficients : ndarray, shape (n_segments, 10)
        c0, c1, A, ω, φ of the horizontal acceleration ẍ_g, then of the vertical z̈_g [SI].
    """

    breaks: np.ndarray
    coefficients: np.ndarray

    def leans(self, time: Floats, gravity: float) -> bool:
        """Whether it is that of a base that leans (`tilted`), from t = 0 to the last of the instants [s]: one
        horizontal acceleration that stays, and less gravity."""
        if len(self.coefficients) != 1:
            return False
        along, less = self.coefficients[0, [0, 5]]
        spans = self.breaks[0] <= 0 and self.breaks[1] > time[-1] and not self.coefficients[0, VARYING].any()
        return bool(spans and along and -gravity < less <= 0)

    def __call__(self, time: ArrayLike) -> Floats:
        """Accelerations ẍ_g and z̈_g [m/s²], shape (2, n_time), at instants [s] of shape (n_time,)."""
        time = np.asarray(time, dtype=float)
        segment = np.searchsorted(self.breaks, time, side="right") - 1
        moving = (segment >= 0) & (segment < len(self.coefficients))
        tau = np.where(moving, time - self.breaks[np.maximum(segment, 0)], 0.0)
        c = self.coefficients[np.where(moving, segment, 0)].T.reshape(2, 5, *time.shape)
        return np.where(moving, c[:, 0] + tau * c[:, 1] + c[:, 2] * np.sin(c[:, 3] * tau + c[:, 4]), 0.0)


def accelerogram(
    time_s: ArrayLike,
    x: ArrayLike | None = None,
    z: ArrayLike | None = None,
) -> GroundMotion:
    """Ground motion from a sampled record, linear between the samples.

    Parameters
    ----------
    time_s : array_like, shape (n,)
        Increasing instants [s]; the ground is still outside them.
    x, z : array_like, shape (n,), optional
        Horizontal (the ground to the left positive) and vertical (upward positive) acceleration [m/s²].

    Raises
    ------
    FreerockError
        Times that do not increase, samples that are not finite or of another length.

    Examples
    --------
    >>> motion = accelerogram([0.0, 0.1, 0.2], x=[0.0, 2.0, 0.0])
    >>> motion([0.05, 0.15, 0.3])[0].round(3).tolist()
    [1.0, 1.0, 0.0]
    """
    time = np.array(time_s, dtype=float)
    if time.ndim != 1 or time.size < 2 or not np.all(np.diff(time) > 0):
        raise FreerockError("time_s", "not an increasing array of two or more instants", "sort the record")
    coefficients = np.zeros((time.size - 1, 10))
    for name, values, column in (("x", x, 0), ("z", z, 5)):
        if values is None:
            continue
        values = np.asarray(values, dtype=float)
        if values.shape != time.shape or not np.all(np.isfinite(values)):
            raise FreerockError(
                name, f"not {time.size} finite accelerations", "give one sample [m/s²] for each instant"
            )
        coefficients[:, column] = values[:-1]
        coefficients[:, column + 1] = np.diff(values) / np.diff(time)
    return GroundMotion(time, coefficients)


def tilted(tilt_rad: float, until_s: float, gravity: float = GRAVITY) -> GroundMotion:
    """What gravity [m/s²] does on a base off level, from before the release up to an instant [s] and beyond.

    Along a base that leans to the right by τ, and so sees the block tilted clockwise, gravity is g sin τ,
    across it g cos τ.
    """
    coefficients = np.zeros((1, 10))
    coefficients[0, 0] = gravity * math.sin(tilt_rad)
    coefficients[0, 5] = -2 * gravity * math.sin(tilt_rad / 2) ** 2
    return GroundMotion(np.array([-1.0, max(until_s, 0.0) + 1.0]), coefficients)


def pulse(
    shape: str,
    period_s: float,
    *,
    x: float = 0.0,
    z: float = 0.0,
    start_s: float = 0.0,
) -> GroundMotion:
    """Analytic pulse.

    Parameters
    ----------
    shape : str
        "sine" (one cycle), "half_sine" (half a cycle) or "cosine" (one cycle).
    period_s : float
        Period T [s].
    x, z : float
        Amplitudes of the horizontal and vertical acceleration [m/s²].
    start_s : float
        Instant of the start [s].

    Raises
    ------
    FreerockError
        Unknown shape, or a period that is not positive.

    Examples
    --------
    >>> pulse("sine", 0.5, x=3.0)([0.125, 0.5]).round(6).tolist()
    [[3.0, 0.0], [0.0, 0.0]]
    """
    if shape not in PULSES:
        raise FreerockError("shape", f"unknown pulse {shape!r}", f"use one of {', '.join(PULSES)}")
    if not period_s > 0:
        raise FreerockError("period_s", "the pulse has no length", "give a positive period")
    cycles = 0.5 if shape == "half_sine" else 1.0
    harmonic = (0.0, 0.0, 1.0, 2 * math.pi / period_s, 0.5 * math.pi if shape == "cosine" else 0.0)
    row = np.array([harmonic, harmonic])
    row[:, 2] = x, z
    return GroundMotion(np.array([start_s, start_s + cycles * period_s]), row.reshape(1, 10))
