"""A problem to be solved by every method, and what a method made of it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import static_depth
from freerock.models.laws import Foundation

SAMPLING_HZ = 2000.0
NOISE_RAD = math.radians(0.01)  # of a sample of a laser
# Absolute tolerances of SciPy and CyRK: rtol times this share of each component's amplitude.
ATOL_SHARE = 0.01
BLOWN_UP = 10.0  # |θ| that no block has [rad]


@dataclass(frozen=True)
class Problem:
    """A block released from rest on a foundation.

    Parameters
    ----------
    model : str
        "housner", "winkler" or "hunt_crossley".
    block : Block
        The block.
    parameters : mapping
        Parameters of the model, SI.
    theta0 : float
        Angle of release [rad].
    debonding : str
        "geometric" or "tensionless".
    """

    model: str
    block: Block
    parameters: Mapping[str, float]
    theta0: float
    debonding: str = "geometric"

    @property
    def law(self) -> Floats:
        """Constants of the compiled right-hand side: k, c, λ, I over m; b, h, g; tensionless."""
        m, b, h = self.block.mass_kg, self.block.b, self.block.h
        k, c, lam = (self.parameters.get(name, 0.0) for name in ("k", "c", "lambda"))
        tensionless = float(self.debonding == "tensionless")
        inertia = self.block.inertia_base
        return np.array([k / m, c / m, lam / m, inertia / m, b, h, GRAVITY, tensionless])

    @property
    def start(self) -> Floats:
        """z_cb [m], ż_cb [m/s], θ [rad] and θ̇ [rad/s] at the release."""
        depth = static_depth(self.block, Foundation.of(self.parameters), self.theta0)
        return np.array([depth, 0.0, self.theta0, 0.0])

    @property
    def amplitudes(self) -> Floats:
        """Size of each component of the state."""
        b, p = self.block.b, self.block.p
        return abs(self.theta0) * np.array([b, b * p, 1.0, p])


@dataclass(frozen=True)
class Solution:
    """What a method made of a problem.

    Parameters
    ----------
    theta : ndarray, shape (n_time,)
        Rotation [rad]; NaN after a failure or once overturned.
    evaluations : float
        Evaluations of the right-hand side; NaN where the method does not say.
    outcome : str
        "completed", "overturned", "step_limit", "non_finite" or "not_converged".
    """

    theta: Floats
    evaluations: float
    outcome: str


def solution(
    problem: Problem,
    time: Floats,
    theta: Floats,
    evaluations: float,
    success: bool,
    failure: str = "non_finite",
) -> Solution:
    """θ cut where it is not finite or where the block has passed its critical angle.

    Parameters
    ----------
    theta : ndarray
        Rotation [rad] as far as the method got.
    success, failure : bool, str
        Whether the method says that it succeeded; the outcome where it did not and θ is not finite.
        The other parameters as in `Solution`.
    """
    full = np.full(time.size, np.nan)
    full[: len(theta)] = theta
    bad = np.flatnonzero(~(np.abs(full) <= problem.block.theta_cr))
    if len(bad) == 0:
        return Solution(full, evaluations, "completed")
    overturned = abs(full[bad[0]]) < BLOWN_UP
    full[bad[0] :] = np.nan
    outcome = "overturned" if overturned else "non_finite" if success else failure
    return Solution(full, evaluations, outcome)


def errors(theta: Floats, reference: Floats) -> tuple[float, float]:
    """ε (sums over samples, as a fraction) and largest error [rad] against a reference."""
    difference = theta - reference
    return float(difference @ difference / (reference @ reference)), float(np.max(np.abs(difference)))
