"""Scatter of the impacts of a record, by the marginal likelihood.

No two impacts of a real block are alike: the rate after impact i is multiplied by 1 + δ_i, δ_i normal with
standard deviation σ_r, one number for the runs of a record. It is 0 where the data do not need it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from freerock.arrays import Floats

LEAST, MOST = 1e-5, 0.3  # of σ_r
NEEDED = 3.84  # -2 ln L by which scatter must be better than none: the 95 % quantile of χ² of one number


@dataclass(frozen=True)
class Told:
    """What the samples of a run tell of its impacts, whatever their prior.

    Parameters
    ----------
    precision : ndarray, shape (n_impacts, n_impacts)
        Of δ, all other numbers fitted beside.
    towards : ndarray, shape (n_impacts,)
        Precision times δ where the samples alone have it.
    """

    precision: Floats
    towards: Floats


@dataclass(frozen=True)
class Scatter:
    """Scatter of the impacts of a record under a law.

    Parameters
    ----------
    sigma_r : float
        Standard deviation of δ; 0 where the data do not need it.
    low, high : float
        95 % interval.
    n_impacts : float
        Impacts that determine it, effectively.
    """

    sigma_r: float
    low: float
    high: float
    n_impacts: float


NONE = Scatter(0.0, 0.0, 0.0, 0.0)


def find_scatter(runs: Sequence[Told]) -> Scatter:
    """σ_r of some runs by the marginal likelihood, δ integrated out.

    Along the eigenvectors of the precision P, with eigenvalues d and b the share of P δ:
    -2 ln L(σ) = Σ ln(1 + σ² d) - σ² b²/(1 + σ² d), 0 at σ = 0.
    """
    d, b = [], []
    for run in runs:
        values, vectors = np.linalg.eigh(run.precision)
        kept = values > 1e-9 * max(values.max(initial=0.0), 1e-300)
        d.append(values[kept])
        b.append((vectors.T @ run.towards)[kept])
    of_d, of_b = np.concatenate(d or [np.zeros(0)]), np.concatenate(b or [np.zeros(0)])
    if not of_d.size:
        return NONE

    def minus_two_log(ln_sigma: float) -> float:
        grown = 1 + np.exp(2 * ln_sigma) * of_d
        return float(np.sum(np.log(grown) - np.exp(2 * ln_sigma) * of_b**2 / grown))

    grid = np.linspace(np.log(LEAST), np.log(MOST), 60)
    values = np.array([minus_two_log(x) for x in grid])
    at = int(np.argmin(values))
    ends = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
    found = minimize_scalar(minus_two_log, bounds=ends, method="bounded", options={"xatol": 1e-3})
    best, least = float(found.x), float(found.fun)
    if least > -NEEDED:
        return NONE
    sigma_r = float(np.exp(best))
    share = sigma_r**2 * of_d / (1 + sigma_r**2 * of_d)
    n = float(np.sum(share**2))
    low, high = (_crossing(minus_two_log, best, least + 3.84, side) for side in (-1.0, 1.0))
    return Scatter(sigma_r, float(np.exp(low)), float(np.exp(high)), n)


def _crossing(function, start: float, level: float, side: float) -> float:  # type: ignore[no-untyped-def]
    """Where a function of ln σ exceeds a level to one side."""
    inside, outside = start, start
    while function(outside) < level and np.log(LEAST) - 1 < outside < np.log(MOST) + 1:
        inside, outside = outside, outside + 0.1 * side
    for _ in range(20):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if function(middle) < level else (inside, middle)
    return outside
