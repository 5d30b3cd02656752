"""Predict a run from the other runs of its record."""

from collections.abc import Mapping

import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.fit import Fit
from freerock.identification.inputs_with_priors import in_found
from freerock.identification.problem import Problem
from freerock.identification.search import SEARCH
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.free_parameters import PER_RUN
from freerock.models.laws import MODELS
from freerock.runs.motion import Motion


def of_other_runs(
    model: str,
    block: Block,
    motions: Mapping[int, Motion],
    fits: Mapping[int, Fit],
    settings: Mapping[int, FitSettings],
) -> dict[int, float]:
    """ε_θ of each run under the parameters of the others, its own release refitted.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
    motions : mapping of int to Motion
        The runs of a record.
    fits : mapping of int to Fit
        Fits of the candidate to these runs.
    settings : mapping of int to FitSettings
        Those of the fits.

    Returns
    -------
    dict of int to float
        By run; nothing where fewer than two fits may be used. The parameters and a fitted width are the
        geometric means of the others'; tilt and edges are the run's own.
    """
    usable = {number: fit for number, fit in fits.items() if fit.success}
    if len(usable) < 2:
        return {}
    found = {}
    for number, fit in usable.items():
        values = fit.values | _means(model, [other for i, other in usable.items() if i != number])
        stated = posed(model, (block,), (motions[number],), settings[number])
        problem = in_found(stated, fit.contributions)
        x = _released(problem, problem.start_at(values))
        motion = problem.motions[0]
        found[number] = epsilon_theta(motion.time_s, problem.motion(x, 0, motion.time_s), motion.theta)
    return found


def _means(model: str, fits: list[Fit]) -> dict[str, float]:
    """Geometric means of the parameters of some runs, and of a fitted width."""
    names = [name for name in (*MODELS[model], "width") if name in fits[0].parameters]
    values = np.array([[fit.values[name] for name in names] for fit in fits])
    return dict(zip(names, np.exp(np.log(values).mean(axis=0)).tolist(), strict=True))


def _released(problem: Problem, x: Floats, steps: int = 4) -> Floats:
    """The fitted numbers with those of the release at their best, all else as it is: nearly linear."""
    own = np.array([name in PER_RUN for name in problem.names])
    if not own.any():
        return x
    samples = problem.samples(most=SEARCH.samples)
    low, high = np.array(problem.bounds()).T
    for _ in range(steps):
        jacobian = problem.jacobian(x, samples, wanted=PER_RUN)[:, own]
        step = np.linalg.lstsq(jacobian, problem.residual(x, samples), rcond=None)[0]
        x = x.copy()
        x[own] = np.clip(x[own] - step, low[own], high[own])
    return x
