"""The swings of a measured run: how high each goes, and what that says of the base before any fit."""

from dataclasses import replace

import numpy as np

from freerock.models.block import Block
from freerock.runs.motion import Motion
from freerock.runs.tops import TOP_STDERR, TOP_STDERR_S, Top, find_tops

# By judgement; the degrees rise as do those of the restitutions (`runs.evenness`). Of 71 bases off level the
# fits that start from this tilt all found it within 0.002 degrees.
LEAST_PEAK = 0.1  # of the release angle: in the noise of low swings any law hides
CLEAR = 50.0  # standard deviations of the noise, likewise
FEWEST = {4: 1, 6: 2, 9: 3}  # heights from which a curve of so high a degree leaves one to tell a tilt


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
