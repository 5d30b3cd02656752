"""Do the later swings ask for what was freed beside the release?

A hand that pushes or brakes a block before its first top leaves no trace but the height of that top; a base
off level and rounded edges act on every swing. Where the release is freed, a little tilt may take up what no
release from rest can: of six records of a brake that seemed off level by 0.0005 to 0.005 degrees, the later
swings asked for none. So may another width or kinematics: of two such records, k off by 4.5 and 1.9 standard
errors, the law as the paper has it explained the later swings.
"""

from collections.abc import Callable
from dataclasses import replace

from freerock.errors import FreerockError
from freerock.identification.diagnosis import off_zero
from freerock.identification.fit import Fit
from freerock.identification.least_squares import least_squares
from freerock.identification.levels import ASKED, SURE_EDGES
from freerock.identification.nuisances import at_end, settled
from freerock.identification.search import follow, growing_horizons
from freerock.identification.settings import FitSettings
from freerock.identification.start import from_top, posed, tops_of
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, MODELS
from freerock.runs.motion import Motion
from freerock.selection.disturbance import leaves_noise
from freerock.selection.hypotheses import Hypotheses, Hypothesis

# At the first tops a squat block on a soft bed still bounces, which looks like a tilt of one sign at
# the first and of the other at the second.
TOPS = 2


def asked_later(block: Block, motion: Motion, settings: FitSettings, fit: Fit) -> set[str]:
    """What a run asks for (`diagnosis.off_zero`) from its first and from its second top on, with one sign.

    Nothing of a run without two tops.

    Parameters
    ----------
    block : Block
    motion : Motion
        The run.
    settings : FitSettings
        Those that take base and edges for granted.
    fit : Fit
        Of the run, with more freed: where fits of the later swings start.
    """
    tops = tops_of(motion)[:TOPS]
    if len(tops) < TOPS:
        return set()
    first, second = (_off_zero(block, from_top(motion, top), settings, fit) for top in tops)
    least = {"edges": SURE_EDGES}
    return {
        name
        for name in {*first} & {*second}
        if first[name] * second[name] > 0
        and min(abs(first[name]), abs(second[name])) > least.get(name, ASKED)
    }


def lasts(each: Hypothesis, fit: Fit, block: Block, motion: Motion, hypotheses: Hypotheses) -> bool:
    """Whether the later swings require what a hypothesis frees beside the release.

    Parameters
    ----------
    each : Hypothesis
        One that widens the release.
    fit : Fit
        Of the run under it.
    block : Block
    motion : Motion
        The run.
    hypotheses : Hypotheses
        Those of the campaign.
    """
    lasting = {*each.widened} - {"release"}
    if CANDIDATES[each.model].is_rival and law_suffices(block, motion, hypotheses.settings, fit):
        return False
    return not lasting or lasting <= asked_later(block, motion, hypotheses.settings(each.model), fit)


def law_suffices(block: Block, motion: Motion, settings: Callable[[str], FitSettings], fit: Fit) -> bool:
    """Whether the law of a rival, as the paper has it, leaves only noise of a run from its first top on.

    Parameters
    ----------
    block : Block
    motion : Motion
        The run.
    settings : callable
        Those of the fit of a candidate that take base, edges and release for granted.
    fit : Fit
        Of the rival to the run: where the fit of the later swings starts.
    """
    law, tops = CANDIDATES[fit.model].law, tops_of(motion)
    start = {name: fit.values[name] for name in MODELS[law]}
    return bool(tops) and leaves_noise(law, block, settings(law), start, from_top(motion, tops[0]))


def _off_zero(block: Block, part: Motion, settings: FitSettings, fit: Fit) -> dict[str, float]:
    try:
        problem = posed(fit.model, (block,), (part,), settings)
    except FreerockError:  # too few samples
        return {}
    start = {name: fit.values[name] for name in (*MODELS[fit.model], "width") if name in fit.values}
    x = follow(problem.rough(), problem.start_at(start), growing_horizons(part)).x
    problem = replace(problem, rtol=fit.diagnostics["rtol"])
    x = least_squares(problem, x, problem.samples()).x
    return off_zero(
        settled(problem, x)
        or at_end(problem, dict(zip(problem.names, problem.physical(x).tolist(), strict=True)), None)
    )
