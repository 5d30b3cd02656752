"""Levels of the tests on a run, in one place: from how many tests a campaign makes.

A campaign of a hundred clean runs makes three tests of each that may reject the law that is named: the
residual against the noise at rest, the pulls of its inputs, and the number that the law lacks. Each law that
is rejected, and each number that is freed, by chance alone should be seen in one of twenty such campaigns
(Bonferroni). What a number off zero may turn into (tilt, edges, release) are eight tests of each run, effects
that no law contains twelve.
"""

import math

import numpy as np
from scipy.special import ndtr, ndtri

NORMAL_95 = 1.959963984540054  # standard errors to either side of a 95 % interval


def level(tests: int, wrongly: float = 0.05, runs: int = 100) -> float:
    """Significance level of each of so many tests per run, by Bonferroni's rule.

    `wrongly` is the chance that any test rejects a law or frees a number in a campaign of `runs` clean runs.
    """
    return wrongly / (runs * tests)


def deviations(chance: float) -> float:
    """Standard deviations that a normal number exceeds to either side with a chance."""
    return float(-ndtri(chance / 2))


REJECTS = level(3)  # 1.7e-4: pulls, or a lacking damping, at which a law is rejected
TRACE = deviations(REJECTS)  # 3.8 standard errors of a number that a law lacks
# Chance of the residual as `against_noise.AgainstRest` has it. That is an upper bound, since sensors may be
# a tenth louder than at rest: of 1 400 clean runs of seven noises none lies below it.
RESIDUAL = 1e-3
# Standard errors off zero, from which a number that was taken for granted is freed: 4.0. Of 320 level runs
# none had a tilt of more than 3.3.
ASKED = deviations(level(8))
# The derivative sees a quarter to all of what a fit with rounded edges gains, which move k by percents. So it
# asks early, and the BIC decides. Set on 40 short runs of 0.7 mm (3.3 and more); of 160 others one has less.
# Two of 600 clean runs turn to edges, of 0.17 and 0.18 mm.
ASKED_EDGES = 2.0
# Worn corners look like a beam, a scale and a width that are off by one uncertainty each. Set on 24 records
# of corners that callipers missed; 13 % of clean runs try them in vain.
ASKED_WIDTH = 1.5
SURE_EDGES = 3.5  # beside a freed release no BIC decides of edges
# Standard errors from which a sensor is told to be slower than stated: noise alone does so in one of two
# thousand. Set on 24 clean records, of which none had more than 1.7.
SLOWER_RESPONSE = 3.3
# Standard errors from which a run requires an effect that no law contains: 4.1. Of 300 clean runs of
# seventeen noises none does.
EFFECTS = deviations(level(12))
PULLED = 2.0  # standard deviations from which the shift of an input is noted
# Chance of so large a pull of any input, from which the note is a warning: 2e-3, one clean run of 500. At one
# of 200, two of 309 clean records were warned of it; with what else may warn, that is more than one of 200.
WARNS = level(1, wrongly=0.2)

TELLS = 10.0  # difference of the BIC from which the data tell two candidates apart
# ε_θ up to which publications take a model for near: table 3 of Spanos et al. 2017 has 1.4 to 4.6 %
NEAR = 0.05


def weight_against(chance: float, of: float, blurred: float = 10.0) -> float:
    """How far a test speaks against a law, for its uncertainty: from 0 to 1, half of it at the level.

    The share of the `model_discrepancy` that counts. It grows with the logarithm of the chance between
    `blurred` times the level and a `blurred`-th of it, so that no uncertainty jumps where a law is rejected.
    """
    with np.errstate(divide="ignore"):
        above = np.log(chance / of) / math.log(blurred)
    return float(np.clip((1 - above) / 2, 0.0, 1.0))


def chance_of(deviations: float) -> float:
    """Chance of a normal number that lies so far from zero, to either side; 1 of a negative one."""
    return min(1.0, 2 * float(ndtr(-deviations)))
