"""What the measured motion says before any fit: how long and how high it swings, which r it may have."""

from dataclasses import replace

import numpy as np

from freerock.arrays import Mask
from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.models.laws import PARAMETERS
from freerock.runs.motion import Motion
from freerock.runs.tops import TOP_STDERR, TOP_STDERR_S, Top, find_tops

R_GRID = 1 - np.geomspace(1e-4, 0.95, 170)
STANDS = 1.002  # times the width at which the block overturns
R_CELL = 0.06  # spacing of the grid relative to 1 - r
# By judgement; the degrees rise as do those of the restitutions (`runs.evenness`). Of 71 bases off level the
# fits that start from this tilt all found it within 0.002 degrees.
LEAST_PEAK = 0.1  # of the release angle: in the noise of low swings any law hides
CLEAR = 50.0  # standard deviations of the noise, likewise
FEWEST = {4: 1, 6: 2, 9: 3}  # heights from which a curve of so high a degree leaves one to tell a tilt


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


def tops_of(motion: Motion) -> list[Top]:
    """The tops of the swings after the first, as long as they are high."""
    lowest = max(LEAST_PEAK * abs(motion.theta0), CLEAR * motion.sigma_theta)
    return find_tops(motion.time_s, motion.theta, motion.sigma_theta, lowest)


def from_top(motion: Motion, top: Top) -> Motion:
    """The rest of a run from a peak on."""
    later = motion.time_s >= top.time_s
    return replace(
        motion,
        time_s=motion.time_s[later] - top.time_s,
        theta=motion.theta[later],
        theta0=top.height,
        theta0_stderr=TOP_STDERR * abs(top.height),
        t0_stderr=TOP_STDERR_S,
        fit_start_s=0.0,
    )


def tilt_of_swings(block: Block, motion: Motion) -> float:
    """Tilt of the base to the right [rad], as the heights of the swings have it; 0 where they are too few.

    The energy of a rigid block at a top is m g (y - τ x), with y its rise and x its way to the right, both of
    the centre of mass turning about a corner. It falls evenly from swing to swing: its logarithm is a
    polynomial in the number of the swing, beside which τ x/y alternates.
    """
    heights = np.array([motion.theta0, *(top.height for top in tops_of(motion))])
    degree = max((FEWEST[n] for n in FEWEST if n <= heights.size), default=0)
    rise = block.b * np.sin(np.abs(heights)) - 2 * block.h * np.sin(heights / 2) ** 2
    if not degree or rise.min() <= 0:
        return 0.0
    way = block.h * np.sin(heights) + 2 * block.b * np.sign(heights) * np.sin(heights / 2) ** 2
    number = np.arange(heights.size) - (heights.size - 1) / 2
    design = np.column_stack([way / rise, np.vander(number, degree + 1)])
    return float(np.linalg.lstsq(design, np.log(rise), rcond=None)[0][0])
