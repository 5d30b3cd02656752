"""Who is named for a virtual record, and how far its parameters are from the truth."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from freerock.identification.fit import Fit
from freerock.identification.levels import NORMAL_95
from freerock.models.laws import CANDIDATES, LAWS, law_of
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.choice import Choice, Evidence, choose
from freerock.selection.hypotheses_tried import Identified, identify_runs
from freerock_bench.virtual_run import Row, Truth

NAMES = ("r", "k", "c", "lambda", "width")


def identified(truth: Truth, motions: Sequence[Motion]) -> dict[int, Identified]:
    """What is found of the runs of a record, whose block is measured with its full width."""
    return identify_runs(truth.nominal, dict(enumerate(motions, 1)), BY_DEFAULT)


def alone(found: Identified) -> Identified:
    """A run without what its record says of it."""
    return replace(
        found, fits={name: replace(fit, epsilon_holdout_runs=math.nan) for name, fit in found.fits.items()}
    )


def answer(candidate: str, truth: Truth, found: Mapping[int, Identified]) -> Row:
    """What the choice says of the runs of a record together.

    A candidate explains a record if it explains every run; its criteria add up, and its parameters are the
    mean of the runs.

    Parameters
    ----------
    candidate : str
        The smallest that holds the truth.
    truth : Truth
    found : mapping of int to Identified
        The runs of the record.

    Returns
    -------
    dict
        named ("" where nothing may be), explained (it leaves only noise), also_possible (names joined by
        spaces), right (the truth's own candidate is named), held (it is named or also possible), wrong (in
        which way the name is wrong, see `what_is_wrong`), n_fits (of all runs), reason; of each parameter and
        the width X_error_percent, X_error_stderrs and X_inside (its 95 % interval) under the named candidate;
        paper_error_percent and paper_error_stderrs of k under the true law as the paper has it.
    """
    choice = _of_record(found)
    named = choice.selected
    row: Row = {
        "named": named,
        "explained": choice.explained,
        "also_possible": " ".join(choice.also_possible),
        "right": named == candidate,
        "held": candidate in (named, *choice.also_possible),
        "wrong": what_is_wrong(candidate, named),
        "n_fits": sum(len(each.fits) for each in found.values()),
        "reason": choice.reason,
    }
    true = {**truth.parameters, "width": 2 * truth.block.b}
    for name in NAMES:
        percent, stderrs = _error(name, true, [each.fits[named] for each in found.values()] if named else [])
        inside = abs(stderrs) < NORMAL_95 if math.isfinite(stderrs) else math.nan
        row |= {f"{name}_error_percent": percent, f"{name}_error_stderrs": stderrs, f"{name}_inside": inside}
    law = CANDIDATES[candidate].law
    paper = [each.fits[law] for each in found.values() if law in each.fits]
    percent, stderrs = _error("k", true, paper)
    return row | {"paper_error_percent": percent, "paper_error_stderrs": stderrs}


def what_is_wrong(candidate: str, named: str) -> str:
    """In which way a named candidate is not that of the truth.

    Returns
    -------
    str
        "" where it is, or where none is named; "rigid" for a compliant foundation and "compliant" for a rigid
        one; "law"; "kinematics"; "width", which is not freed though it is worn; "larger" than needed.
    """
    if named in ("", candidate):
        return ""
    own, other = CANDIDATES[candidate], CANDIDATES[named]
    if law_of(candidate).is_foundation != law_of(named).is_foundation:
        return "rigid" if law_of(candidate).is_foundation else "compliant"
    if own.law not in (other.law, *LAWS[other.law].cases):
        return "law"
    if own.kinematics != other.kinematics:
        return "kinematics"
    return "width" if own.width and not other.width else "larger"


def _of_record(found: Mapping[int, Identified]) -> Choice:
    """The choice of a run; of several, that of what is known of them together."""
    choices = [each.choice(BY_DEFAULT) for each in found.values()]
    if len(choices) == 1:
        return choices[0]
    by_run = zip(*([judged.evidence for judged in choice.judged] for choice in choices), strict=True)
    return choose([_together(each) for each in by_run])


def _together(runs: Sequence[Evidence]) -> Evidence:
    """What is known of a candidate on several runs."""
    if not all(each.fitted for each in runs):
        missing = next(each for each in runs if not each.fitted)
        return replace(missing, message=f"not fitted to every run: {missing.message}")
    worst = min(runs, key=lambda each: (each.success, each.noise_p))
    return replace(
        worst,
        epsilon_theta=max(each.epsilon_theta for each in runs),
        epsilon_holdout=max(each.epsilon_holdout for each in runs),
        epsilon_holdout_runs=max(each.epsilon_holdout_runs for each in runs),
        bic=sum(each.bic for each in runs),
        noise_p=min(1.0, len(runs) * worst.noise_p),
        added_damping=sum(each.added_damping for each in runs) / math.sqrt(len(runs)),
    )


def _error(name: str, true: Mapping[str, float], fits: Sequence[Fit]) -> tuple[float, float]:
    """Error of the mean of some fits in per cent of the truth, and in standard errors; NaN without either."""
    if not fits or name not in true or any(name not in fit.parameters for fit in fits):
        return math.nan, math.nan
    at = fits[0].parameters.index(name)
    error = float(np.mean([fit.value[at] for fit in fits])) - true[name]
    stderr = float(np.sqrt(np.sum([fit.stderr[at] ** 2 for fit in fits]))) / len(fits)
    return 100 * error / true[name], error / stderr if stderr > 0 else math.nan
