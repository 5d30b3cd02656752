"""θ(t) and the translation of the block from two lasers with beams of one kind, on one face."""

import math
from collections.abc import Sequence

import numpy as np

from freerock.arrays import Floats, Mask
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation import beam_kernel
from freerock.rotation.beam import beam_of, mirrored, on_target, sensitivity
from freerock.rotation.faults import Fault
from freerock.rotation.reading import Reading, Rotation, pieces
from freerock.rotation.sensor import Laser
from freerock.rotation.still import stretches

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

    They take the place of the two displacements.

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
    theta, translation = first.displacement, second.displacement  # a long record is not held twice
    sigma = np.empty(time_s.size)
    wrong = np.zeros(time_s.size, bool)
    sigma[:] = np.hypot(first.sigma, second.sigma) / abs(apart)
    for part in pieces(time_s.size):
        angle, error, moved = theta[part], sigma[part], translation[part]
        slope = np.empty(angle.size)
        beam_kernel.rotations_of_two(angle, moved, apart, beam_of(block, one), angle, error, moved, slope)
        if mirrored(one):
            np.negative(angle, out=angle)
        on_one, on_other = (on_target(angle, block, each) for each in lasers)
        if not (on_one & on_other).all():
            moved[~on_one] = np.nan
            angle[~(on_one & on_other)] = error[~(on_one & on_other)] = np.nan
        with np.errstate(divide="ignore", invalid="ignore"):
            apart_rad = np.abs(moved) / slope
            wrong[part] = (apart_rad > math.radians(max_disagreement_deg)) & (apart_rad > SURE * error)
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
