"""Which candidates explain a run: the selected one, and all that the data cannot distinguish from it.

Pure rules on evidence: nothing is fitted here.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Literal

import numpy as np

from freerock.identification.fit import Fit
from freerock.identification.significance_levels import NEAR, REJECTS, RESIDUAL, TELLS, TRACE
from freerock.models.laws import CANDIDATES, MODEL_LABELS, law_of
from freerock.selection.allowed_hypotheses import contains

Status = Literal["selected", "also_possible", "rejected", "not_fitted"]


@dataclass(frozen=True)
class Evidence:
    """What is known of a candidate on a run; NaN where something is not.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    n_freed : int
        Numbers that its fit frees, all counted.
    success : bool
        Whether its fit may be used.
    message : str
        Why the fit may not be used, or why there is none.
    fitted : bool
        False where there is no fit.
    epsilon_theta : float
        ε_θ as a fraction; without a fit that of a quick one, where there was one.
    epsilon_holdout : float
        ε_θ of the second half of the run under the first.
    bic : float
        Bayesian information criterion.
    charged : float
        Part of it that is for the freed numbers and the inputs.
    noise_p, noise_ratio, noise_low_hz, noise_high_hz : float
        The residual against the noise at rest (`freerock.identification.against_noise.AgainstRest`).
    added_damping : float
        Standard errors by which a number that the law lacks would be above zero.
    pulls_p : float
        Chance of so large a pull of any input as the law requires.
    pulled : str
        That input, in words.
    """

    model: str
    n_freed: int
    success: bool = False
    message: str = ""
    fitted: bool = True
    epsilon_theta: float = math.nan
    epsilon_holdout: float = math.nan
    bic: float = math.nan
    charged: float = 0.0
    noise_p: float = math.nan
    noise_ratio: float = math.nan
    noise_low_hz: float = math.nan
    noise_high_hz: float = math.nan
    added_damping: float = math.nan
    pulls_p: float = 1.0
    pulled: str = ""

    @property
    def objection(self) -> str:
        """Why the candidate does not explain the run by itself; "" where it does."""
        if not self.fitted or not self.success:
            return self.message or "the fit may not be used"
        if self.epsilon_holdout > 1:
            held_out = plainly(100 * self.epsilon_holdout)
            return f"held-out ε_θ is worse than that of a block at rest: {held_out} %"
        if not self.noise_p > RESIDUAL:
            where = f"{plainly(self.noise_low_hz)} to {plainly(self.noise_high_hz)} Hz"
            times = plainly(self.noise_ratio)
            return f"the residual exceeds the noise: {times} times the power at rest, {where}"
        if not self.pulls_p > REJECTS:
            return f"requires {self.pulled}"
        if self.added_damping > TRACE:
            return f"a parameter that it lacks is significant, {self.added_damping:.1f} standard errors"
        return ""

    @property
    def explains(self) -> bool:
        """Whether only noise is left."""
        return not self.objection

    def rules_out(self, other: "Evidence") -> bool:
        """Whether the data tell this candidate from another one, in its favour.

        By `TELLS` in the BIC; of one that holds the other as a case, where the BIC is lower, in the
        likelihood.
        """
        apart = other.bic - self.bic
        if contains(self.model, other.model) and apart > 0:
            apart += self.charged - other.charged
        return apart > TELLS


@dataclass(frozen=True)
class Judged:
    """A candidate, what is known of it, and what became of it."""

    evidence: Evidence
    status: Status
    reason: str


@dataclass(frozen=True)
class Choice:
    """The answer of a run.

    Parameters
    ----------
    selected : str
        The candidate that is named; "" where none may be.
    explained : bool
        Whether it leaves only noise; else it is the best of those that don't explain the run.
    reason : str
        Why, in words.
    judged : tuple of Judged
        Every candidate, in the order of the evidence.
    stories : str
        A rigid block with worn corners against a compliant foundation, in words, where both come near; else
        "".
    """

    selected: str
    explained: bool
    reason: str
    judged: tuple[Judged, ...] = field(default=())
    stories: str = ""

    @property
    def also_possible(self) -> tuple[str, ...]:
        """The other candidates that the data can't tell from the selected one."""
        return tuple(each.evidence.model for each in self.judged if each.status == "also_possible")


def evidence(fit: Fit) -> Evidence:
    """What `choose` takes of a fit."""
    names = {each.name for each in fields(Evidence)} & {*fit.diagnostics}
    of_residual: dict[str, Any] = {name: fit.diagnostics[name] for name in names}
    return Evidence(
        model=fit.model,
        n_freed=fit.n_parameters,
        success=fit.success,
        message=fit.message,
        epsilon_theta=fit.epsilon_theta,
        epsilon_holdout=fit.epsilon_holdout,
        bic=fit.bic,
        pulled=fit.pulled,
        **of_residual,
    )


def choose(evidence: Sequence[Evidence]) -> Choice:
    """The smallest candidate that explains a run, and every other one that the data can't tell from it.

    A candidate explains a run when its residual is the noise at rest (`against_noise.against_rest`), holds no
    trace of a number that the law lacks, and no held-out ε_θ is above 1. Of those, the data tell apart what
    differs by `TELLS` (`Evidence.rules_out`): the wrong one of two candidates of as many numbers is then
    named alone with a chance of Φ(−√TELLS) = 8e-4 at most, however far apart they are, and so is a larger one
    whose further number has one sign. Among the others, the least numbers win, then the lowest BIC. A
    candidate that holds the selected one as a case is needless and not listed beside it, unless its BIC is
    lower.

    Where none explains the run, the lowest held-out ε_θ, and among those within a tenth of it the lowest
    BIC, is named, and said not to explain it. A candidate with a held-out ε_θ above 1 is never named.
    """
    good = [each for each in evidence if each.explains]
    if not good:
        return _least_bad(evidence)
    best = min(each.bic for each in good)
    left = [each for each in good if not any(other.rules_out(each) for other in good)]
    chosen = min(left, key=lambda each: (each.n_freed, each.bic))
    judged = tuple(_judged(each, chosen, left, best) for each in evidence)
    beside = [each.evidence.model for each in judged if each.status == "also_possible"]
    parameters = f"({chosen.n_freed} parameters)"
    reason = f"the candidate with fewest parameters whose residual agrees with the noise {parameters}"
    if beside:
        reason += f"; the data can't tell it from {_listed(beside)}"
    return Choice(chosen.model, True, reason, judged, _stories(chosen.model, beside, evidence))


def plainly(value: float) -> str:
    """A positive number in three figures without a power of ten: "9770", "0.0321", "97.7 million"."""
    if 1e6 <= value < math.inf:
        return f"{plainly(value / 1e6)} million"
    return np.format_float_positional(value, precision=3, unique=False, fractional=False, trim="-")


def _judged(each: Evidence, chosen: Evidence, left: Sequence[Evidence], best: float) -> Judged:
    """What becomes of a candidate beside the one that is selected."""
    agrees, apart = "its residual agrees with the noise", each.bic - chosen.bic
    status: Status = "rejected"
    if each is chosen:
        status, why = "selected", "the one with fewest parameters whose residual agrees with the noise"
    elif not each.fitted:
        status, why = "not_fitted", each.message
    elif not each.explains:
        why = each.objection
    elif each not in left and each.bic <= best + TELLS:
        why = f"{agrees}, but −2 ln L of a larger candidate is lower by {TELLS:g}"
    elif each not in left:
        why = f"{agrees}, but the BIC is {each.bic - best:.0f} higher"
    elif contains(each.model, chosen.model) and each.bic >= chosen.bic:
        more = each.n_freed - chosen.n_freed
        why = f"needless: {chosen.model} with {more} more parameter{'s' * (more > 1)}"
    else:
        status, why = "also_possible", f"{agrees}; BIC {apart:+.1f}, not significant"
    return Judged(each, status, why)


def _least_bad(evidence: Sequence[Evidence], near: float = 1.1) -> Choice:
    """The best of candidates none of which explains the run; up to `near` times the least ε_θ by the BIC."""
    usable = [each for each in evidence if each.fitted and each.success and not each.epsilon_holdout > 1]
    known = [each.epsilon_holdout for each in usable if math.isfinite(each.epsilon_holdout)]
    close = [each for each in usable if known and each.epsilon_holdout <= near * min(known)] or usable
    chosen = min(close, key=lambda each: each.bic, default=None)
    judged = tuple(
        Judged(each, "not_fitted" if not each.fitted else "selected" if each is chosen else "rejected", why)
        for each in evidence
        for why in (each.objection,)
    )
    if chosen is None:
        failed = not any(each.fitted and each.success for each in evidence)
        why = "every fit failed" if failed else "every held-out ε_θ is above 1: worse than a block at rest"
        return Choice("", False, why, judged)
    reason = "no candidate explains the run; "
    if known:
        reason += f"held-out ε_θ = {plainly(100 * chosen.epsilon_holdout)} %, the lowest"
        reason += f" BIC of {len(close)} within a tenth of the best" if len(close) > 1 else ""
    else:
        reason += "the lowest BIC"
    return Choice(chosen.model, False, reason, judged, _stories(chosen.model, [], evidence))


def _stories(chosen: str, beside: Sequence[str], evidence: Iterable[Evidence]) -> str:
    """Worn corners of a rigid block against a compliant foundation, where both come near."""
    near = [each for each in evidence if (each.success or not each.fitted) and each.epsilon_theta <= NEAR]
    worn = [each for each in near if CANDIDATES[each.model].width and not law_of(each.model).is_foundation]
    soft = [each for each in near if law_of(each.model).is_foundation]
    if not (worn and soft):
        return ""
    both = [min(story, key=lambda each: each.epsilon_theta) for story in (worn, soft)]
    told = [
        f"{story} ({MODEL_LABELS[each.model]}, ε_θ = {100 * each.epsilon_theta:.2g} %)"
        for story, each in zip(
            ("a rigid block with worn corners", "a compliant foundation"), both, strict=True
        )
    ]
    text = f"Both {told[0]} and {told[1]} come as near as published fits do (ε_θ up to {100 * NEAR:g} %). "
    if sum(each.model in (chosen, *beside) for each in both) == 2:
        return text + "The data can't tell them apart."
    explaining = [each.explains for each in both]
    if not any(explaining):
        return text + "Neither explains the run."
    first, other = both if explaining[0] and both[0].model == chosen else both[::-1]
    labels = MODEL_LABELS[first.model], MODEL_LABELS[other.model]
    return text + f"Only {labels[0]} leaves nothing but noise, which rules {labels[1]} out."


def _listed(models: Sequence[str]) -> str:
    return ", ".join(MODEL_LABELS[model] for model in models)
