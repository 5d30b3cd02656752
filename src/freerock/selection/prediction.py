"""How well a law that was fitted to the other runs of a record predicts the swings of a run.

Each swing of the run that is left out begins from its own start, so that the scatter of the impacts is no
error of the law: the law's numbers come from the other runs, the release and the impacts from the run.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtr

from freerock.arrays import Floats
from freerock.identification.fitted import Fit
from freerock.identification.posed import Posed, minimised
from freerock.identification.run_model import Point, RunModel
from freerock.identification.start import START, crossings_s, whole_s
from freerock.models.laws import law_of

EVALUATIONS = 12
LEAST_SWINGS = 5  # of which a difference and its chance can be told


@dataclass(frozen=True)
class Compared:
    """Two laws that predict the same swings.

    Parameters
    ----------
    ratio : float
        Geometric mean of the error of the first over that of the second.
    p : float
        Chance of so large a difference of equally good laws, by Student's paired test of the logarithms.
    """

    ratio: float
    p: float


def errors_of_swings(fits: Mapping[int, Fit]) -> dict[int, Floats]:
    """Root mean square error of each swing under the numbers of the other runs [rad], by run.

    Parameters
    ----------
    fits : mapping of int to Fit
        Fits of one candidate to the runs of a record, at least two that are to be used.
    """
    usable = {run: fit for run, fit in fits.items() if fit.success and fit.posterior is not None}
    found = dict[int, Floats]()
    for run, fit in usable.items():
        others = [other for number, other in usable.items() if number != run]
        if others:
            found[run] = _left_out(fit, _mean_of(others))
    return found


def compared(one: Mapping[int, Floats], other: Mapping[int, Floats]) -> Compared:
    """Which of two laws predicts the swings of a record better, and by what chance."""
    pairs = [
        np.log(one[run][:n] / other[run][:n])
        for run in one
        if run in other and (n := min(len(one[run]), len(other[run])))
    ]
    apart = np.concatenate(pairs) if pairs else np.zeros(0)
    n = len(apart)
    if n < LEAST_SWINGS:
        return Compared(math.nan, 1.0)
    mean, error = float(np.mean(apart)), float(np.std(apart, ddof=1) / math.sqrt(_independent(apart)))
    if not mean:
        return Compared(1.0, 1.0)
    p = 2 * float(stdtr(max(_independent(apart) - 1, 1), -abs(mean) / error)) if error > 0 else 0.0
    return Compared(math.exp(mean), min(p, 1.0))


def _independent(values: Floats) -> float:
    """Effective number of independent values in a row, by the correlation of neighbours."""
    about = values - values.mean()
    square = float(about @ about)
    rho = float(about[1:] @ about[:-1]) / square if square > 0 else 0.0
    return max(len(values) * (1 - rho) / (1 + rho), 2.0) if rho > 0 else float(len(values))


def _mean_of(fits: list[Fit]) -> dict[str, float]:
    """Means of the law's numbers over runs, of logarithms where they are positive."""
    model = fits[0].posterior.posed.model  # type: ignore[union-attr]
    found = {}
    for name in model.law_names:
        values = np.array([fit.values[name] for fit in fits])
        found[name] = float(np.exp(np.mean(np.log(values))) if (values > 0).all() else np.mean(values))
    return found


def _left_out(fit: Fit, numbers: Mapping[str, float]) -> Floats:
    """Root mean square error of each swing of a run under given numbers of the law [rad]."""
    posterior = fit.posterior
    assert posterior is not None
    own = posterior.posed.model
    held = {name: {"value": numbers[name], "vary": False} for name in law_of(own.candidate).parameters}
    settings = replace(own.settings, parameters={own.law: held})
    model = RunModel(own.candidate, own.block, own.motion, settings, moves_inputs=False)
    crossings = crossings_s(own.motion)
    samples = model.until(whole_s(own.motion), START.samples)
    level = max(posterior.level(), own.motion.sigma_theta)
    impacts = posterior.at.impacts
    if impacts.size < crossings.size:
        impacts = np.append(impacts, np.zeros(crossings.size - impacts.size))
    start = Point({**fit.values, **numbers}, np.zeros(0), impacts)
    wide = Posed(model, samples, START.sigma_r, level, 1e-7)
    end = minimised(wide, start, EVALUATIONS, START.search[1])
    left = model.curve(end.at, samples.time_s) - samples.theta
    swing = np.searchsorted(crossings, samples.time_s)
    n = np.bincount(swing, minlength=crossings.size + 1)
    square = np.bincount(swing, left**2, crossings.size + 1)
    seen = n > 3
    return np.asarray(np.sqrt(square[seen] / n[seen]))
