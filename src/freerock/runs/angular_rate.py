"""Angular rate of a sampled rotation."""

import numpy as np

from freerock.arrays import Floats

WINDOW_S = 0.02  # short beside a swing, long beside a sample


def angular_rate(time_s: Floats, theta: Floats, window_s: float = WINDOW_S) -> Floats:
    """Angular rate from a parabola around each sample.

    Parameters
    ----------
    time_s, theta : ndarray, shape (n_time,)
        Equally spaced instants [s] and rotation [rad]; NaN where a sample is missing.
    window_s : float
        Length of the parabola [s]; at least five samples.

    Returns
    -------
    ndarray, shape (n_time,)
        [rad/s]; NaN beside a missing sample, and everywhere in a motion no longer than the window.
    """
    step = np.median(np.diff(time_s)) if len(time_s) > 1 else np.inf
    window = max(5, 2 * round(window_s / step / 2) + 1)
    if len(time_s) <= window:
        return np.full(len(time_s), np.nan)
    half = window // 2
    lever = np.arange(-half, half + 1.0)
    around = np.pad(theta, half, mode="edge")
    return np.asarray(np.correlate(around, lever, "valid") / (step * lever @ lever))
