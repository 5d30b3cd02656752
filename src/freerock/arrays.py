"""Names of the arrays that signals, motions and fits are made of; fewer of their samples, for drawing."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Complexes = NDArray[np.complex128]


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
