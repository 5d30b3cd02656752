"""White noise with a slow part, which is autoregressive of the first order, made white: compiled.

The whole call tree is here, since numba's cache notices a change in the file of the cached function only.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from freerock.arrays import Floats
from freerock.models.compiled import compiled


class Slow(NamedTuple):
    """Noise of evenly spaced samples: variances of its white and of its slow part, and the correlation of
    the latter between neighbours."""

    white: float
    slow: float
    kept: float


@compiled(fastmath=False)
def whiten(columns: Floats, place: NDArray[np.int64], law: Slow) -> Floats:
    """Columns less what their earlier samples foretell, over its standard deviation: Kalman's filter (1960,
    doi:10.1115/1.3662552).

    Parameters
    ----------
    columns : ndarray, shape (n_time, n_columns)
    place : ndarray of int, shape (n_time,)
        Increasing number of each sample; some may be missing.
    law : Slow
    """
    gain, scale, decay = _gains(place, law)
    found = np.empty_like(columns)
    foretold = np.zeros(columns.shape[1])
    for i in range(len(place)):
        for j in range(columns.shape[1]):
            foretold[j] *= decay[i]
            new = columns[i, j] - foretold[j]
            foretold[j] += gain[i] * new
            found[i, j] = new / scale[i]
    return found


@compiled(fastmath=False)
def transposed(rows: Floats, place: NDArray[np.int64], law: Slow) -> Floats:
    """Rows times the matrix by which `whiten` acts on columns, shape (n_rows, n_time)."""
    gain, scale, decay = _gains(place, law)
    found = np.empty_like(rows)
    for j in range(rows.shape[0]):
        later = 0.0
        for i in range(len(place) - 1, -1, -1):
            own = rows[j, i] / scale[i]
            found[j, i] = own + gain[i] * later
            later = decay[i] * ((1 - gain[i]) * later - own)
    return found


@compiled(fastmath=False)
def _gains(place: NDArray[np.int64], law: Slow) -> Any:
    """Of each sample the filter's gain, the standard deviation of what is new, and the decay before it."""
    gain, scale, decay = np.empty(len(place)), np.empty(len(place)), np.ones(len(place))
    variance = law.slow
    for i in range(len(place)):
        if i > 0:
            decay[i] = law.kept ** (place[i] - place[i - 1])
            variance = law.slow + decay[i] ** 2 * (variance - law.slow)
        new = variance + law.white
        gain[i], scale[i] = variance / new, np.sqrt(new)
        variance *= 1 - gain[i]
    return gain, scale, decay
