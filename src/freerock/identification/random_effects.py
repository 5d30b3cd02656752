"""The mean of runs that differ by more than their noise, their spread, and what the next run will give."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, gammaincinv, stdtrit

from freerock.arrays import Floats
from freerock.identification.estimate import NORMAL_95

LEVEL = 0.95  # of all intervals


@dataclass(frozen=True)
class Population:
    """Values drawn from a normal population, each measured with a known noise.

    All are on the scale of the values, which the population is normal on; NaN where one value says nothing
    of it.

    Parameters
    ----------
    n : int
        How many values.
    mean, stderr, low, high : float
        Of the population, its standard error and 95 % interval; of a single value its own.
    tau, tau_low, tau_high : float
        Standard deviation of the population, without the noise, and its 95 % interval.
    next_low, next_high : float
        Interval in which the next value that is measured lies with 95 % probability.
    p : float
        Chance that values of one truth scatter as much by their noise alone.
    """

    n: int
    mean: float
    stderr: float
    low: float
    high: float
    tau: float = math.nan
    tau_low: float = math.nan
    tau_high: float = math.nan
    next_low: float = math.nan
    next_high: float = math.nan
    p: float = math.nan


def population(values: Sequence[float] | Floats, stderrs: Sequence[float] | Floats) -> Population:
    """Random effects: y_i = μ + u_i + e_i with u_i of the population and e_i of the noise of each value.

    The spread is that of Paule and Mandel (1982, doi:10.6028/jres.087.022), its interval from the quantiles
    of the same sum (Viechtbauer 2007, doi:10.1002/sim.2514). The error of the mean is that of Hartung and
    Knapp (2001, doi:10.1002/sim.791) with Student's t of n - 1 degrees of freedom, and so is the next
    value's: for equal noise these are the intervals of a sample of n values.

    Parameters
    ----------
    values, stderrs : array_like, shape (n,)
        Each value and the standard error of its noise, above zero.

    Raises
    ------
    ValueError
        No value, or a standard error that is not above zero.
    """
    y, variance = np.asarray(values, float), np.asarray(stderrs, float) ** 2
    n = len(y)
    if not n or not np.all(variance > 0):
        raise ValueError("a population needs values with standard errors above zero")
    if n == 1:
        half = NORMAL_95 * math.sqrt(variance[0])
        return Population(1, float(y[0]), math.sqrt(variance[0]), float(y[0]) - half, float(y[0]) + half)

    dof = n - 1
    tau, tau_low, tau_high = common_spread([(y, variance)])
    weights = 1 / (variance + tau**2)
    mean = float(weights @ y / weights.sum())
    ratio = _scatter([(y, variance)], tau**2) / dof  # 1 where there is a spread
    squared = ratio / float(weights.sum())
    quantile = float(stdtrit(dof, (1 + LEVEL) / 2))
    half = quantile * math.sqrt(squared)
    beside = quantile * math.sqrt(squared + ratio * (tau**2 + float(np.median(variance))))
    return Population(
        n=n,
        mean=mean,
        stderr=math.sqrt(squared),
        low=mean - half,
        high=mean + half,
        tau=tau,
        tau_low=tau_low,
        tau_high=tau_high,
        next_low=mean - beside,
        next_high=mean + beside,
        p=float(chdtrc(dof, _scatter([(y, variance)], 0.0))),
    )


def common_spread(samples: Sequence[tuple[Floats, Floats]]) -> tuple[float, float, float]:
    """The spread τ that several populations have in common, each with a mean of its own; its 95 % interval.

    Of one population those of Paule and Mandel and of Viechtbauer; of several their sums are added, and so
    are the degrees of freedom.

    Parameters
    ----------
    samples : sequence of (ndarray, ndarray), shapes (n,)
        Values of each population and the variances of their noise, above zero; one of two values at least.
    """
    from scipy.optimize import brentq  # a fifth of a second, of which a report has no need

    dof = sum(len(y) - 1 for y, _ in samples)
    squares = float(sum(np.sum((y - y.mean()) ** 2) for y, _ in samples))

    def spread(of_scatter: float) -> float:
        """τ at which the scatter is so much; 0 where it is less without any."""
        if _scatter(samples, 0.0) <= of_scatter:
            return 0.0
        most = 1.001 * squares / of_scatter  # not to fall short by a rounding
        return math.sqrt(
            brentq(lambda tau2: _scatter(samples, tau2) - of_scatter, 0.0, most, xtol=1e-12 * most)
        )

    # quantiles of χ² with so many degrees of freedom
    low, high = (2 * float(gammaincinv(dof / 2, share)) for share in ((1 + LEVEL) / 2, (1 - LEVEL) / 2))
    return spread(dof), spread(low), spread(high)


def _scatter(samples: Sequence[tuple[Floats, Floats]], tau2: float) -> float:
    """Sum of squares around the means over what the spread and the noise explain of it."""
    total = 0.0
    for y, variance in samples:
        weights = 1 / (variance + tau2)
        total += float(weights @ (y - weights @ y / weights.sum()) ** 2)
    return total
