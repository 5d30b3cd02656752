"""Noise that is louder while the block moves than at rest, octave by octave.

Differences of the sixth order of means say nothing of a smooth motion, and the remainder is noise.
They are taken about the tops, away from impacts.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from freerock.arrays import Floats
from freerock.runs.noise import Noise
from freerock.runs.sums import covariance_of_sums

SIXTH = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
SWING = 20.0  # standard deviations of the noise that a swing is high which tells of it
LONGEST = 8  # means of the noise in one of a difference, at most: beyond them the motion itself is seen
INNER = 0.8  # of a swing, about its middle, that is looked at
FEWEST = 6  # differences that tell
SURE = 2.5  # standard errors by which noise is louder
OF_MEDIAN = 0.4549  # the median of squares of normal numbers
FARTHEST = 9.0  # times what that median tells, at most, does a square count: what jumps is no noise
EFFICIENCY = 0.8  # degrees of freedom of a square: its differences overlap
EXTRAPOLATED = 4.0  # degrees of freedom, at most, with which octaves below those seen are known
STEEPEST = 4.0  # times as loud an octave below those seen, at most: as of noise of the first order


def in_motion(noise: Noise, theta: Floats, sigma: Floats, swings: Iterable[slice]) -> Noise:
    """Noise of a sensor, as loud in each octave as it is while the block swings.

    Parameters
    ----------
    noise : Noise
        At rest, over sigma.
    theta, sigma : ndarray, shape (n_time,)
        Of a motion, rotation and the standard deviation of its noise [rad].
    swings : iterable of slice
        Between impacts.
    """
    pieces = [_means(noise, theta[each] / sigma[each]) for each in swings]
    factors, seen, told = list[float](), list[float](), list[float]()
    for k in range(min(int(math.log2(LONGEST)) + 1, len(noise.ratio))):
        weights, expected = _difference(noise, k)
        long = [each for each in pieces if len(each) >= len(weights)]
        found = np.array([x for each in long for x in np.convolve(each, weights, "valid")[:: 3 * 2**k]])
        found = found[np.isfinite(found)]
        if found.size < FEWEST:
            break
        squares = found**2 / expected
        ratio = float(np.mean(np.minimum(squares, FARTHEST / OF_MEDIAN * np.median(squares))))
        dof = found.size * EFFICIENCY
        louder = ratio > 1 + SURE * math.sqrt(2 / dof)
        factors.append(ratio if louder else 1.0)
        seen.append(ratio)
        told.append(dof if louder else math.inf)
    if max(factors, default=1.0) == 1.0:
        return noise
    whole = np.ones(len(noise.ratio))
    whole[len(whole) - len(factors) :] = factors[::-1]
    below = slice(0, len(whole) - len(factors))
    steeper = (factors[-1] - 1) / max(seen[-2] - 1, 1 / STEEPEST) if len(seen) > 1 else 1.0
    whole[below] = 1 + (factors[-1] - 1) * min(max(steeper, 1.0), STEEPEST)
    dof = np.full(len(whole), min(told[-1], EXTRAPOLATED) if factors[-1] > 1.0 else math.inf)
    dof[len(whole) - len(told) :] = told[::-1]
    return replace(noise, ratio=noise.ratio * whole, dof=np.minimum(noise.dof, dof))


@lru_cache(32)
def _difference(noise: Noise, k: int) -> tuple[Floats, float]:
    """Weights of a difference of means of 2ᵏ, and its variance by the noise."""
    weights = np.repeat(SIXTH, 2**k) / 2**k
    return weights, float(covariance_of_sums(noise, weights[None])[0, 0])


def _means(noise: Noise, values: Floats) -> Floats:
    """Means of as many samples as the noise takes, about the middle of a swing."""
    margin = (1 - INNER) / 2 * len(values)
    inner = values[int(margin) : len(values) - int(margin)]
    m = noise.averaged
    return np.asarray(inner[: len(inner) // m * m].reshape(-1, m).mean(axis=1))


def swings_of(theta: Floats, lowest: float) -> list[slice]:
    """The stretches in which |θ| is higher than `lowest` [rad] with one sign, after the first."""
    high = np.flatnonzero(np.abs(theta) > lowest)
    if not high.size:
        return []
    turns = np.flatnonzero(np.diff(theta[high] > 0))
    first, last = high[np.append(0, turns + 1)], high[np.append(turns, high.size - 1)]
    return [slice(int(i), int(j) + 1) for i, j in zip(first[1:], last[1:], strict=True)]
