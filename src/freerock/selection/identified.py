"""What was found of a run: fits, what was left out, and the priors that these widen."""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from freerock.errors import FreerockError
from freerock.identification.fit import Fit
from freerock.identification.nuisances import Posterior, at_end
from freerock.identification.settings import FitSettings
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.runs.motion import Motion
from freerock.selection.choice import Choice, Evidence, choose, evidence
from freerock.selection.hypotheses import Hypotheses, Hypothesis


class LeftOut(NamedTuple):
    """What a quick fit leaves: in words, and its ε_θ, NaN where it looked at a part of the run only."""

    reason: str
    epsilon_theta: float


SMALLER = LeftOut("a smaller candidate explains the run", math.nan)


@dataclass
class Identified:
    """What was found of one run.

    Parameters
    ----------
    fits : dict of str to Fit
        By candidate.
    left_out : dict of str to LeftOut
        Candidates of which a quick fit says that a full one is of no use.
    errors : dict of str to FreerockError
        Candidates to which the data allow no fit.
    widened : tuple of str
        Priors that these fits widen (`hypotheses.WIDENED`).
    alternatives : dict of Hypothesis to Fit
        What explains the run as well with other priors widened, or with edges of another radius.
    """

    fits: dict[str, Fit] = field(default_factory=dict)
    left_out: dict[str, LeftOut] = field(default_factory=dict)
    errors: dict[str, FreerockError] = field(default_factory=dict)
    widened: tuple[str, ...] = ()
    alternatives: dict[Hypothesis, Fit] = field(default_factory=dict)

    def copied(self) -> "Identified":
        """The same, to which fits may be added."""
        return replace(self, fits={**self.fits}, left_out={**self.left_out}, errors={**self.errors})

    @property
    def explained(self) -> bool:
        """Whether some candidate leaves only noise."""
        return any(evidence(fit).explains for fit in self.fits.values())

    def choice(self, hypotheses: Hypotheses) -> Choice:
        """The candidates that explain the run, and what became of all others."""
        return choose([self._evidence(model, hypotheses) for model in hypotheses.candidates])

    def at_best(self, model: str, block: Block, motion: Motion, hypotheses: Hypotheses) -> Posterior:
        """The linear model where the fit of a candidate ended, at its tolerance."""
        return at_end_of(self.fits[model], block, motion, hypotheses.settings(model, self.widened))

    def _evidence(self, model: str, hypotheses: Hypotheses) -> Evidence:
        if model in self.fits:
            return evidence(self.fits[model])
        if model in self.errors:
            quick = LeftOut(str(self.errors[model]), math.nan)
        else:
            quick = self.left_out.get(model, SMALLER)
        n = hypotheses.n_freed(model, self.widened)
        return Evidence(model, n, fitted=False, message=quick.reason, epsilon_theta=quick.epsilon_theta)


def at_end_of(fit: Fit, block: Block, motion: Motion, settings: FitSettings) -> Posterior:
    """The linear model where a fit of one run ended, at its tolerance."""
    problem = replace(posed(fit.model, (block,), (motion,), settings), rtol=fit.diagnostics["rtol"])
    return at_end(problem, fit.values, fit.contributions)
