"""θ(t) from one laser, or from a channel that holds the rotation itself."""

import math
from itertools import pairwise

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.rotation.beam import is_unsigned, rotation_and_sensitivity
from freerock.rotation.reading import Reading, Rotation, pieces
from freerock.rotation.sensor import Laser
from freerock.rotation.still import stretches

LATE = 1.5  # times the interval between the swings before: one was missed
AROUND = 3  # samples on either side: a mean of samples moves more slowly at a touch-down than beside it
OTHER_SIDE = 0.25  # of the faster side, that the other side of a touch-down moves: one outlier flips no sign


def rotation_of_one(time_s: Floats, reading: Reading, laser: Laser, block: Block) -> Rotation:
    """θ from one channel, time_s of shape (n_time,) [s]; NaN where the beam does not meet the block.

    It takes the place of the reading's displacement.
    """
    zero_stderr = reading.zero_stderr / reading.per_angle
    if reading.quantity == "rotation":
        theta = reading.displacement
        return Rotation(theta, np.where(np.isnan(theta), np.nan, reading.sigma), zero_stderr)
    side = None
    if is_unsigned(block, laser):
        largest = float(np.nanmax(reading.sigma))
        side = _swing_sides(-reading.displacement, largest, time_s, reading.rest_mid_s, laser)
    theta, sigma = reading.displacement, np.empty(time_s.size)  # a long record is not held twice
    of_reading = np.broadcast_to(reading.sigma, time_s.size)
    for part in pieces(time_s.size):
        of_part = None if side is None else side[part]
        theta[part], slope = rotation_and_sensitivity(reading.displacement[part], block, laser, of_part)
        with np.errstate(divide="ignore", invalid="ignore"):  # infinite where a beam over a corner is blind
            np.divide(of_reading[part], slope, out=sigma[part])
    return Rotation(theta, sigma, zero_stderr)


def _swing_sides(rise: Floats, sigma: float, time_s: Floats, rest_mid_s: list[float], laser: Laser) -> Floats:
    """Sign of θ for a reading that has none: swings change side at each touch-down, anew after every rest.

    A swing is where the rise exceeds 8 σ (or 1 % of its maximum), a touch-down where it falls below half of
    that; as no sample may lie there, also where it falls below twice the largest step around it. What is
    smaller keeps the side of the swing before it. Where the next swing takes `LATE` times as long to come as
    the one before, one was too faint between them, as those of the nearer corner are.
    """
    first = 1.0 if laser.release_side == "positive" else -1.0
    side = np.full(rise.size, first)
    high = max(8 * sigma, 0.01 * np.nanmax(rise))
    smooth = np.convolve(rise, np.full(5, 0.2), "same")  # only to find the swings; θ itself is not smoothed
    low = smooth < np.maximum(high / 2, 2 * _fastest(smooth))
    index = np.flatnonzero((smooth > high) | low)
    swings = [(index[i], index[j]) for i, j in stretches(~low[index])]
    sign, interval = first, math.inf
    for (begin, last), (start, end) in pairwise(swings):
        rested = any(time_s[last] < mid < time_s[start] for mid in rest_mid_s)
        between = (start + end - begin - last) / 2
        if not rested and between > LATE * interval:
            middle = (last + start) // 2
            side[last + int(np.nanargmin(rise[last : middle + 1])) :] = -sign
            side[middle + int(np.nanargmin(rise[middle : start + 1])) :] = sign
            interval = between / 2
            continue
        sign, interval = (first, math.inf) if rested else (-sign, between)
        side[last + int(np.nanargmin(rise[last : start + 1])) :] = sign
    return side


def _fastest(values: Floats) -> Floats:
    """The largest step around each value between a fall and a rise, as a touch-down lies; else 0."""
    steps = np.nan_to_num(np.diff(values, prepend=values[:1]))
    fall, rise = np.maximum(-steps, 0.0), np.maximum(np.append(steps[1:], 0.0), 0.0)
    before, after = fall.copy(), rise.copy()
    for by in range(1, AROUND + 1):
        np.maximum(before[by:], fall[:-by], out=before[by:])
        np.maximum(after[:-by], rise[by:], out=after[:-by])
    fastest = np.maximum(before, after)
    return np.where(np.minimum(before, after) > OTHER_SIDE * fastest, fastest, 0.0)
