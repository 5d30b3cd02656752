"""Names of the arrays that signals, motions and fits are made of; fewer of their samples, for drawing."""

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


def extremes(values: ArrayLike, n_bins: int = 1000) -> NDArray[np.intp]:
    """Lowest and highest sample of each bin, so that no spike is lost by drawing fewer samples.

    Parameters
    ----------
    values : array_like, shape (n_samples,)
        Samples; NaN where there is none.
    n_bins : int
        Bins.

    Returns
    -------
    ndarray of int
        Indices to draw, in order.
    """
    values = np.asarray(values)
    width = max(1, -(-len(values) // n_bins))
    whole = len(values) // width * width
    parts = [(0, values[:whole].reshape(-1, width)), (whole, values[whole:].reshape(1, -1))]
    kept = [np.empty(0, np.intp)]
    for start, bins in parts:
        if bins.size:
            first = start + bins.shape[1] * np.arange(len(bins))
            missing = np.isnan(bins) if values.dtype.kind == "f" else np.zeros(1, bool)
            holes = bool(missing.any())
            low = np.where(missing, np.inf, bins) if holes else bins
            high = np.where(missing, -np.inf, bins) if holes else bins
            kept += [first + low.argmin(axis=1), first + high.argmax(axis=1)]
    return np.unique(np.concatenate(kept))
