"""As many candidates as a run asks for: rungs by the numbers they free, few first.

The laws named in the campaign are fitted to every run as the paper has them. A rung of their rivals is
fitted only while nothing smaller explains the run, or what does is surpassed by one of those laws; first each
of its candidates is screened by a quick fit, and only those that come near the best are fitted in full.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import groupby

import numpy as np

from freerock.errors import FreerockError
from freerock.identification.candidates import Ladder, start_for
from freerock.identification.choice import NEAR, plainly
from freerock.identification.fit import Fit, evidence, fit_record
from freerock.identification.identified import Identified, LeftOut
from freerock.identification.noise import hopeless_from, noise_of
from freerock.identification.screening import Screening, screen
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, law_of
from freerock.runs.motion import Motion

CONTENDS = 1.25  # times the least mean square of a rung, up to which a screened candidate is fitted in full
# Times the power of the noise, up to which a quick fit in another scene asks for a full one. Set on eight
# records of six mishaps: what explained one left up to 2.7 times, mostly 1.0, what did not 3.0 and more.
FOLLOWED = 4.0
# Times the mean square of a candidate that explains the run, from which a rival is given up; by judgement:
# the BIC would differ by thousands, and a quick fit is within a few per cent of a full one.
BEATEN = 4.0


def of_laws(
    block: Block,
    motion: Motion,
    ladder: Ladder,
    scene: Sequence[str] = (),
    known: tuple[Ladder, Identified] | None = None,
) -> Identified:
    """The laws of the campaign as the paper has them; those fitted so already are `known`."""
    found = Identified(scene=tuple(scene))
    for model in ladder.candidates:
        if CANDIDATES[model].is_rival or law_of(model).cases:
            continue
        if known and model in known[1].fits and known[0].settings(model) == ladder.settings(model):
            found.fits[model] = known[1].fits[model]
        else:
            fit_into(model, block, motion, ladder, found)
    return found


def climbed(found: Identified, block: Block, motion: Motion, ladder: Ladder, at_least: int = 0) -> Identified:
    """The laws with the rivals that the run asks for, and with all that free up to `at_least` numbers."""
    quick = dict[str, Screening]()
    for n, rung in groupby(ladder.candidates, key=ladder.n_freed):
        if n > at_least and any(ladder.n_freed(model) < n for model in found.possible):
            break
        rivals = [model for model in rung if model not in found.fits and model not in found.errors]
        quick |= _climb(rivals, block, motion, ladder, found)
    if not found.explained:
        _nearest(quick, block, motion, ladder, found)
    return found


def _climb(
    rivals: Sequence[str], block: Block, motion: Motion, ladder: Ladder, found: Identified
) -> dict[str, Screening]:
    """One rung: quick fits of all rivals, full ones of those that come near the best.

    A quick fit that is far above the noise on the first swings is not followed. Where the best is far above,
    none is fitted in full; all quick fits are given back.
    """
    explaining = [_mean_square(fit, motion) for fit in found.fits.values() if evidence(fit).explains]
    beyond = BEATEN * max(explaining) if explaining else hopeless_from([motion])
    rigid = max(beyond, NEAR * float(np.nanmean(motion.theta**2)))  # how near a rigid block comes is told
    quick: dict[str, Screening] = {}
    for model in rivals:
        try:
            start = start_for(model, {**found.fits, **quick})
            bar = beyond if law_of(model).is_foundation else rigid
            quick[model] = screen(model, block, motion, ladder.settings(model), start, bar)
        except FreerockError as error:
            found.errors[model] = error
    least = min([*explaining, *(end.mean_square for end in quick.values())], default=math.inf)
    bar = FOLLOWED * noise_of(motion).variance if found.scene else hopeless_from([motion])
    hopeless = not explaining and least > bar
    for model, end in sorted(quick.items(), key=lambda item: item[1].mean_square):
        first_hope = not explaining and end.mean_square == least
        if not hopeless and (first_hope or end.mean_square <= CONTENDS * least):
            fit_into(model, block, motion, ladder, found, end.values)
        else:
            found.left_out[model] = _left_out(end, motion, least)
    return quick


def _nearest(
    quick: Mapping[str, Screening], block: Block, motion: Motion, ladder: Ladder, found: Identified
) -> None:
    """Where nothing explains a run: the smallest candidate that comes near the best, in full."""
    fitted = [_mean_square(fit, motion) for fit in found.fits.values() if fit.success]
    least = min([*fitted, *(end.mean_square for end in quick.values())], default=math.inf)
    near = [model for model in found.left_out if quick[model].mean_square <= CONTENDS * least]
    if near and not any(mean_square <= CONTENDS * least for mean_square in fitted):
        model = min(near, key=lambda name: (ladder.n_freed(name), quick[name].mean_square))
        fit_into(model, block, motion, ladder, found, quick[model].values)
        if model in found.fits:
            found.left_out.pop(model)


def _left_out(end: Screening, motion: Motion, least: float) -> LeftOut:
    """What a quick fit leaves, beside the least mean square of its rung."""
    times = plainly(math.sqrt(end.mean_square / least))
    reason = f"a quick fit leaves {times} times the residual of the best"
    if end.given_up:
        return LeftOut(reason, math.nan)
    return LeftOut(reason, float(np.mean(end.residual**2) / np.nanmean(motion.theta**2)))


def fit_into(
    model: str,
    block: Block,
    motion: Motion,
    ladder: Ladder,
    found: Identified,
    start: Mapping[str, float] | None = None,
) -> None:
    try:
        fit = fit_record(model, block, [motion], ladder.settings(model), start=start)
        found.fits[model] = fit
    except FreerockError as error:
        found.errors[model] = error


def least_square(found: Identified, motion: Motion) -> float:
    """Least mean square residual of the laws as the paper has them [rad²]."""
    laws = [fit for model, fit in found.fits.items() if fit.success and not CANDIDATES[model].is_rival]
    return min((_mean_square(fit, motion) for fit in laws), default=math.inf)


def _mean_square(fit: Fit, motion: Motion) -> float:
    """Mean square residual of the samples that count [rad²]."""
    counts = motion.time_s >= motion.fit_start_s
    return float(np.nanmean(fit.residual[counts] ** 2))
