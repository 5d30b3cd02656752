"""Release, release angle and restitution under many kinds of noise, on motions of another integrator."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from freerock.noise.rotation_noise import in_motion, noise_at_rest
from freerock.noise.spectrum import (
    autocovariance,
    covariance_of_means,
    covariance_of_sums,
    stderr_of_mean,
    unsure_of_sum,
    white_noise,
)

RATE_HZ = 2000.0


def correlated(n, time_s, generator):
    a = math.exp(-1 / (RATE_HZ * time_s))
    drive = math.sqrt(1 - a * a) * generator.standard_normal(n)
    return lfilter([1.0], [1.0, -a], drive, zi=[a * generator.standard_normal()])[0]


def test_the_law_alone_has_the_covariance_of_a_slow_part_and_white_noise():
    noise = replace(white_noise(1.0, RATE_HZ), slow=20.0, corner=0.01, averaged=1)
    place = np.array([0, 1, 2, 3, 7, 8, 20, 21])
    apart = np.abs(np.subtract.outer(place, place))
    assert np.allclose(noise.by_law(place), autocovariance(noise, 4096)[apart], rtol=1e-3)


def test_errors_of_sums_are_those_of_the_covariance_matrix():
    generator = np.random.default_rng(1)
    noise = noise_at_rest([correlated(8000, 0.02, generator)], RATE_HZ)
    matrix = toeplitz(autocovariance(noise, 128)[:90]) / noise.averaged
    weights = generator.standard_normal((3, 90))
    assert np.allclose(covariance_of_sums(noise, weights), weights @ matrix @ weights.T)
    assert stderr_of_mean(noise, 90) == pytest.approx(
        unsure_of_sum(noise, np.full(90, 1 / 90)) * math.sqrt(matrix.mean())
    )
    means = covariance_of_means(noise, 3.0 * noise.averaged, 30)
    assert means[0, 4] == pytest.approx(matrix[:3, 12:15].mean())


def in_a_swing(loud, seed):
    """Noise in motion, of white noise of 1 at rest, so many times as loud besides while the block moves."""
    generator, time_s = np.random.default_rng(seed), np.arange(4000) / RATE_HZ
    noise = generator.standard_normal(4000) + loud * correlated(4000, 0.01, generator)
    swings, theta = [slice(0, 1300), slice(1300, 2600), slice(2600, 3900)], 1500 * np.cos(5 * time_s)
    return in_motion(white_noise(1.0, RATE_HZ), theta + noise, np.ones(4000), swings)


def test_noise_that_is_louder_in_motion():
    assert np.mean([np.any(in_a_swing(0.0, seed).ratio > 1) for seed in range(40)]) < 0.25
    seen = np.mean([in_a_swing(1.0, seed).ratio for seed in range(40)], axis=0)
    true = noise_at_rest([correlated(200_000, 0.01, np.random.default_rng(1))], RATE_HZ)
    twenty_hz = 20 / true.rate_hz
    expected = 1 + true.density(np.array([twenty_hz]))[0]
    assert seen[true.band(np.array([twenty_hz]))[0] - len(true.ratio)] == pytest.approx(expected, rel=0.5)
