"""How deep the corners of a block go into its foundation, and with which force."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.contact import Foundation, State, contact_force, lean
from freerock.models.laws import CANDIDATES
from freerock.models.simulate import simulate_fitted


class Corners(NamedTuple):
    """Over time: depth of the left and of the right corner, positive below the ground [m], and force [N]."""

    left: Floats
    right: Floats
    force: Floats


def corners_over_time(
    model: str, block: Block, values: Mapping[str, float], time_s: Floats, debonding: str = "geometric"
) -> Corners:
    """Depth of the corners and resultant of the contact law, under what a fit found.

    Parameters
    ----------
    model : str
        A candidate whose law is that of a foundation.
    block : Block
    values : mapping of str to float
        As `freerock.models.simulate.simulate_fitted` takes them.
    time_s : ndarray, shape (n_time,)
        Increasing instants [s].
    debonding : str
        "geometric" or "tensionless".
    """
    candidate = CANDIDATES[model]
    rules, rates = candidate.rules(debonding), np.empty((time_s.size, 3))
    theta = simulate_fitted(candidate.law, block, values, time_s, rules=rules, rates=rates)
    found, foundation = block.as_found(values), Foundation.of(values)
    tilt = values.get("tilt", 0.0)
    if tilt or found.e:
        theta = theta + lean(found, foundation, tilt)  # from the normal of the ground
    depth, depth_rate, rate = rates.T
    lift = found.b * np.sin(theta)
    left, right = depth - lift, depth + lift
    states = zip(depth, depth_rate, theta, rate, strict=True)
    pressed = (contact_force(found, foundation, State(*map(float, each)), rules)[0] for each in states)
    return Corners(left, right, np.fromiter(pressed, float))
