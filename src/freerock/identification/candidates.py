"""Which candidates there are for a run: few freed numbers first; and where a fit of each starts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from freerock.identification.fit import Fit
from freerock.identification.screening import Screening
from freerock.identification.settings import FitSettings, freed, is_rounded
from freerock.models.laws import CANDIDATES, LAWS, MODELS, PARAMETERS, PER_RUN, law_of

BARS_TILT = ("r_per_impact", "tilt")


@dataclass(frozen=True)
class Ladder:
    """Which candidates there are, and how they are fitted.

    Parameters
    ----------
    models : sequence of str
        Laws that are fitted as the paper has them; one with cases only as a rival.
    kinematics : sequence of str
        What their rivals may take; without any there is no rival.
    free : mapping of str to sequence of str
        What is freed besides the parameters of each law.
    options : mapping of str to object
        Of `FitSettings`, but `free`.
    """

    models: Sequence[str]
    kinematics: Sequence[str]
    free: Mapping[str, Sequence[str]]
    options: Mapping[str, Any] = field(default_factory=dict)

    def settings(self, model: str) -> FitSettings:
        """Those of a candidate's fit."""
        return FitSettings(free=self.free[CANDIDATES[model].law], **self.options)

    def n_freed(self, model: str) -> int:
        """How many numbers a candidate frees."""
        return n_freed(model, self.free)

    def freeing(self, scene: Sequence[str]) -> "Ladder":
        """The same without what a fit takes for granted of the scene: a "release" as measured, no "tilt",
        sharp "edges".

        A law whose release is not freed keeps all, one with a restitution per impact a level base; edges are
        rounded under a foundation's law where that is worked out.
        """
        released = [law for law, names in self.free.items() if {*PER_RUN} <= {*names}]
        free, options = dict(self.free), dict(self.options)
        rule = FitSettings(**self.options).debonding
        for law in released:
            if "tilt" in scene and not {*BARS_TILT} & {*free[law]}:
                free[law] = (*free[law], "tilt")
            if "edges" in scene and "edge_radius" not in free[law] and is_rounded(law, rule):
                free[law] = (*free[law], "edge_radius")
        if released and "release" in scene:
            options["loose_release"] = True
        return replace(self, free=free, options=options)

    @property
    def candidates(self) -> tuple[str, ...]:
        """All candidates, few freed numbers first; without a law for which debonding is not worked out, where
        another is left."""
        rule = FitSettings(**self.options).debonding
        worked_out = [law for law in self.models if LAWS[law].allows(rule, len(LAWS[law].dampings))]
        return candidates(worked_out or self.models, self.kinematics, self.free)


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
        doubled = each.width and "width" in free[each.law] if each.law in models else True
        if not doubled and (allowed or not each.is_rival):
            found.append(name)
    return tuple(sorted(found, key=lambda name: n_freed(name, free)))


def n_freed(model: str, free: Mapping[str, Sequence[str]]) -> int:
    """How many numbers a candidate frees on one run; a restitution per impact counts as one more.

    `free` is what is freed besides the parameters of each law.
    """
    return len(MODELS[model]) + len(freed(model, free[CANDIDATES[model].law]))


def start_for(model: str, ends: Mapping[str, Fit | Screening]) -> dict[str, float] | None:
    """Where a fit of a candidate may start: where the best of those that it extends ended.

    Parameters
    ----------
    model : str
    ends : mapping of str to Fit or Screening
        Fits and quick fits of one run by candidate.

    Returns
    -------
    dict of str to float, or None
        The parameters, and what else that fit freed [SI]; of a damping which that law lacks a trace. None
        where no such fit may be used, and for a rigid block: a scan has to find a start.
    """
    if not law_of(model).is_foundation:
        return None
    smaller = [ends[name] for name in _extended(model) if name in ends and ends[name].success]
    if not smaller:
        return None
    found = min(smaller, key=lambda end: float(np.nanmean(end.residual**2))).values
    traces = {name: PARAMETERS[name].trace * found["k"] for name in MODELS[model]}
    return traces | found


def _extended(model: str) -> list[str]:
    """The candidates that a candidate extends: its law guided, without the width, or one of its cases."""
    candidate = CANDIDATES[model]
    laws = (candidate.law, *LAWS[candidate.law].cases)
    guided = LAWS[candidate.law].kinematics[0]
    like = {
        replace(candidate, law=law, kinematics=kinematics, width=width).name
        for law in laws
        for kinematics in {candidate.kinematics, guided}
        for width in {candidate.width, False}
    }
    return [name for name in CANDIDATES if name in like - {model}]


BY_DEFAULT = Ladder(tuple(LAWS), ("guided", "pivoting"), {name: law.free for name, law in LAWS.items()})
