"""A quick fit from a known start: is a candidate worth a full one?"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from freerock.arrays import Floats
from freerock.identification.least_squares import least_squares
from freerock.identification.problem import COARSE, Problem, posed
from freerock.identification.search import GROWTH_SAMPLES, follow, growing_horizons
from freerock.identification.settings import FitSettings, check
from freerock.models.block import Block
from freerock.runs.motion import Motion

STRIDE = 30.0  # times the steps of the difference quotients, at the tolerance of the residual
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
    evaluations : int
        Of the residual.
    """

    model: str
    values: dict[str, float]
    time_s: Floats
    residual: Floats
    evaluations: int


def screen(
    model: str, block: Block, motion: Motion, settings: FitSettings, start: Mapping[str, float]
) -> Screening:
    """Least squares of a candidate at about a thousand samples, over growing horizons.

    There are no standard errors, and no other start is looked for.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
    motion : Motion
    settings : FitSettings
    start : mapping of str to float
        The model's parameters, and what is known of the rest, as `candidates.start_for` gives them [SI].

    Raises
    ------
    FreerockError
        As of `fit.fit_run`.
    """
    check(model, (block,), settings)
    problem = replace(posed(model, (block,), (motion,), settings), fine=COARSE, stride=STRIDE)
    first, *horizons = growing_horizons(motion)
    x, evaluations = _held(problem, start, first)
    end = follow(problem, x, horizons[::-2][::-1] or [first])
    samples = problem.samples(most=GROWTH_SAMPLES)
    values = dict(zip(problem.names, problem.physical(end.x).tolist(), strict=True))
    residual = problem.residual(end.x, samples)
    return Screening(model, values, samples.time_s, residual, evaluations + end.evaluations)


def _held(problem: Problem, start: Mapping[str, float], horizon_s: float) -> tuple[Floats, int]:
    """What the first swings make of a start with the release as measured, and the evaluations it took.

    They hardly tell k, width and release apart: with all of these free, least squares creep.
    """
    settings = replace(problem.settings, free=tuple(set(problem.settings.free) & {"width"}))
    held = replace(problem, settings=settings, n_impacts=0)
    samples = held.samples(horizon_s, GROWTH_SAMPLES)
    end = least_squares(held, held.start_at(start), samples, ftol=ROUGH)
    x = problem.start_at(start)
    x[: len(held.common)] = end.x
    return x, end.evaluations
