"""Returns the candidates that a campaign allows, few parameters first; `identify` tries them in tiers.

All that there are is `models.laws.CANDIDATES`: each law with its kinematics, with or without a free width.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from freerock.config.fit_settings import FitSettings
from freerock.models.laws import CANDIDATES, LAWS, law_of


@dataclass(frozen=True)
class Allowed:
    """What a campaign allows to fit, and how.

    Parameters
    ----------
    laws : sequence of str
        Keys of `LAWS`.
    kinematics : sequence of str
        What the base may do sideways; without any the paper's alone, and no width is freed.
    free : mapping of str to sequence of str
        What is freed besides the numbers of each law.
    options : mapping of str to object
        Of `FitSettings`, but `free`.
    """

    laws: Sequence[str]
    kinematics: Sequence[str]
    free: Mapping[str, Sequence[str]] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def candidates(self) -> tuple[str, ...]:
        """At most 14, few numbers first; a law whose debonding is not implemented only where no other is."""
        rule = FitSettings(**self.options).debonding
        implemented = [law for law in self.laws if LAWS[law].allows(rule, len(LAWS[law].ratios))]
        laws = implemented or self.laws
        found = []
        for name, each in CANDIDATES.items():
            rigid = not law_of(name).is_foundation
            known = each.kinematics in self.kinematics or (rigid and bool(self.kinematics))
            doubled = each.width and "width" in self.settings(name).free
            if each.law in laws and not doubled and (known or not each.is_rival):
                found.append(name)
        return tuple(sorted(found, key=n_numbers))

    @property
    def always(self) -> tuple[str, ...]:
        """Candidates that every run is fitted with: the laws as the paper has them, but one with cases."""
        own = [name for name in self.candidates if not CANDIDATES[name].is_rival]
        return tuple(name for name in own if not law_of(name).cases) or tuple(own[:1])

    def settings(self, candidate: str) -> FitSettings:
        """How a candidate is fitted."""
        free = self.free.get(CANDIDATES[candidate].law, law_of(candidate).free)
        return FitSettings(free=free, **self.options)


def n_numbers(candidate: str) -> int:
    """Numbers of the law of a candidate, and a width that is freed."""
    return len(CANDIDATES[candidate].parameters)


def contains(larger: str, smaller: str) -> bool:
    """Whether a candidate becomes another when a damping is zero, or the width as given."""
    one, other = CANDIDATES[larger], CANDIDATES[smaller]
    return (
        larger != smaller
        and other.law in (one.law, *LAWS[one.law].cases)
        and one.kinematics == other.kinematics
        and one.width >= other.width
    )
