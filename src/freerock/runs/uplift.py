"""The amplitude under which the base of a block stays in full contact, from the tail of its own motion."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block

TAIL_SWINGS = 2  # full contact is believed when this many swings stay in it


def uplift_amplitude(t: Floats, theta: Floats, passages: Sequence[float], block: Block) -> float:
    """Amplitude [rad] under which the base stays in full contact, 0 if no swing is that low.

    The half period T of the tail, which does not depend on amplitude, gives it:
    (2/3) b³ k - m g h = I₀ (π/T)² gives k, hence the static sink m g/(2 b k) and asin(sink/b) (linearised
    no-uplift equations (1)-(2) of Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024).

    Each swing between two passages through zero is tried. Its half period, taken as that of full contact,
    gives an uplift amplitude, and the swing is in full contact if it is lower than that. Any other
    swing gives too small a value (on a rigid base about a quarter of its height), so it excludes itself.
    """
    weight = block.weight
    found = []
    for start, end in pairwise(passages):
        stiffness = block.inertia_base * (math.pi / (end - start)) ** 2 + weight * block.h  # (2/3) b³ k
        sink = weight * block.b**2 / (3 * stiffness)
        uplift = math.asin(min(1.0, sink / block.b))
        swing = slice(*np.searchsorted(t, (start, end)))
        if math.pi / 2 * abs(theta[swing].mean()) < uplift:  # the height of half a sine
            found.append(uplift)
    return float(np.median(found)) if len(found) >= TAIL_SWINGS else 0.0
