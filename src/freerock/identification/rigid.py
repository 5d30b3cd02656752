"""Housner's r before its fit: the grid it is sought on, and what the measured motion says of it."""

import numpy as np

from freerock.arrays import Mask
from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.models.laws import PARAMETERS
from freerock.runs.motion import Motion

R_GRID = 1 - np.geomspace(1e-4, 0.95, 170)
STANDS = 1.002  # times the width at which the block overturns
R_CELL = 0.06  # spacing of the grid relative to 1 - r


def width_range(block: Block, motion: Motion) -> tuple[float, float]:
    """Least and largest contact width to start from, as shares of the full one; under less it overturns."""
    low, high, _ = PARAMETERS["width"].grid
    stands = block.height_m / block.width_m * np.tan(abs(motion.theta0))
    return max(low, STANDS * float(stands)), high


def rocking_for(block: Block, motion: Motion, time_s: float) -> float:
    """Least r of the grid with which the rigid block rocks for longer than a time."""
    few, many = 0, len(R_GRID) - 1  # the grid falls, and with it the time to rest
    while few < many:
        middle = (few + many + 1) // 2
        if housner_swings(block, R_GRID[middle], motion.theta0, until=time_s).rest_time > time_s:
            few = middle
        else:
            many = middle - 1
    return float(R_GRID[few])


def count_impacts(motion: Motion) -> int:
    """Changes of sign of θ while the block moves."""
    return int(np.count_nonzero(np.diff(np.sign(motion.theta[_moves(motion)]))))


def first_impact_s(motion: Motion) -> float:
    """First change of sign of θ [s]; an eighth of the run where there is none."""
    counts = np.isfinite(motion.theta)
    theta, time_s = motion.theta[counts], motion.time_s[counts]
    crossings = time_s[1:][np.signbit(theta[1:]) != np.signbit(theta[:-1])]
    return float(crossings[0] if len(crossings) else time_s[-1] / 8)


def moving_s(motion: Motion) -> float:
    """Last instant at which the block moves [s]; 0 where it never does."""
    moves = _moves(motion)
    return float(motion.time_s[moves][-1]) if moves.any() else 0.0


def _moves(motion: Motion) -> Mask:
    """Which samples stand out of the noise, and of the ringing of a base in full contact."""
    return np.asarray(np.abs(motion.theta) > max(10 * motion.sigma_theta, 1e-3 * abs(motion.theta0)))
