"""Interference of the mains: steady, wandering, or at a frequency that refutes the stated sampling rate."""

import numpy as np
import pytest

from freerock.noise.interference import Mains, fit_mains, mains_ratio

RATE = 2000
TIME = np.arange(4000) / RATE


def test_mains_ratio():
    """z-scores over 150 records of the mains in noise, with samples missing."""
    random, scores = np.random.default_rng(3), []
    for _ in range(150):
        ratio = random.uniform(0.9, 1.1)
        mains = 0.02 * np.cos(2 * np.pi * 50 * ratio * TIME + random.uniform(0, 2 * np.pi))
        signal = 3 - TIME + mains + 0.02 * random.standard_normal(TIME.size)
        signal[500:600] = np.nan
        seen, stderr = mains_ratio(TIME, signal, 50)
        assert stderr < 1e-3
        scores.append((seen - ratio) / stderr)
    assert abs(np.mean(scores)) < 0.25
    assert 0.83 < np.std(scores) < 1.17


@pytest.mark.parametrize(
    ("rate_hz", "seconds", "amplitude"),
    [(2000, 2.0, 0.0), (2000, 0.8, 1.0), (115, 60.0, 1.0), (40, 60.0, 1.0)],
    ids=["noise alone", "too short", "band beyond Nyquist", "mains beyond Nyquist"],
)
def test_no_ratio_where_the_mains_cannot_be_seen(rate_hz, seconds, amplitude):
    time = np.arange(0, seconds, 1 / rate_hz)
    noise = 0.02 * np.random.default_rng(4).standard_normal(time.size)
    assert mains_ratio(time, noise + amplitude * np.cos(2 * np.pi * 50 * time), 50) is None


def test_mains_that_wander_are_left_in_the_signal():
    """A frequency that walks by some hundredths of a hertz within ten minutes, still for 2 s of every 8 s."""
    step = 1 / 500
    time = np.arange(0, 600, step)
    for seed in range(3):
        random, knots = np.random.default_rng(seed), np.arange(0, 660, 30.0)
        walk = np.clip(np.cumsum(random.normal(0, 0.01, knots.size)), -0.03, 0.03)
        mains = 0.02 * np.cos(2 * np.pi * np.cumsum(50 + np.interp(time, knots, walk)) * step)
        still = time % 8 < 2
        noisy = mains + 0.01 * random.standard_normal(time.size)
        assert fit_mains(time[still], noisy[still], 50, step) is None


def test_an_interference_is_the_sum_of_its_harmonics():
    found = Mains(50.1, 1.0, np.array([1 - 2j, 0.5j, 0.25]), 0.0, 0.0).over(TIME)
    turn = 2 * np.pi * 50.1 * TIME
    expected = np.cos(turn) + 2 * np.sin(turn) - 0.5 * np.sin(2 * turn) + 0.25 * np.cos(3 * turn)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_steady_mains_are_fitted_as_steady():
    step = 1 / 500
    time = np.arange(0, 600, step)
    mains = 0.02 * np.cos(2 * np.pi * 50.03 * time)
    for seed in range(20):
        noise = 0.05 * np.random.default_rng(seed).standard_normal(time.size)
        still = time % 8 < 2
        found = fit_mains(time[still], (mains + noise)[still], 50, step)
        left = mains - found.over(time)
        assert np.std(left) < 2 * found.stderr * 0.05
