"""The mean of members that differ by more than their noise, their spread, and what the next one will give.

Members are the runs of a record or the records of a foundation. Their covariance is

    V = diag(σ²) + S Sᵀ + τ² I:

noise of each, shifts by one standard uncertainty of each input, spread between members. The mean is the
convex combination of the members with the least variance wᵀ V w.
"""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, gammaincinv, stdtr, stdtrit

from freerock.arrays import Floats
from freerock.identification.significance_levels import NORMAL_95
from freerock.populations.priors import RUNS, Prior

LEVEL = 0.95  # of all intervals
LARGEST = math.log(sys.float_info.max)


def exponential(logarithms: ArrayLike) -> Floats:
    """Values whose logarithms these are; infinite where no float is as large."""
    known = np.asarray(logarithms, float)
    return np.where(known > LARGEST, np.inf, np.exp(np.minimum(known, LARGEST)))


@dataclass(frozen=True)
class Population:
    """Values drawn from a normal population, each measured with a known noise.

    All are on the scale of the values, which the population is normal on; NaN where nothing is known.

    Parameters
    ----------
    n : int
        How many values.
    mean, stderr, low, high : float
        Of the population, its standard error and 95 % interval without what all members share; of a single
        value those of its noise.
    u, total_low, total_high : float
        Total standard uncertainty of the mean, with all inputs, and its 95 % interval.
    weights : ndarray, shape (n,)
        Of the values in their mean: none is negative, their sum is 1.
    tau, tau_low, tau_high : float
        Standard deviation of the population, without noise and inputs, and its 95 % interval.
    next_low, next_high : float
        Interval in which the next value that is measured lies with 95 % probability.
    p : float
        Chance that values of one truth scatter as much by noise and inputs alone.
    """

    n: int
    mean: float
    stderr: float = math.nan
    low: float = math.nan
    high: float = math.nan
    u: float = math.nan
    total_low: float = math.nan
    total_high: float = math.nan
    weights: Floats = field(default_factory=lambda: np.empty(0))
    tau: float = math.nan
    tau_low: float = math.nan
    tau_high: float = math.nan
    next_low: float = math.nan
    next_high: float = math.nan
    p: float = math.nan


NODES = 120  # of the integral over τ


def population(
    values: Sequence[float] | Floats,
    stderrs: Sequence[float] | Floats,
    shifts: Floats | None = None,
    *,
    prior: Prior = RUNS,
    dof: float = math.inf,
    shared: Sequence[bool] | None = None,
) -> Population:
    """Members that differ by more than their noise, of which a few alone do not tell their spread.

    The spread τ is that of Paule and Mandel (1982, doi:10.6028/jres.087.022), its interval from the quantiles
    of the same sum (Viechtbauer 2007, doi:10.1002/sim.2514). Intervals of the mean and of the next member
    allow for all spreads that the restricted likelihood and the prior make likely, so that members which
    agree by chance are known no better than their noise allows. Standard uncertainties are these intervals
    over twice 1.96.

    Parameters
    ----------
    values, stderrs : array_like, shape (n,)
        Each value and the standard error of its noise, above zero.
    shifts : ndarray, shape (n, n_inputs), optional
        Of each value for one standard uncertainty of each input. Those that are not finite leave the total
        unknown.
    prior : Prior
        Of the spread.
    dof : float
        Degrees of freedom with which the standard errors are known.
    shared : sequence of bool, shape (n_inputs,), optional
        Inputs that the next member has in common with all members, by default all; it has others of its own.

    Raises
    ------
    ValueError
        No value, or a standard error that is not above zero.
    """
    y, own = np.asarray(values, float), np.asarray(stderrs, float) ** 2
    n = len(y)
    if not n or not np.all(own > 0):
        raise ValueError("a population needs values with standard errors above zero")
    known, lost = _known(np.zeros((n, 0)) if shifts is None else shifts)
    if n == 1:
        stderr, u = math.sqrt(own[0]), math.sqrt(own[0] + np.sum(known**2)) + lost
        half, total = NORMAL_95 * stderr, NORMAL_95 * u
        return _about(float(y[0]), half, total, math.nan, n=1, weights=np.ones(1))
    none = np.diag(own) + known @ known.T
    squares, variances = contrasts(y, none)
    tau, tau_low, tau_high = common_spread([(y, none)])
    covariance = none + tau**2 * np.eye(n)
    weights = least_variance(covariance)
    mean, whole = float(weights @ y), float(weights @ covariance @ weights)
    together = float(np.sum(of_all(known) ** 2))
    apart = np.maximum(np.diag(none) - together, np.finfo(float).eps * np.diag(none))
    chances, spreads = _likely(squares, variances, prior, 1 / float(np.mean(1 / apart)))
    # variance of the mean at each spread, without what all share
    each = np.maximum(whole - together + (spreads - tau**2) * float(weights @ weights), np.min(own) / n**2)
    scatter = float(weights**2 @ own)

    def half_width(variance: Floats) -> float:
        satterthwaite = np.minimum(min(dof, 1e9) * (variance / scatter) ** 2, 1e9)
        return _half_width(chances, np.sqrt(variance), satterthwaite)

    common = known if shared is None else known[:, np.asarray(shared, bool)]
    alike = weights @ common
    another = float(np.median(np.diag(none) - np.sum(common**2, axis=1)))
    beside = another - float(alike @ alike) + float(np.sum((alike - np.median(common, axis=0)) ** 2))
    half, total, following = map(half_width, (each, each + together, each + together + spreads + beside))
    p = float(chdtrc(n - 1, np.sum(squares / variances)))
    spread = {"tau": tau, "tau_low": tau_low, "tau_high": tau_high}
    return _about(mean, half, total + lost, following, n=n, weights=weights, **spread, p=p)


def _about(mean: float, half: float, total: float, beside: float, **more: Any) -> Population:
    """A population, by half widths of its intervals: without shared inputs, in all, and of the next value."""
    return Population(
        mean=mean,
        stderr=half / NORMAL_95,
        u=total / NORMAL_95,
        low=mean - half,
        high=mean + half,
        total_low=mean - total,
        total_high=mean + total,
        next_low=mean - beside,
        next_high=mean + beside,
        **more,
    )


def least_variance(covariance: Floats) -> Floats:
    """Weights of the convex combination of values with the least variance, shape (n,).

    Those of generalised least squares, where none of these is negative: the mean lies among its members. Its
    variance is at most that of the best member, as its weight alone would be one of the combinations.

    Parameters
    ----------
    covariance : ndarray, shape (n, n)
        Of the values, positive definite.
    """
    from scipy.optimize import nnls  # a fifth of a second, of which a report has no need

    # Σ w = 1 is but one more equation: any weight of it leaves the ratios of the solution as they are
    scale = math.sqrt(float(np.mean(np.diag(covariance))))
    root = np.linalg.cholesky(covariance).T / scale
    n = len(covariance)
    weights = nnls(np.vstack([root, np.ones(n)]), np.append(np.zeros(n), 1.0))[0]
    return np.asarray(weights / weights.sum())


def _known(shifts: Floats) -> tuple[Floats, float]:
    """Shifts, 0 in place of those that are not finite; what is added to a total: NaN where there are any."""
    finite = np.isfinite(shifts)
    return np.where(finite, shifts, 0.0), 0.0 if finite.all() else math.nan


def of_all(shifts: Floats) -> Floats:
    """What all members share of each input: the least shift of any, 0 where signs differ."""
    same = (shifts > 0).all(axis=0) | (shifts < 0).all(axis=0)
    return np.where(same, np.min(np.abs(shifts), axis=0, initial=math.inf), 0.0)


def contrasts(values: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """Squares of n - 1 independent contrasts of values with one mean, and their variances.

    A spread τ adds τ² to each variance; what all values share equally is in none of them. Their likelihood is
    the restricted one.

    Parameters
    ----------
    values : ndarray, shape (n,)
    covariance : ndarray, shape (n,) or (n, n)
        Of the values without a spread; variances alone of independent ones.
    """
    n = len(values)
    full = np.diag(covariance) if covariance.ndim == 1 else covariance
    across = np.linalg.qr(np.column_stack([np.ones(n), np.eye(n)[:, : n - 1]]))[0][:, 1:]
    variances, turned = np.linalg.eigh(across.T @ full @ across)
    return (turned.T @ across.T @ (values - values.mean())) ** 2, np.maximum(variances, 1e-300)


def common_spread(samples: Sequence[tuple[Floats, Floats]]) -> tuple[float, float, float]:
    """The spread τ that several populations have in common, each with a mean of its own; its 95 % interval.

    Of one population those of Paule and Mandel and of Viechtbauer; of several their sums are added, and so
    are the degrees of freedom.

    Parameters
    ----------
    samples : sequence of (ndarray, ndarray), shapes (n,) and (n,) or (n, n)
        Values of each population and their variances or covariance without the spread; one of two values at
        least.
    """
    from scipy.optimize import brentq  # a fifth of a second, of which a report has no need

    squares, variances = np.hstack([contrasts(*each) for each in samples])
    dof = len(squares)

    def spread(of_scatter: float) -> float:
        """τ at which the scatter is so much; 0 where it is less without any."""
        if np.sum(squares / variances) <= of_scatter:
            return 0.0
        most = 1.001 * float(squares.sum()) / of_scatter  # not to fall short by a rounding
        return math.sqrt(
            brentq(
                lambda tau2: float(np.sum(squares / (variances + tau2))) - of_scatter,
                0.0,
                most,
                xtol=1e-12 * most,
            )
        )

    # quantiles of χ² with so many degrees of freedom
    low, high = (2 * float(gammaincinv(dof / 2, share)) for share in ((1 + LEVEL) / 2, (1 - LEVEL) / 2))
    return spread(dof), spread(low), spread(high)


def likely_spreads(samples: Sequence[tuple[Floats, Floats]], prior: Prior = RUNS) -> tuple[Floats, Floats]:
    """Probabilities of spreads that several populations have in common, and the squares of these spreads.

    Parameters
    ----------
    samples : sequence of (ndarray, ndarray), shape (n,) each
        Values of each population and the variances of their noise; two values at least.
    prior : Prior
    """
    squares, variances = np.hstack([contrasts(*each) for each in samples])
    noise = np.hstack([variance for _, variance in samples])
    return _likely(squares, variances, prior, 1 / float(np.mean(1 / noise)))


def _likely(squares: Floats, variances: Floats, prior: Prior, scale2: float) -> tuple[Floats, Floats]:
    """Probabilities of spreads by restricted likelihood and prior, and the squares of these spreads."""
    scale = math.sqrt(scale2)
    far = 100 * (scale + math.sqrt(float(np.mean(squares))))
    taus = np.append(0.0, np.geomspace(1e-3 * scale, far, NODES))
    total = variances + taus[:, None] ** 2
    logarithms = -0.5 * np.sum(np.log(total) + squares / total, axis=1) + np.log(np.gradient(taus))
    logarithms -= prior.power * np.log(prior.share * scale + taus)
    chances = np.exp(logarithms - logarithms.max())
    return chances / chances.sum(), taus**2


def _half_width(chances: Floats, deviations: Floats, dof: Floats) -> float:
    """Half the 95 % interval of a mixture of Student's distributions with one centre."""
    from scipy.optimize import brentq  # a fifth of a second, of which a report has no need

    seen = chances > 1e-12
    chances, deviations, dof = chances[seen], deviations[seen], dof[seen]
    ends = deviations * stdtrit(dof, (1 + LEVEL) / 2)

    def outside(half: float) -> float:
        return LEVEL - float(chances @ (2 * stdtr(dof, half / deviations) - 1))

    return float(brentq(outside, 0.999 * ends.min(), 1.001 * ends.max(), rtol=1e-9))
