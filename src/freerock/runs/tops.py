"""The peaks of a motion, from which a block moves on like one released from rest."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats

STANDS_OUT = 5.0  # standard deviations of the noise, from which on a swing is one
MIDDLE = 0.2  # of a swing on either side is left out where its top is looked for
TOP_STDERR_S = 2e-3  # of the instant of a top
TOP_STDERR = 2e-3  # of its height, as a share


class Top(NamedTuple):
    """The top of a swing: when [s], how high with its sign [rad], from when to when the swing lasts [s]."""

    time_s: float
    height: float
    start_s: float
    end_s: float


def find_tops(time_s: Floats, theta: Floats, sigma_theta: float, lowest: float) -> list[Top]:
    """The tops of the swings after the first, as long as they are higher than `lowest` [rad].

    Time [s] and rotation [rad] of shape (n_time,), NaN where unknown; sigma_theta is the standard deviation
    of the noise [rad].
    """
    known = np.isfinite(theta)
    t, theta = time_s[known], theta[known]
    clear = np.flatnonzero(np.abs(theta) > STANDS_OUT * sigma_theta)
    begins = clear[1:][np.diff(theta[clear] > 0)]
    found = []
    for first, last in pairwise(begins):
        margin = int(MIDDLE * (last - first))
        instants, arc = t[first + margin : last - margin], theta[first + margin : last - margin]
        if instants.size < 6:
            break
        fitted = np.polynomial.Polynomial.fit(instants, arc, 4)(instants)
        top = int(np.argmax(np.abs(fitted)))
        if abs(fitted[top]) < lowest:
            break
        found.append(Top(float(instants[top]), float(fitted[top]), float(t[first]), float(t[last])))
    return found
