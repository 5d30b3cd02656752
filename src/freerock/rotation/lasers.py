"""θ(t) from the reading of one laser, or of two that separate rotation from translation."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from freerock.arrays import Floats, Mask
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.noise.still import stretches
from freerock.rotation.beam import (
    displaced,
    is_unsigned,
    mirrored,
    on_target,
    rotation_from_displacement,
    sensitivity,
)
from freerock.rotation.channel import Reading, Rotation
from freerock.rotation.faults import Fault
from freerock.rotation.sensor import Laser

LATE = 1.5  # times the interval between the swings before: one was missed
AROUND = 3  # samples on either side: a mean of samples moves more slowly at a touch-down than beside it
OTHER_SIDE = 0.25  # of the faster side, that the other side of a touch-down moves: one outlier flips no sign


def rotation_of_one(time_s: Floats, reading: Reading, laser: Laser, block: Block) -> Rotation:
    """θ from one channel, time_s of shape (n_time,) [s]; NaN where the beam does not meet the block."""
    zero_stderr = reading.zero_stderr / reading.per_angle
    if reading.quantity == "rotation":
        theta = reading.displacement
        return Rotation(theta, np.where(np.isnan(theta), np.nan, reading.sigma), zero_stderr)
    side = None
    if is_unsigned(block, laser):
        largest = float(np.nanmax(reading.sigma))
        side = _swing_sides(-reading.displacement, largest, time_s, reading.rest_mid_s, laser)
    theta = rotation_from_displacement(reading.displacement, block, laser, side)
    with np.errstate(divide="ignore", invalid="ignore"):  # infinite where a beam over a corner is blind
        return Rotation(theta, reading.sigma / sensitivity(theta, block, laser), zero_stderr)


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


SURE = 5.0  # standard errors of θ that a disagreement exceeds
TOGETHER_S = 0.5  # disagreements this close are one fault


def rotation_of_two(
    time_s: Floats,
    readings: Sequence[Reading],
    lasers: Sequence[Laser],
    block: Block,
    max_disagreement_deg: float,
) -> Rotation:
    """Separate rotation from translation: tan θ = (s₁ - s₂)/(Y₁ - Y₂), see `rotation.find_rotation`.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Evenly spaced time [s].
    readings, lasers : sequence
        Two of each.
    block : Block
    max_disagreement_deg : float
        See `RotationOptions` [degree].

    Raises
    ------
    FreerockError
        The beams differ in kind or in face, or are at one place.
    """
    first, second = readings
    one, other = lasers
    if "rotation" in (first.quantity, second.quantity) or (one.beam, one.face) != (other.beam, other.face):
        what = "the two beams differ in kind or in face"
        raise FreerockError("laser signal", what, "use two of one kind, on one face")
    apart = one.position - other.position
    if apart == 0:
        raise FreerockError("laser signal", "the two beams are at one position_m", "give both positions")
    angle = np.arctan((first.displacement - second.displacement) / apart)
    theta = -angle if mirrored(one) else angle
    on_one, on_other = (on_target(theta, block, each) for each in lasers)
    translation = np.where(on_one, first.displacement - displaced(theta, block, one), np.nan)
    theta = np.where(on_one & on_other, theta, np.nan)
    sigma = np.hypot(first.sigma, second.sigma) / abs(apart) * np.cos(theta) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        apart_rad = np.abs(translation) / sensitivity(theta, block, one)
        wrong = (apart_rad > math.radians(max_disagreement_deg)) & (apart_rad > SURE * sigma)
    faults = _disagreements(time_s, wrong, translation, theta, block, one) if wrong.any() else []
    zero_stderr = float(np.hypot(first.zero_stderr, second.zero_stderr)) / abs(apart)
    return Rotation(theta, sigma, zero_stderr, translation, faults)


def _disagreements(
    time_s: Floats, wrong: Mask, translation: Floats, theta: Floats, block: Block, laser: Laser
) -> list[Fault]:
    """A fault for every stretch in which the lasers disagree."""
    faults, index = [], np.flatnonzero(wrong)
    step = time_s[1] - time_s[0]
    for i, j in stretches(np.diff(index) * step < TOGETHER_S) or [(0, index.size - 2)]:
        part = index[i : j + 2]
        angle = float(np.nanmax(np.abs(translation[part]) / sensitivity(theta[part], block, laser)))
        largest = 1e3 * float(np.nanmax(np.abs(translation[part])))
        note = f"up to {math.degrees(angle):.2f}°, {largest:.2g} mm"
        faults.append(Fault("lasers_disagree", float(time_s[part[0]]), float(time_s[part[-1]]), note, angle))
    return faults
