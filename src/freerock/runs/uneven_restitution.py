"""Test whether the restitution of a run changes smoothly from impact to impact.

The restitution of a free block changes smoothly as its swings get lower, on any foundation. Where every other
impact has more of it, or one impact falls out, something else acted on the block or on the reading.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import stdtr

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.runs.impacts import Impacts, restitution_covariance
from freerock.runs.verdict import Reason

FIRST = 10  # impacts that are looked at: the restitution of low swings is uncertain
SURE = 5.0  # standard errors, of which the scatter of clean runs is a part
CHANCE = 1e-3  # of so uneven a run whose impacts scatter at random, by Student's distribution
BENT = 0.05  # of how far the restitution goes from the second impact to the last: more scatter where it bends
ALTERNATES = "level the base, and check the laser: its sign, the level of its beam, its linearity"
FALLS_OUT = "the block may have been touched, hit or caught, or it slid: look there, and exclude the run"


class Evenness(NamedTuple):
    """What is taken for even in a run of so many impacts.

    Parameters
    ----------
    fewest : int
        Impacts from which this holds.
    degree : int
        Of the polynomial in the number of the impact.
    scatter : float
        By how much, as a standard deviation, the restitutions of clean runs differ from it.
    """

    fewest: int
    degree: int
    scatter: float


EVEN = (Evenness(8, 3, 1.5e-3), Evenness(6, 2, 2.5e-3))


class Unevenness(NamedTuple):
    """One number more than even: by how much one impact, or every other one, is off.

    Parameters
    ----------
    impact : int
        Which one, counted from 1; 0 for every other one.
    size, stderr : float
        Of the restitution; of every other one half the difference.
    left : float
        Sum of squares that it leaves, in standard deviations.
    """

    impact: int
    size: float
    stderr: float
    left: float

    def is_sure(self, spare: int, tried: int) -> bool:
        """Whether it is more than the scatter of the other impacts, seen by so many degrees of freedom.

        That of a hardly damped block, or of a laboratory, is larger than of clean runs.
        """
        scatter, times = math.sqrt(self.left / spare), abs(self.size) / self.stderr
        return times >= SURE * max(1.0, scatter) and tried * self._chance(times, scatter, spare) < CHANCE

    @staticmethod
    def _chance(times: float, scatter: float, spare: int) -> float:
        return 2 * float(stdtr(spare, -times / scatter)) if scatter > 0 else 0.0


def reasons_of_unevenness(impacts: Impacts, block: Block, peak_stderr: float = 0.0) -> list[Reason]:
    """A warning where the restitutions do not follow a smooth curve.

    The scatter was set on 1500 clean runs of the three laws, on foundations of any stiffness and damping, of
    worn corners and of pivoting blocks; docs/validation.md counts the false alarms of others. With fewer than
    eight impacts the two kinds can't be told apart; of fewer than six nothing is said.
    No peak is known better than to `peak_stderr` [rad], by the noise as it is at rest.
    """
    n = min(impacts.restitution.size, FIRST)
    r, covariance = impacts.restitution[:n], restitution_covariance(impacts, block, peak_stderr)[:n, :n]
    known = np.flatnonzero(np.isfinite(r) & np.isfinite(covariance.diagonal()))
    even = next((each for each in EVEN if known.size >= each.fewest), None)
    if even is None:
        return []
    found = unevennesses(known.astype(float), r[known], covariance[np.ix_(known, known)], even)
    worst = found[0] if even is EVEN[-1] else min(found, key=lambda each: each.left)
    spare = known.size - even.degree - 2
    if not (found[0].is_sure(spare, 1) or worst.is_sure(spare, known.size)):
        return []
    if even is not EVEN[0]:
        text = f"restitution does not change smoothly from impact to impact, by {abs(found[0].size):.2g}"
        remedy = f"{ALTERNATES}; or {FALLS_OUT}"
        return [Reason.of("uneven_restitution", f"{text}: {remedy}")]
    if worst.impact:
        side = "above" if worst.size > 0 else "below"
        text = (
            f"restitution of impact {worst.impact} is {abs(worst.size):.2g} {side} the value that "
            f"its neighbours predict"
        )
        return [Reason.of("outlying_restitution", f"{text}: {FALLS_OUT}")]
    text = f"restitution alternates by ±{abs(worst.size):.2g} from impact to impact"
    return [Reason.of("alternating_restitution", f"{text}: {ALTERNATES}")]


def unevennesses(number: Floats, r: Floats, covariance: Floats, even: Evenness) -> list[Unevenness]:
    """Every other impact, then each one alone, as what is off a smooth curve; by generalised least squares.

    Parameters
    ----------
    number : ndarray, shape (n,)
        Number of each impact, in which the curve is a polynomial.
    r, covariance : ndarray, shapes (n,) and (n, n)
        Restitutions, and how uncertain they are.
    even : Evenness
    """
    scatter = math.hypot(even.scatter, BENT * (r[-1] - r[1]))
    scale = np.linalg.cholesky(covariance + scatter**2 * np.eye(r.size))
    smooth = np.vander(number - np.mean(number), even.degree + 1)
    every_other = (-1.0) ** number
    found = []
    for i, column in enumerate([every_other, *np.eye(r.size)]):
        design = np.linalg.solve(scale, np.column_stack([column, smooth]))
        seen = np.linalg.solve(scale, r)
        inverse = np.linalg.pinv(design)
        size, stderr = float(inverse[0] @ seen), float(np.linalg.norm(inverse[0]))
        left = float(np.sum((seen - design @ (inverse @ seen)) ** 2))
        found.append(Unevenness(int(number[i - 1]) + 1 if i else 0, size, stderr, left))
    return found
