"""Means over the runs of a record and over the records of a foundation, with inputs that they share."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.populations.priors import RECORDS
from freerock.populations.random_effects import Population, common_spread, population
from freerock.runs.u_of_measured import OF_LAW

Key = tuple[str, str]  # owner and name of an input
Shifts = Mapping[Key, float]  # of a number for one standard uncertainty of each input


class Mean(NamedTuple):
    """What members say together: their values, the variances of each by itself, the shifts of their mean."""

    found: Population
    values: Floats
    variances: Floats
    shifts: Shifts

    @property
    def scatter(self) -> float:
        """Standard uncertainty of the mean by all that is no input."""
        return math.sqrt(max(self.found.u**2 - sum(each**2 for each in self.shifts.values()), 0.0))


def over_runs(values: Floats, stderrs: Floats, shifts: Sequence[Shifts]) -> Mean:
    """Mean of the runs of a record, which share its block, laser and base.

    Parameters
    ----------
    values, stderrs : ndarray, shape (n,)
        On the scale on which runs scatter evenly; standard errors by noise, above zero.
    shifts : sequence of mapping, length n
        Of each run; an input that a run lacks has no part in it.
    """
    keys, by = _by_input(shifts)
    found = population(values, stderrs, by)
    return Mean(found, values, stderrs**2, _shifted(keys, found.weights @ by))


def over_records(records: Sequence[Mean]) -> Mean:
    """Mean of records of a foundation, each with the spread between runs that all of them have.

    Records share what carries one name: a laser, a block, the misfit of a law. The next record is one of
    another block, with what all of these records share but a misfit of its own.

    Parameters
    ----------
    records : sequence of Mean
        Two at least, as `over_runs` gives them.
    """
    tau2 = (spread_of_runs(records) or (0.0,))[0] ** 2
    own = np.array([each.found.weights**2 @ (each.variances + tau2) for each in records])
    keys, by = _by_input([each.shifts for each in records])
    values = np.array([each.found.mean for each in records])
    shared = [key[1] != OF_LAW and all(key in each.shifts for each in records) for key in keys]
    dof = sum(len(each.values) - 1 for each in records) or math.inf
    found = population(values, np.sqrt(own), by, prior=RECORDS, dof=dof, shared=shared)
    return Mean(found, values, own, _shifted(keys, found.weights @ by))


def spread_of_runs(records: Sequence[Mean]) -> tuple[float, float, float] | None:
    """Standard deviation between the runs of a record, from all records, and its interval; None of one run
    each."""
    several = [(each.values, each.variances) for each in records if len(each.values) > 1]
    return common_spread(several) if several else None


def _by_input(members: Sequence[Shifts]) -> tuple[list[Key], Floats]:
    """Inputs of members, and the shifts of each by each of them, shape (n_members, n_inputs)."""
    keys = list(dict.fromkeys(key for each in members for key in each))
    return keys, np.array([[each.get(key, 0.0) for key in keys] for each in members])


def _shifted(keys: Sequence[Key], shifts: Floats) -> Shifts:
    return dict(zip(keys, shifts.tolist(), strict=True))
