"""Hypotheses on a run: a law with its kinematics, and the priors that it widens."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from freerock.config.fit_settings import FitSettings
from freerock.identification.settings import freed, is_rounded
from freerock.models.free_parameters import PER_RUN
from freerock.models.laws import CANDIDATES, LAWS, MODELS, Candidate, law_of

NOT_TRIED = "not tried because "  # begins the reason of a candidate that the search never came to
WIDENED = ("release", "tilt", "edge_radius")  # priors that a hypothesis may widen, beside the contact width


class Hypothesis(NamedTuple):
    """A candidate, and what of base and release it does not take as stated.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`: law, kinematics, contact width as stated or freed.
    widened : tuple of str
        Of `WIDENED`, in that order: a release other than measured, a base off level, rounded edges; then
        inputs by `Input.label`.
    """

    model: str
    widened: tuple[str, ...] = ()


@dataclass(frozen=True)
class Hypotheses:
    """The hypotheses that a campaign allows, and how each is fitted.

    Parameters
    ----------
    laws : sequence of str
        Those that are fitted as the paper has them; one with cases only as a rival.
    kinematics : sequence of str
        What their rivals may take; without any there is no rival.
    free : mapping of str to sequence of str
        What is freed besides the parameters of each law.
    options : mapping of str to object
        Of `FitSettings`, but `free`.
    """

    laws: Sequence[str]
    kinematics: Sequence[str]
    free: Mapping[str, Sequence[str]]
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def candidates(self) -> tuple[str, ...]:
        """All candidates, few freed numbers first; laws without an implemented debonding only where
        no other remains."""
        worked_out = [law for law in self.laws if LAWS[law].allows(self._rule, len(LAWS[law].ratios))]
        return candidates(worked_out or self.laws, self.kinematics, self.free)

    @property
    def always_fitted(self) -> tuple[str, ...]:
        """The candidates that every run is fitted with: laws as the paper has them, without cases."""
        every = self.candidates
        laws = (name for name in every if not CANDIDATES[name].is_rival and not law_of(name).is_fallback)
        return tuple(laws) or every[:1]

    def settings(self, model: str, widened: Sequence[str] = ()) -> FitSettings:
        """The settings of the fit of a hypothesis."""
        free = (*_free_of(model, self.free), *self.of(model, widened).widened)
        return FitSettings(free=free, **self.options)

    def of(self, model: str, widened: Sequence[str]) -> Hypothesis:
        """The hypothesis of a candidate that widens what it may of some priors."""
        allowed = self._widens(model)
        return Hypothesis(model, tuple(each for each in WIDENED if each in widened and each in allowed))

    def n_freed(self, model: str, widened: Sequence[str] = ()) -> int:
        """How many numbers the fit of a hypothesis frees."""
        settings = self.settings(model, widened)
        held = sum(not each.varies for each in settings.given(model).values()) + settings.loose_release
        return len(MODELS[model]) + len(freed(model, settings.free)) - held

    def neighbours(self, each: Hypothesis) -> Iterator[Hypothesis]:
        """Hypotheses beside one: other kinematics, one more damping, or one prior more widened."""
        for name in self.candidates:
            if _adds_one(CANDIDATES[each.model], CANDIDATES[name]):
                yield self.of(name, each.widened)
        for prior in WIDENED:
            if prior not in each.widened and prior in self._widens(each.model):
                yield self.of(each.model, (*each.widened, prior))

    @property
    def _rule(self) -> str:
        return FitSettings(**self.options).debonding

    def _widens(self, model: str) -> tuple[str, ...]:
        """What a candidate may widen: nothing where its release is held, tilt or edges that are not freed
        already, edges only where they are implemented."""
        free = {*_free_of(model, self.free)}
        if not {*PER_RUN} <= free:
            return ()
        rounds = is_rounded(model, self._rule) and "edge_radius" not in free
        return ("release", *["tilt"] * ("tilt" not in free), *["edge_radius"] * rounds)


def _adds_one(own: Candidate, other: Candidate) -> bool:
    """Whether a candidate has other kinematics than another, or one damping or a freed width more."""
    law, pivots = other.law != own.law, other.kinematics != own.kinematics
    if law + pivots + (other.width != own.width) != 1:
        return False
    if law:
        return own.law in LAWS[other.law].cases
    return pivots or other.width


def candidates(
    models: Sequence[str], kinematics: Sequence[str], free: Mapping[str, Sequence[str]]
) -> tuple[str, ...]:
    """Candidates of a campaign, by how many numbers they free; those alike as in `models.laws.CANDIDATES`.

    Parameters
    ----------
    models : sequence of str
        The laws to fit: each is a candidate as the paper has it, whatever the kinematics.
    kinematics : sequence of str
        What their rivals may take; without any there is no rival. A rigid block has no choice of it.
    free : mapping of str to sequence of str
        What is freed besides the parameters of each law. Where that holds the width already, there is no
        further candidate with it.
    """
    found = []
    for name, each in CANDIDATES.items():
        allowed = each.kinematics in kinematics or (bool(kinematics) and len(LAWS[each.law].kinematics) == 1)
        doubled = each.width and "width" in _free_of(name, free) if each.law in models else True
        if not doubled and (allowed or not each.is_rival):
            found.append(name)
    return tuple(sorted(found, key=lambda name: n_freed(name, free)))


def n_freed(model: str, free: Mapping[str, Sequence[str]]) -> int:
    """How many numbers a candidate frees on one run.

    `free` is what is freed besides the parameters of each law.
    """
    return len(MODELS[model]) + len(freed(model, _free_of(model, free)))


def _free_of(model: str, free: Mapping[str, Sequence[str]]) -> Sequence[str]:
    """What is freed besides the parameters of a candidate, as its row says where `free` lacks its law."""
    return free.get(CANDIDATES[model].law, law_of(model).free)


def contains(larger: str, smaller: str) -> bool:
    """Whether a candidate becomes another when a damping is zero, or the width as given."""
    one, other = CANDIDATES[larger], CANDIDATES[smaller]
    return (
        larger != smaller
        and other.law in (one.law, *LAWS[one.law].cases)
        and one.kinematics == other.kinematics
        and one.width >= other.width
    )


BY_DEFAULT = Hypotheses(
    tuple(LAWS),
    ("guided", "pivoting"),
    {name: law.free for name, law in LAWS.items()},
)
