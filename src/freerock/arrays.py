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


def numbers(where: str, values: Any) -> Floats:
    """An array of floats; raises where they are none."""
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError):
        raise FreerockError(where, "holds no numbers", "give an array of numbers") from None


def sampled(time_s: ArrayLike, theta: ArrayLike) -> tuple[Floats, Floats]:
    """Time [s] and θ [rad] as arrays, shape (n_time,); NaN is allowed in θ alone.

    Raises
    ------
    FreerockError
        No numbers, arrays of two lengths, or a time that does not increase.
    """
    instants, angles = numbers("time", time_s), numbers("theta", theta)
    if instants.ndim != 1 or instants.shape != angles.shape:
        what = f"have the shapes {instants.shape} and {angles.shape}"
        raise FreerockError("time and theta", what, "give two arrays of one length")
    if not (np.diff(instants) > 0).all():
        raise FreerockError("time", "does not increase", "sort it and drop NaN")
    return instants, angles
