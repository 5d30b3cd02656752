"""Quick tests of a run or a part of it: whether a full fit is useful, and what the derivatives require.

A hand that pushes or brakes a block before its first top leaves no trace but the height of that top; a base
off level and rounded edges act on every swing. Where the release is freed, a little tilt may take up what no
release from rest can: of six records of a brake that seemed off level by 0.0005 to 0.005 degrees, the later
swings required none. So may another width or kinematics: of two such records, k off by 4.5 and 1.9 standard
errors, the law as the paper has it explained the later swings.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.against_noise import LOUDNESS, hopeless_from, noise_of
from freerock.identification.diverging_motions import multiplies_errors
from freerock.identification.fit import Fit
from freerock.identification.inputs_with_priors import Nuisances, Posterior, settled
from freerock.identification.intervals import uncertainty
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.likelihood import Likelihood, Whitened
from freerock.identification.problem import Problem
from freerock.identification.search import SEARCH, approach, follow, growing_horizons
from freerock.identification.settings import check, is_rounded
from freerock.identification.significance_levels import ASKED, ASKED_EDGES, ASKED_WIDTH, REJECTS, SURE_EDGES
from freerock.identification.start import from_top, posed, tops_of
from freerock.models.block import Block
from freerock.models.free_parameters import OF_RECORD, PARAMETERS
from freerock.models.laws import CANDIDATES, MODELS, law_of
from freerock.rotation.laboratory import Input
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import Hypothesis


@dataclass(frozen=True)
class Screening:
    """Where a quick fit ended.

    Parameters
    ----------
    model : str
    values : dict of str to float
        All that was freed [SI].
    time_s, residual : ndarray, shape (n_samples,)
        Time since the release [s] of every so many samples, and model minus measured [rad].
    mean_square : float
        Of the residual [rad²]; where the candidate was given up, over the part of the run that was looked at.
    evaluations : int
        Of the residual.
    given_up : bool
        Whether the mean square is beyond what was requested.
    success : bool
        A quick fit has no errors from which to doubt it.
    """

    model: str
    values: dict[str, float]
    time_s: Floats
    residual: Floats
    mean_square: float
    evaluations: int
    given_up: bool
    success: bool = True


def screen(
    model: str,
    block: Block,
    motion: Motion,
    settings: FitSettings,
    start: Mapping[str, float] | None = None,
    beyond: float = math.inf,
) -> Screening:
    """Least squares of a candidate at about a thousand samples, over growing horizons.

    Where it may be given up, the first swings and a quarter come first. There are no standard errors.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
    motion : Motion
    settings : FitSettings
    start : mapping of str to float, optional
        The model's parameters, and what is known of the rest, as `start_from` gives them [SI]; by
        default a scan finds them. No other start is looked for.
    beyond : float
        Mean square residual [rad²] of a part of the run from which the candidate is given up.

    Raises
    ------
    FreerockError
        As of `fit.fit_run`.
    """
    check(model, (block,), settings)
    problem = posed(model, (block,), (motion,), settings).rough()
    moves = bool(Nuisances.of(problem).sources)
    # with inputs held, also the true law may leave many times the noise
    grown = math.inf if moves else beyond
    if start is None:
        end = approach(problem, None, grown)
        evaluations = end.evaluations
    else:
        first, *horizons = growing_horizons(motion)
        end = _held(problem, start, first)
        evaluations = end.evaluations
        if end.mean_square <= grown:
            end = follow(problem, end.x, horizons[::-2][::-1] or [first], grown)
            evaluations += end.evaluations
    samples, left = problem.samples(most=SEARCH.samples), end.mean_square
    residual = problem.residual(end.x, samples)
    if moves or end.mean_square <= beyond:
        moved = settled(problem, end.x, SEARCH.samples, SEARCH.ftol)
        if moved.result is not None:
            residual, left = moved.residual, moved.mean_square
    values = problem.named(end.x)
    return Screening(model, values, samples.time_s, residual, left, evaluations, left > beyond)


def _held(problem: Problem, start: Mapping[str, float], horizon_s: float, rough: float = 1e-2) -> Solution:
    """What the first swings make of a start with the release as measured.

    They hardly tell k, width and release apart: with all of these free, least squares creep. The mean square
    is what they would leave, were the motion linear in all of them, and none bounded. The search ends at a
    relative change `rough` of the sum of squares.
    """
    settings = replace(problem.settings, free=tuple(set(problem.settings.free) & {*OF_RECORD}))
    held = replace(problem, settings=settings)
    samples = held.samples(horizon_s, SEARCH.samples)
    end = least_squares(held, held.start_at(start), samples, ftol=rough)
    x = problem.start_at(start)
    x[: len(held.common)] = end.x
    jacobian, residual = problem.jacobian(x, samples), problem.residual(x, samples)
    left = residual - jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
    return replace(end, x=x, mean_square=float(np.mean(left**2)))


def start_from(each: Hypothesis, ends: Sequence[Fit | Screening]) -> dict[str, float] | None:
    """Where a fit of a hypothesis may start: where the best of those that it extends ended.

    Parameters
    ----------
    each : Hypothesis
    ends : sequence of Fit or Screening
        Of one run, under hypotheses of which it is a neighbour.

    Returns
    -------
    dict of str to float, or None
        The parameters, and what else that fit freed [SI]; of a damping which that law lacks a trace. None
        where no such fit may be used, and for another width of a rigid block: a scan has to find a start.
    """
    usable = [end for end in ends if end.success]
    if not usable:
        return None
    found = min(usable, key=lambda end: float(np.nanmean(end.residual**2))).values
    if not law_of(each.model).is_foundation and CANDIDATES[each.model].width and "width" not in found:
        return None
    traces = {name: PARAMETERS[name].trace * found.get("k", 0.0) for name in MODELS[each.model]}
    return traces | found


def narrowed(best: Posterior) -> tuple[dict[str, float], dict[Input, float]] | None:
    """Where the fit with the contact width as stated may start, from the end of one that frees it.

    By the linear model: numbers and inputs that take up most of what the stated width changes. The width of
    the block moves its contact width, where no other one is stated.

    Parameters
    ----------
    best : Posterior
        Of one run, with the width freed.

    Returns
    -------
    (dict of str to float, dict of Input to float), or None
        The fitted numbers [SI], and the inputs [standard uncertainties]; None where no input moves, or where
        the motion multiplies errors.
    """
    problem, sources, n = best.problem, best.nuisances.sources, len(best.x)
    laboratory, at = best.nuisances.problem.motions[0].laboratory, problem.names.index("width")
    if not sources or laboratory is None or multiplies_errors(problem, best.x):
        return None
    stated = laboratory.block
    name = "width_m" if stated.contact_width_m is None else "contact_width_m"
    width = next((each for each in laboratory.inputs if each.name == name and each.u > 0), None)
    every = [*sources, *([width] if width and width not in sources else [])]
    z = np.append(best.z, np.zeros(len(every) - len(best.z)))
    of_release, rows = problem.prior_of_release(best.x)
    m, level = len(best.residual), best.level
    columns = np.vstack([best.jacobian / level, rows])
    by_inputs = np.vstack([best.by_inputs / level, best.rows_by_inputs[m:]])
    by_inputs = np.hstack([by_inputs, np.zeros((len(by_inputs), len(every) - len(sources)))])
    by_width = columns[:, at] / problem.gradient(best.x)[at, at]
    value = np.append(best.residual / level, of_release)
    value = value + by_width * (2 * stated.b - problem.physical(best.x)[at])
    if width:
        j = every.index(width)
        value = value + by_width * width.u * z[j]
        by_inputs[:, j] += by_width * width.u
    kept = np.delete(np.arange(n), at)
    whole = np.hstack([columns[:, kept], by_inputs])
    whole = np.vstack([whole, np.eye(len(every), whole.shape[1], n - 1)])
    step = -np.linalg.lstsq(whole, np.append(value, z), rcond=None)[0]
    x = best.x.copy()
    x[kept] += step[: n - 1]
    values = problem.named(x)
    del values["width"]
    return values, dict(zip(every, (z + step[n - 1 :]).tolist(), strict=True))


def leaves_noise(
    model: str, block: Block, settings: FitSettings, start: Mapping[str, float] | None, *parts: Motion
) -> bool:
    """Whether the law with one set of parameters leaves only the noise at rest of parts of a run, with inputs
    within their priors.

    Parameters
    ----------
    model : str
    block : Block
    settings : FitSettings
    start : mapping of str to float, or None
        Parameters to start from [SI]; without them a scan finds some.
    parts : Motion
        Of one run, or all of it.
    """
    try:
        problem = posed(model, [block] * len(parts), parts, settings)
    except FreerockError:  # too few samples
        return False
    if start is None:
        quick = approach(problem, None, LOUDNESS.hopeless * max(noise_of(part).variance for part in parts))
    else:
        quick = follow(problem.rough(), problem.start_at(start), growing_horizons(parts[0]))
    if quick.mean_square > hopeless_from(parts):
        return False
    best = _settled(problem, quick.x)
    return best.against_rest.is_noise and uncertainty(best)[1].p_of_pulls > REJECTS


def _settled(problem: Problem, x: Floats) -> Posterior:
    """The linear model where least squares of all samples end, with inputs moved where that may help."""
    return settled(problem, least_squares(problem, x, problem.samples()).x, ftol=SEARCH.ftol)


def asks_for(best: Posterior) -> tuple[str, ...]:
    """What a fit takes for granted, and the data ask to be found: "release", "tilt", "edge_radius", "width".

    What they require most comes first. By the ratio of likelihoods under the noise at rest, with the
    derivative by the tilt of the base or by the contact width, with what edges of a small radius would
    change, or with a free release, beside those by all that the fit frees and by its inputs. Worn corners and
    rounded edges are common, and the derivative sees a part of what they change: the BIC decides of them.

    Parameters
    ----------
    best : Posterior
        Of one run, at the tolerance of the fit.
    """
    off, least = off_zero(best), {"edge_radius": ASKED_EDGES, "width": ASKED_WIDTH}
    asked = [name for name in off if abs(off[name]) > least.get(name, ASKED)]
    return tuple(sorted(asked, key=lambda name: -abs(off[name])))


def off_zero(best: Posterior, edge_m: float = 3e-5) -> dict[str, float]:
    """By how many standard errors what `asks_for` may name would be off zero, with its sign.

    Edges only where they would be rounded, by the difference quotient of a radius: what they do grows with
    its square. Nothing of a motion that multiplies errors (`diverging_motions`): derivatives are none there.
    """
    problem, x = best.problem, best.x
    if multiplies_errors(problem, x):
        return {}

    def beside(value: float, name: str) -> Floats:
        return problem.curve(x, best.own, problem.exact_rtol, {name: value})

    def slope(name: str, at: float, step: float) -> Floats:
        return (beside(at + step, name) - beside(at - step, name)) / (2 * step)

    found, (value, rows) = dict[str, Likelihood](), best.prior
    of_release = len(value) - len(best.z)
    if of_release:
        found["release"] = best.beside((value[of_release:], rows[of_release:])).likelihood()
    elif not (best.free.all() or problem.settings.loose_release):
        held = Whitened(best.residual, best.jacobian, best.samples.lengths, [problem.motions[0].noise])
        found["release"] = held.likelihood()
    if "tilt" not in problem.names:
        found["tilt"] = best.whitened.adding(slope("tilt", 0.0, PARAMETERS["tilt"].step))
    if "width" not in problem.names:
        width = 2 * problem.blocks[0].b
        found["width"] = best.whitened.adding(slope("width", width, width * PARAMETERS["width"].step))
    if "edge_radius" not in problem.names and is_rounded(problem.model, problem.settings.debonding):
        edges = best.whitened.adding(beside(edge_m, "edge_radius") - best.curve)
        if edges.step[-1] > 0:
            found["edge_radius"] = edges
    without = best.whitened.likelihood().minus_two_log
    gain = {name: max(without - each.minus_two_log, 0.0) for name, each in found.items()}
    return {name: float(np.copysign(np.sqrt(gain[name]), found[name].step[-1])) for name in found}


def blur_of(best: Posterior, blur_s: float = 5e-4) -> tuple[float, float]:
    """How much slower the sensor is than stated, as a fit has it that takes its response for known.

    A mean over a time T about each sample adds T² θ̈/24; the derivative by T² is that of a mean of three
    samples, and as in `off_zero` the ratio of likelihoods is one of linear models.

    Parameters
    ----------
    best : Posterior
        As of `asks_for`.
    blur_s : float
        Step of the difference quotient [s].

    Returns
    -------
    off_zero : float
        By how many standard errors T² is above zero; negative where the sensor would be faster.
    averaging_s : float
        T [s]; 0 where it would be negative.
    """
    problem, x, own = best.problem, best.x, best.own
    beside = [
        problem.curve(x, replace(own, time_s=own.time_s + shift_s), problem.exact_rtol)
        for shift_s in (blur_s, -blur_s)
    ]
    slower = best.whitened.adding((sum(beside) - 2 * best.curve) / (24 * blur_s**2))
    gain = best.whitened.likelihood().minus_two_log - slower.minus_two_log
    step = float(slower.step[-1])
    return float(np.copysign(np.sqrt(max(gain, 0.0)), step)), float(np.sqrt(max(step, 0.0)))


def asked_later(block: Block, motion: Motion, settings: FitSettings, fit: Fit) -> set[str]:
    """What a run requires (`off_zero`) from its first and from its second top on, with one sign.

    At the first tops a squat block on a soft bed still bounces, which looks like a tilt of one sign at the
    first and of the other at the second. Nothing of a run without two tops.

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
    tops = tops_of(motion)[:2]
    if len(tops) < 2:
        return set()
    first, second = (_off_zero(block, from_top(motion, top), settings, fit) for top in tops)
    least = {"edge_radius": SURE_EDGES}
    return {
        name
        for name in {*first} & {*second}
        if first[name] * second[name] > 0
        and min(abs(first[name]), abs(second[name])) > least.get(name, ASKED)
    }


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
    return off_zero(_settled(problem, x))
