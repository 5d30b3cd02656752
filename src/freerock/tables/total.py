"""Total standard uncertainty of a mean: the scatter of its members, and what they owe to the inputs."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from freerock.arrays import Floats
from freerock.identification.random_effects import LEVEL, Population

OF_INPUT = ["input", "input_owner", "input_u", "input_unit", "input_stated"]
Key = tuple[str, str]  # owner and name of an input
Shifts = Mapping[Key, float]  # for one standard uncertainty of each input, on the scale of the values


class Total(NamedTuple):
    """Total uncertainty of a mean, on the scale of its values.

    shifts are the contributions of the inputs, beside that of the runs: of the members' scatter what is more
    than the inputs explain. u is their root sum of squares, low and high the 95 % interval.
    """

    shifts: Shifts
    runs: float
    u: float
    low: float
    high: float


def total(found: Population, members: Sequence[Shifts], weights: Floats, within: float = 0.0) -> Total:
    """Total standard uncertainty of the weighted mean of members that share inputs.

    An input that shifts the members by s_a shifts their mean by Σ w_a s_a / Σ w_a (JCGM 100:2008, 5.2, for
    correlated inputs). The standard error from the scatter knows of the errors that are each member's own,
    but not of those that all share, which are the mean covariance Σ w_a w_b s_a s_b / Σ w_a w_b, a ≠ b, of
    two members. So of its square only what is more than their own errors by the inputs adds to the total, and
    not less than what the members' own scatter says.
    Student's t of the interval has the degrees of freedom of Welch and Satterthwaite (G.4.1), those of the
    inputs being infinite.

    Parameters
    ----------
    found : Population
        Of the members.
    members : sequence of mapping
        Shifts of each; an input that a member lacks has no part in it.
    weights : ndarray, shape (n_members,)
        Those of the mean.
    within : float
        Variance of the mean by the scatter within its members, where that is known.
    """
    keys = dict.fromkeys(key for each in members for key in each)
    shifts, seen = dict[Key, float](), 0.0
    for key in keys:
        s = np.array([each.get(key, 0.0) for each in members])
        shifts[key] = float(weights @ s / weights.sum())
        if len(s) > 1:
            pairs = weights.sum() ** 2 - weights @ weights
            shared = ((weights @ s) ** 2 - np.sum((weights * s) ** 2)) / pairs
            seen += shifts[key] ** 2 - float(shared)
    runs = max(found.stderr**2 - max(seen, 0.0), within)
    u = math.sqrt(runs + sum(each**2 for each in shifts.values()))
    dof = (found.n - 1) * (u / found.stderr) ** 4 if found.n > 1 and found.stderr > 0 else math.inf
    half = float(stdtrit(dof, (1 + LEVEL) / 2)) * u
    return Total(shifts, math.sqrt(runs), u, found.mean - half, found.mean + half)


def inputs_by_key(contributions: pd.DataFrame) -> dict[Key, dict[str, object]]:
    """Uncertainty, unit and origin of each input in a table of contributions."""
    first = contributions.drop_duplicates(["input_owner", "input"])
    return {
        (row["input_owner"], row["input"]): {name: row[name] for name in OF_INPUT}
        for row in first[OF_INPUT].to_dict("records")
    }
