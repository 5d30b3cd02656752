"""Effect of the noise on the peaks of a run: on residuals of their fits, and on their errors."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len

from freerock.arrays import Floats
from freerock.runs.impact_kernel import PEAK_DEGREE, SWING_SAMPLES, NoisySamples, Residual
from freerock.runs.noise_spectrum import Noise
from freerock.runs.sums import covariance_of_means, covariance_of_sums

TYPICAL = 0.5  # of a swing, the window in which a residual is looked at
COARSE = 2  # steps in a factor of two: white noise is white, however its spectrum was drawn


def left_of(noise: Noise, swings: Sequence[tuple[int, int]]) -> Residual:
    """What the fit of a peak leaves of the noise, over what it would if that were white and of variance 1.

    Parameters
    ----------
    noise : Noise
        Over σ.
    swings : sequence of (int, int)
        First and last sample of each.
    """
    samples = float(np.median([last - first for first, last in swings[1:]]))
    together = max(samples / SWING_SAMPLES, 1.0)  # samples in a mean
    n = max(int(min(samples / together, SWING_SAMPLES) * TYPICAL), PEAK_DEGREE + 4)
    covariance = covariance_of_means(noise, together, n) * together
    basis = np.linalg.qr(np.vander(np.linspace(-1, 1, n), PEAK_DEGREE + 1))[0]
    left = covariance - basis @ (basis.T @ covariance)
    left -= (left @ basis) @ basis.T
    freedom = n - PEAK_DEGREE - 1
    trace = float(np.trace(left))
    found = trace / freedom, trace**2 / float(np.sum(left * left)) / freedom
    expected, share = np.exp2(np.rint(COARSE * np.log2(found)) / COARSE).tolist()
    return Residual(expected, share, True)


def under_noise(rows: Floats, fits: Floats, motion: NoisySamples, noise: Noise) -> Floats:
    """Put the standard errors of a run's impacts under its noise; return what neighbouring peaks share.

    A peak is linear in the samples of its window: its error is a weighted sum of their noise.

    Parameters
    ----------
    rows : ndarray, shape (n_impacts, 6)
        As `impact_kernel.impact_rows` gives them; written to.
    fits : ndarray, shape (n_impacts, 4)
        Of the peak after each: instant, half its window [s], degree, loudness.
    motion : NoisySamples
    noise : Noise
        Over σ.

    Returns
    -------
    ndarray, shape (n_impacts,)
        Covariance of the heights of the peaks before and after each impact [rad²].
    """
    first_s, span_s = float(motion.t[0]), 1 / noise.rate_hz
    weights, starts, white = list[Floats](), list[int](), np.empty(len(fits))
    for i, (at, reach, degree, _) in enumerate(fits.tolist()):
        low, high = (round((at + side * reach - first_s) / span_s) for side in (-1, 1))
        high = max(high, low + int(degree) + 4)
        x = np.linspace(-1, 1, high - low)
        sigma = np.interp(first_s + (np.arange(low, high) + 0.5) * span_s, motion.t, motion.noise)
        design = np.vander(x, int(degree) + 1, increasing=True) / sigma[:, None]
        weights.append(np.linalg.solve(design.T @ design, design.T)[0])
        white[i] = float(weights[-1] @ weights[-1]) / noise.averaged
        starts.append(low)
    n = max(len(each) for each in weights)
    n = next_fast_len(n + max([b - a for a, b in pairwise(starts)], default=0))
    pairs = np.zeros((len(weights), 2, n))
    for i, own in enumerate(weights):
        pairs[i, 0, : len(own)] = own
        if i + 1 < len(weights):
            later = starts[i + 1] - starts[i]
            pairs[i, 1, later : later + len(weights[i + 1])] = weights[i + 1]
    covariance = covariance_of_sums(noise, pairs)
    loud = fits[:, 3]
    variance = covariance[:, 0, 0] * loud
    wider = np.sqrt(covariance[:, 0, 0] / white)
    rows[:, 5] = np.sqrt(variance)
    rows[1:, 3] = rows[:-1, 5]
    rows[:, 1] *= wider
    shared = np.zeros(len(rows))
    shared[1:] = -covariance[:-1, 0, 1] * np.sqrt(loud[:-1] * loud[1:])  # the peaks are on either side
    return shared
