"""A quick fit from a known start: is a candidate worth a full one?"""

from collections.abc import Mapping
from dataclasses import dataclass

from freerock.arrays import Floats
from freerock.identification.problem import posed
from freerock.identification.search import GROWTH_SAMPLES, follow, growing_horizons
from freerock.identification.settings import FitSettings, check
from freerock.models.block import Block
from freerock.runs.motion import Motion


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
    """Least squares of a candidate at about a thousand samples, over half the run and then the whole.

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
    problem = posed(model, (block,), (motion,), settings)
    end = follow(problem, problem.start_at(start), growing_horizons(motion)[-2:])
    samples = problem.samples(most=GROWTH_SAMPLES)
    values = dict(zip(problem.names, problem.physical(end.x).tolist(), strict=True))
    return Screening(model, values, samples.time_s, problem.residual(end.x, samples), end.evaluations)
