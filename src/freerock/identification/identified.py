"""What was found of a run: fits, what was left out, and what they do not take for granted."""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from freerock.errors import FreerockError
from freerock.identification.candidates import Ladder
from freerock.identification.choice import TELLS, Choice, Evidence, choose
from freerock.identification.fit import Fit, evidence
from freerock.identification.nuisances import Posterior, at_end
from freerock.identification.problem import posed
from freerock.models.block import Block
from freerock.runs.motion import Motion


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
    scene : tuple of str
        What these fits do not take for granted: "release", that it is as measured, "tilt", that there is
        none, "edges", that they are sharp.
    width_or_edges : bool
        Whether another contact width on sharp edges and rounded edges explain the run alike.
    edge_radii_alike : dict of str to float
        By candidate, the largest radius of other edges with which it explains the run as well [m].
    sharp_alike : bool
        Whether sharp edges explain the run as well as the rounded ones of these fits.
    """

    fits: dict[str, Fit] = field(default_factory=dict)
    left_out: dict[str, LeftOut] = field(default_factory=dict)
    errors: dict[str, FreerockError] = field(default_factory=dict)
    scene: tuple[str, ...] = ()
    width_or_edges: bool = False
    edge_radii_alike: dict[str, float] = field(default_factory=dict)
    sharp_alike: bool = False

    def copied(self) -> "Identified":
        """The same, to which fits may be added."""
        return replace(
            self,
            fits={**self.fits},
            left_out={**self.left_out},
            errors={**self.errors},
            edge_radii_alike={**self.edge_radii_alike},
        )

    @property
    def explained(self) -> bool:
        """Whether some candidate leaves only noise."""
        return any(evidence(fit).explains for fit in self.fits.values())

    @property
    def possible(self) -> list[str]:
        """Candidates that leave only noise, and that no other that does surpasses by the BIC."""
        explaining = {name: known for name, fit in self.fits.items() if (known := evidence(fit)).explains}
        least = min((known.bic for known in explaining.values()), default=math.inf)
        return [name for name, known in explaining.items() if known.bic <= least + TELLS]

    def choice(self, ladder: Ladder) -> Choice:
        """The candidates that explain the run, and what became of all others."""
        ladder = ladder.freeing(self.scene)
        return choose([self._evidence(model, ladder) for model in ladder.candidates])

    def at_best(self, model: str, block: Block, motion: Motion, ladder: Ladder) -> Posterior:
        """The linear model where the fit of a candidate ended, at its tolerance."""
        settings, fit = ladder.freeing(self.scene).settings(model), self.fits[model]
        problem = replace(posed(model, (block,), (motion,), settings), rtol=fit.diagnostics["rtol"])
        return at_end(problem, fit.values, fit.contributions)

    @property
    def settled(self) -> bool:
        """Whether the best of the candidates that leave only noise has no number at a bound."""
        return math.isfinite(least := self.least_bic) and not any(
            fit.bic + TELLS < least and evidence(fit).explains for fit in self.fits.values()
        )

    @property
    def least_bic(self) -> float:
        """Of the candidates that leave only noise, and of which no number lies at a bound."""
        return min(
            (
                fit.bic
                for fit in self.fits.values()
                if evidence(fit).explains and bool(np.isfinite(fit.stderr).all())
            ),
            default=math.inf,
        )

    def _evidence(self, model: str, ladder: Ladder) -> Evidence:
        if model in self.fits:
            return evidence(self.fits[model])
        if model in self.errors:
            quick = LeftOut(str(self.errors[model]), math.nan)
        else:
            quick = self.left_out.get(model, SMALLER)
        n = ladder.n_freed(model)
        return Evidence(model, n, fitted=False, message=quick.reason, epsilon_theta=quick.epsilon_theta)
