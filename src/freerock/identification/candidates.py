"""Which candidates there are for a run: few freed numbers first; and where a fit of each starts."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from freerock.identification.fit import Fit
from freerock.identification.screening import Screening
from freerock.identification.settings import freed
from freerock.models.laws import CANDIDATES, LAWS, MODELS, PARAMETERS, law_of


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
