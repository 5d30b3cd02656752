"""Noise that is louder while the block moves than at rest: one factor per octave.

Sixth differences of means cancel a smooth motion, so only noise remains; those of twice as many see the
octave below. They are taken near the peaks, away from impacts.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from freerock.arrays import Floats
from freerock.noise.spectrum import CERTAIN, Noise
from freerock.noise.still import one_sided
from freerock.noise.sums import covariance_of_sums

SIXTH = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
HIGH_SWING = 20.0  # standard deviations of the noise that a swing is high which tells of it
LONGEST = 8  # means of the noise in one of a difference, at most: beyond them the motion itself is seen
INNER = 0.8  # of a swing, about its middle, that is looked at
OF_MEDIAN = 0.4549  # the median of squares of normal numbers
FARTHEST = 9.0  # times what that median tells, at most, does a square count: what jumps is no noise
SIZES = int(math.log2(LONGEST)) + 1  # of differences
EFFICIENCY = 0.8  # degrees of freedom of a square: its differences overlap
SURE = 10.0  # twice the logarithm of a likelihood ratio, from which noise is louder
# Octaves below those seen in which it grows on as between the lowest two; set on noises of 1 to 200 ms.
UNSEEN = 3
STEEPEST, SLIGHT = 4.0, 1e-3  # growth from an octave to the one below, at most; power over that at rest


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
    ratio, dof = np.ones(SIZES), np.zeros(SIZES)
    for k in range(SIZES):
        weights, expected = _difference(noise, k)
        long = [each for each in pieces if len(each) >= len(weights)]
        found = np.array([x for each in long for x in np.convolve(each, weights, "valid")[:: 3 * 2**k]])
        squares = found[np.isfinite(found)] ** 2 / expected
        if squares.size:
            ratio[k] = np.mean(np.minimum(squares, FARTHEST / OF_MEDIAN * np.median(squares)))
            dof[k] = squares.size * EFFICIENCY
    louder = ratio > 1
    if float(dof[louder] @ (ratio - 1 - np.log(ratio))[louder]) < SURE:
        return noise
    excess = np.maximum(ratio - 1, 0.0)
    growth = min(max(excess[-1] / max(excess[-2], SLIGHT), 1.0), STEEPEST)
    excess = np.append(excess, excess[-1] * growth ** np.arange(1, UNSEEN + 1))
    octave = np.minimum(np.arange(len(noise.ratio))[::-1], len(excess) - 1)
    known = np.where(louder, dof, CERTAIN)[np.minimum(octave, SIZES - 1)]
    return replace(noise, ratio=noise.ratio * (1 + excess[octave]), dof=np.minimum(noise.dof, known))


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
    first, last = one_sided(theta, lowest)
    return [slice(int(i), int(j) + 1) for i, j in zip(first[1:], last[1:], strict=True)]
