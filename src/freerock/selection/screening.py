"""A quick fit from a known start: is a candidate worth a full one?"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.nuisances import Nuisances, settled
from freerock.identification.problem import Problem
from freerock.identification.search import SEARCH, approach, follow, growing_horizons
from freerock.identification.settings import FitSettings, check
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.laws import OF_RECORD
from freerock.runs.motion import Motion

ROUGH = 1e-2  # relative change of the sum of squares at which the first swings have given enough


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
        Whether the mean square is beyond what was asked for.
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
        The model's parameters, and what is known of the rest, as `hypotheses.start_from` gives them [SI]; by
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
    grown = (
        math.inf if moves else beyond
    )  # with inputs held, also the true law may leave many times the noise
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
        moved = settled(problem, end.x, SEARCH.samples)
        if moved is not None:
            residual, square = moved.residual, float(moved.prior[0] @ moved.prior[0])
            left = float(np.mean(residual**2)) + moved.level**2 * square / len(residual)
    values = dict(zip(problem.names, problem.physical(end.x).tolist(), strict=True))
    return Screening(
        model,
        values,
        samples.time_s,
        residual,
        left,
        evaluations,
        left > beyond,
    )


def _held(problem: Problem, start: Mapping[str, float], horizon_s: float) -> Solution:
    """What the first swings make of a start with the release as measured.

    They hardly tell k, width and release apart: with all of these free, least squares creep. The mean square
    is what they would leave, were the motion linear in all of them, and none bounded.
    """
    settings = replace(problem.settings, free=tuple(set(problem.settings.free) & {*OF_RECORD}))
    held = replace(problem, settings=settings, n_impacts=0)
    samples = held.samples(horizon_s, SEARCH.samples)
    end = least_squares(held, held.start_at(start), samples, ftol=ROUGH)
    x = problem.start_at(start)
    x[: len(held.common)] = end.x
    jacobian, residual = problem.jacobian(x, samples), problem.residual(x, samples)
    left = residual - jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
    return replace(end, x=x, mean_square=float(np.mean(left**2)))
