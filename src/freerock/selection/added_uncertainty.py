"""What is added to the uncertainty of a fit: other hypotheses and causes that the run can't tell from it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.fit import Fit
from freerock.identification.model_discrepancy import PARTS_OF_RUN
from freerock.selection.causes import Cause
from freerock.selection.choice import evidence


def beside_all_that_explain(fits: Mapping[str, Fit], alternatives: Sequence[Fit] = ()) -> dict[str, Fit]:
    """Fits of the candidates that explain a run, each beside all else that does: the other candidates, and
    hypotheses that widen other priors.

    What a run can't tell from a law shifts its numbers all the same.
    """
    possible = {name: fit for name, fit in fits.items() if evidence(fit).explains}
    every = (*possible.values(), *alternatives)
    return {
        name: beside_others(fit, [other for other in every if other is not fit])
        for name, fit in possible.items()
    }


def beside_all_usable(fits: Mapping[str, Fit]) -> dict[str, Fit]:
    """Fits of a run that nothing explains, each beside the others that may be used."""
    usable = {name: fit for name, fit in fits.items() if fit.success}
    return {
        name: beside_others(fit, [other for other in usable.values() if other is not fit], by_misfit)
        for name, fit in usable.items()
    }


def by_bic(fit: Fit, other: Fit) -> float:
    """Logarithm of the odds of another fit against one, where both leave noise."""
    return (fit.bic - other.bic) / 2


def by_misfit(fit: Fit, other: Fit) -> float:
    """The same where both leave more: a misfit has about as many independent values as a run has parts."""
    return PARTS_OF_RUN / 2 * math.log(fit.epsilon_theta / other.epsilon_theta)


def beside_others(fit: Fit, others: Sequence[Fit], log_odds: Callable[[Fit, Fit], float] = by_bic) -> Fit:
    """A fit whose `discrepancy` takes up the mean square difference to others, by their odds against it.

    Of those that have its first number; nothing of a number that is fixed.
    """
    others = [other for other in others if fit.parameters[0] in other.parameters]
    odds = np.exp(np.clip([log_odds(fit, other) for other in others], None, 700.0))
    square = np.zeros(len(fit.value))
    for share, other in zip(odds / (1 + odds.sum()), others, strict=True):
        at = np.array([other.values.get(each, own) for each, own in fit.values.items()])
        square += share * (at - fit.value) ** 2
    return _less_certain(fit, square)


def beside_causes(fit: Fit, causes: Sequence[Cause], shares: Sequence[float]) -> Fit:
    """A fit whose `discrepancy` takes up what causes that no law contains would change, by their shares."""
    shifts = np.array([[cause.shifts.get(name, 0.0) for name in fit.parameters] for cause in causes])
    return _less_certain(fit, np.array(shares) @ shifts**2 / max(1.0, sum(shares)))


def _less_certain(fit: Fit, square: Floats) -> Fit:
    """A fit with more added to the square of its `discrepancy`; nothing to that of a number that is fixed."""
    square = np.where(fit.stderr == 0, 0.0, square)
    return replace(fit, discrepancy=np.sqrt(np.square(fit.discrepancy) + square))
