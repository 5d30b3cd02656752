"""Who is named for a virtual record, and how far its parameters are from the truth."""

import math
from collections.abc import Mapping

from freerock.identification.fit import Fit
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.laws import CANDIDATES, LAWS, law_of
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import Identified
from freerock_bench.virtual_run import Row, Truth

NAMES = ("r", "k", "c", "lambda", "width")


def answer(candidate: str, truth: Truth, found: Identified) -> Row:
    """What the choice says of a run.

    Parameters
    ----------
    candidate : str
        The smallest that holds the truth.
    truth : Truth
    found : Identified
        In the run.

    Returns
    -------
    dict
        named ("" where nothing may be), explained (it leaves only noise), also_possible (names joined by
        spaces), right (the truth's own candidate is named), held (it is named or also possible), wrong (in
        which way the name is wrong, see `what_is_wrong`), n_fits, reason; of each parameter and
        the width X_error_percent, X_error_stderrs and X_inside (its 95 % interval) under the named candidate;
        paper_error_percent and paper_error_stderrs of k under the true law as the paper has it.
    """
    choice = found.choice(BY_DEFAULT)
    named = choice.selected
    row: Row = {
        "named": named,
        "explained": choice.explained,
        "also_possible": " ".join(choice.also_possible),
        "right": named == candidate,
        "held": candidate in (named, *choice.also_possible),
        "wrong": what_is_wrong(candidate, named),
        "n_fits": len(found.fits),
        "reason": choice.reason,
    }
    true = {**truth.parameters, "width": 2 * truth.block.b}
    for name in NAMES:
        percent, stderrs = _error(name, true, found.fits.get(named))
        inside = abs(stderrs) < NORMAL_95 if math.isfinite(stderrs) else math.nan
        row |= {f"{name}_error_percent": percent, f"{name}_error_stderrs": stderrs, f"{name}_inside": inside}
    percent, stderrs = _error("k", true, found.fits.get(CANDIDATES[candidate].law))
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


def _error(name: str, true: Mapping[str, float], fit: Fit | None) -> tuple[float, float]:
    """Error of a parameter in per cent of the truth, and in standard errors; NaN without either."""
    if fit is None or name not in true or name not in fit.parameters:
        return math.nan, math.nan
    at = fit.parameters.index(name)
    error, stderr = float(fit.value[at]) - true[name], float(fit.stderr[at])
    return 100 * error / true[name], error / stderr if stderr > 0 else math.nan
