"""Do blocks differ by more than their runs do, and how large a difference would be seen?"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import betainc, fdtrc, fdtri, gammaln, xlogy

from freerock.arrays import Floats


@dataclass(frozen=True)
class DifferenceTest:
    """When blocks differ, and which difference is called visible.

    Parameters
    ----------
    significant, power : float
        Chance of a difference where there is none, and of one that is seen where it is called visible.
    caution : float
        Over its degrees of freedom: how much more of the error a block may have than its runs show.
    largest : float
        Noncentrality of a difference that may be called visible: about a hundred spreads.
    reach : float
        Standard deviations of Poisson's distribution, beyond which it has nothing left.
    least_dof : float
        Not to divide by a rounding.
    """

    significant: float = 0.05
    power: float = 0.8
    caution: float = 5.0
    largest: float = 1e4
    reach: float = 10.0
    least_dof: float = 1e-6


TEST = DifferenceTest()


class Between(NamedTuple):
    """Blocks against runs: F, its p-value, its degrees of freedom, and the s of Rao's approximation."""

    f_ratio: float
    p: float
    dof: tuple[float, float] = (math.nan, math.nan)
    s: float = math.nan


class Matched(NamedTuple):
    """Covariance of the runs and scatter of the blocks' means, alike where blocks do not differ.

    Parameters
    ----------
    within, between : ndarray, shape (n_parameters, n_parameters)
        Σ (1 - n_j/N) S_j, with S_j the covariance of the runs of block j and N runs in all; Σ n_j d_j d_jᵀ
        of the blocks' means around that of all runs, expected to be the same.
    dof_within, dof_between : float
        Degrees of freedom of the Wishart distributions that are like theirs.
    """

    within: Floats
    between: Floats
    dof_within: float
    dof_between: float


def between_blocks(blocks: Collection[Floats]) -> Between:
    """Whether blocks differ by more than their runs do, all parameters together; each block has a spread of
    its own.

    Λ = |E|/|E + H| with E and H of `matched` times their degrees of freedom, as F by Rao (1951): a Brown and
    Forsythe test of several quantities (Coombs and Algina 1996, doi:10.1177/0013164496056003002). For two
    blocks with as many runs each it is that of Krishnamoorthy and Yu (2004, doi:10.1016/j.spl.2003.10.012),
    for one parameter Welch's. Blocks of a single run, whose spread is unknown, take no part.

    Parameters
    ----------
    blocks : collection of ndarray, shapes (n_runs, n_parameters)
        Logarithms of the parameters of each block.

    Returns
    -------
    Between
        NaN where there are too few runs, or too few that scatter.
    """
    found = matched(blocks)
    return by_rao(found) if found else Between(math.nan, math.nan)


def visible_difference(blocks: Collection[Floats]) -> Floats:
    """Difference of each parameter alone between two blocks that `between_blocks` sees in 80 %, at 5 %.

    Any other blocks are half way. Its noncentrality is ω = f m δ² (M⁻¹)_ii/2, with M and f the covariance
    within and the degrees of freedom between of `matched`, m the harmonic mean of the runs of a block, and
    M⁻¹ freed of its bias; that of F as by O'Brien and Shieh N s ((1 + ω/N)^(1/s) - 1), exact for two blocks
    of one spread. The next runs may show fewer degrees of freedom: those of a block with half a run less.
    Arguments as for `between_blocks`; NaN where that is, or where none below a hundred spreads would be seen.
    """
    p = next(iter(blocks)).shape[1]
    found = matched(blocks)
    left = found.dof_within - p + 1 if found else 0.0  # of a parameter beside the others
    if found is None or left < TEST.least_dof:
        return np.full(p, math.nan)
    sizes = [len(own) for own in blocks if len(own) > 1]
    runs = len(sizes) / sum(1 / size for size in sizes)
    dof_within = p - 1 + left * (1 - 0.5 / runs)
    test = by_rao(found._replace(dof_within=dof_within))
    n = dof_within + found.dof_between + 1
    omega = n * ((1 + _noncentrality(*test.dof) / (n * test.s)) ** test.s - 1)
    precision = np.diag(np.linalg.inv(found.within)) * found.dof_between * left / found.dof_within
    return np.asarray(np.sqrt(2 * omega / (runs * precision)))


def matched(blocks: Collection[Floats]) -> Matched | None:
    """Scatter within and between blocks, with degrees of freedom that match its second moments.

    What the runs of a block show of its spread is itself uncertain. Where blocks have unequal numbers of
    runs, the one with the fewest may rule the error and not show it: the share of each block in the degrees
    of freedom within is taken as 1 + `caution`/(n_j - 1) times as large. With equal numbers that cancels.
    None where it can't be known. Arguments as for `between_blocks`.
    """
    several = [own for own in blocks if len(own) > 1]
    sizes = np.array([len(own) for own in several], float)
    p = next(iter(blocks)).shape[1]
    if len(several) < 2 or sizes.sum() - len(sizes) < p:
        return None
    share = sizes / sizes.sum()
    spreads = np.array([np.cov(own.T).reshape(p, p) for own in several])
    means = np.array([own.mean(axis=0) for own in several])
    apart = means - share @ means
    within = np.tensordot(1 - share, spreads, 1)
    if not np.isfinite(np.linalg.slogdet(within)[1]):  # runs that are alike to the last digit
        return None

    relative = spreads @ np.linalg.inv(within)
    own_size = _size(relative)
    weight = (1 - share) * (1 + TEST.caution / (sizes - 1))
    dof_within = _size(np.tensordot(weight, relative, 1)) / (own_size @ (weight**2 / (sizes - 1)))
    moments = own_size @ (1 - 2 * share) + _size(np.tensordot(share, relative, 1))
    return Matched(within, (apart.T * sizes) @ apart, float(dof_within), float(p * (p + 1) / moments))


def by_rao(scatter: Matched) -> Between:
    """Λ as F; exact for one or two parameters and for two blocks if the degrees of freedom are."""
    within, between, nu, q = scatter
    p = len(within)
    if math.isclose(q, 1.0) or p <= 2:  # two blocks: Hotelling's T²
        s = 1.0 if math.isclose(q, 1.0) else float(p)
    else:
        s = math.sqrt((p**2 * q**2 - 4) / (p**2 + q**2 - 5))
    dof = p * q, s * (nu + (q - p - 1) / 2) - (p * q - 2) / 2
    if dof[1] < TEST.least_dof:
        return Between(math.nan, math.nan)
    error = nu * within
    logarithms = np.linalg.slogdet([error, error + q * between])[1]
    f_ratio = math.expm1(max(logarithms[1] - logarithms[0], 0.0) / s) * dof[1] / dof[0]
    return Between(f_ratio, float(fdtrc(*dof, f_ratio)), dof, s)


def _size(matrices: Floats) -> Floats:
    """tr² A + tr A², which the second moments of a Wishart matrix go by."""
    squares = np.einsum("...ij,...ji", matrices, matrices)
    return np.asarray(np.trace(matrices, axis1=-2, axis2=-1) ** 2 + squares)


def _noncentrality(first: float, second: float) -> float:
    """The noncentrality of an F test that sees it with the power of `TEST`; NaN if above the largest."""
    from scipy.optimize import brentq  # a fifth of a second

    def missed(of: float) -> float:
        return beyond(fdtri(first, second, 1 - TEST.significant), first, second, of) - TEST.power

    return float(brentq(missed, 1e-6, TEST.largest)) if missed(TEST.largest) > 0 else math.nan


def beyond(f_ratio: float, first: float, second: float, noncentrality: float) -> float:
    """Chance of a noncentral F, of such degrees of freedom, beyond a value.

    A sum of beta distributions weighted by Poisson's (Johnson, Kotz and Balakrishnan 1995, Continuous
    Univariate Distributions 2, chapter 30): scipy.stats takes half a second to import, and the function of
    scipy.special fails from a noncentrality of 3000 on.
    """
    half = noncentrality / 2
    far = TEST.reach * (math.sqrt(half) + 4)
    count = np.arange(max(0, int(half - far)), int(half + far))
    weight = np.exp(xlogy(count, half) - half - gammaln(count + 1))
    return float(weight @ betainc(second / 2, first / 2 + count, second / (second + first * f_ratio)))
