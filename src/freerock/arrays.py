"""Names of the arrays that signals, motions and fits are made of."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freerock.errors import FreerockError

Floats = NDArray[np.float64]
Flags = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Complexes = NDArray[np.complex128]

SLOWEST_S = 0.05  # a longer sampling interval shows no rocking
BEYOND, FEW = 2.0, 0.01  # rad, no block lies there; share of the samples that may, as glitches


def numbers(where: str, values: Any) -> Floats:
    """An array of floats; raises where they are none."""
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError):
        raise FreerockError(where, "holds no numbers", "give an array of numbers") from None


def increasing(time_s: ArrayLike) -> Floats:
    """Instants as an array, shape (n_time,); raises where they do not increase."""
    instants = numbers("time", time_s)
    if instants.ndim != 1 or not (np.diff(instants) > 0).all():
        raise FreerockError("time", "does not increase", "give one array, sort it and drop NaN")
    return instants


def sampled(time_s: ArrayLike, theta: ArrayLike) -> tuple[Floats, Floats]:
    """Time [s] and θ [rad] as arrays, shape (n_time,); NaN is allowed in θ alone.

    Raises
    ------
    FreerockError
        No numbers, arrays of two lengths, a time that does not increase, or other units.
    """
    instants, angles = increasing(time_s), numbers("theta", theta)
    if instants.shape != angles.shape:
        what = f"have the shapes {instants.shape} and {angles.shape}"
        raise FreerockError("time and theta", what, "give two arrays of one length")
    if instants.size > 1 and np.median(np.diff(instants)) > SLOWEST_S:
        raise FreerockError("time", "its steps are too long for rocking", "give it in seconds")
    if np.count_nonzero(np.abs(angles) > BEYOND) > FEW * angles.size:
        raise FreerockError("theta", f"turns by more than {BEYOND:g} rad", "give it in rad")
    return instants, angles
