"""Interference of the mains: steady, wandering, or at a frequency that refutes the stated sampling rate."""

import numpy as np
import pytest

from freerock.rotation.mains import fit_mains, mains_ratio
from freerock.rotation.signal_noise import StillSignal
from freerock.rotation.still import Phase

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


def test_no_mains_no_ratio():
    random = np.random.default_rng(4)
    for _ in range(100):
        rocking = 2 * np.abs((3 * TIME) % 2 - 1) * np.exp(-TIME)
        assert mains_ratio(TIME, rocking + 0.01 * random.standard_normal(TIME.size), 50) is None
    assert mains_ratio(TIME, np.full(TIME.size, np.nan), 50) is None
    assert mains_ratio(TIME, np.full(TIME.size, 2.5), 50) is None
    assert mains_ratio(np.arange(200) / 100, np.sin(np.arange(200.0)), 50) is None


def wandering_hz(seed, time):
    """Mains frequency that walks by some hundredths of a hertz within minutes."""
    random = np.random.default_rng(seed)
    knots = np.arange(0, time[-1] + 60, 30.0)
    return 50 + np.interp(time, knots, np.clip(np.cumsum(random.normal(0, 0.01, knots.size)), -0.03, 0.03))


@pytest.mark.parametrize("seed", range(3))
def test_mains_that_wander_are_followed(seed):
    """Ten minutes, still for 2 s of every 8 s."""
    step = 1 / 500
    time = np.arange(0, 600, step)
    phase = 2 * np.pi * np.cumsum(wandering_hz(seed, time)) * step
    mains = 0.02 * np.cos(phase) + 0.005 * np.cos(3 * phase + 1)
    noise = 0.01 * np.random.default_rng(seed).standard_normal(time.size)
    still = time % 8 < 2
    found = fit_mains(time[still], (mains + noise)[still], 50, step)
    assert found.phase.shape[1] > 30
    assert found.amplitude == pytest.approx(0.02, rel=0.03)
    left = mains - found.over(time[0], step, time.size)
    assert np.std(left) < 0.15 * np.std(mains)


def test_steady_mains_are_fitted_as_steady():
    step = 1 / 500
    time = np.arange(0, 600, step)
    mains = 0.02 * np.cos(2 * np.pi * 50.03 * time)
    for seed in range(20):
        noise = 0.05 * np.random.default_rng(seed).standard_normal(time.size)
        still = time % 8 < 2
        found = fit_mains(time[still], (mains + noise)[still], 50, step)
        assert found.phase.shape == (2, 2)
        left = mains - found.over(time[0], step, time.size)
        assert np.std(left) < 2 * found.stderr * 0.05


def test_samples_of_still_phases_are_found_by_their_numbers():
    """Also where some of them are invalid."""
    values = np.where((TIME > 0.6) & (TIME < 1.2), np.sin(2 * np.pi * 3 * TIME), 0.0) + 1.0
    values[100:140] = values[3000] = np.nan
    phases = [Phase(0.0, 0.6, 0.9, 0.0), Phase(1.2, 2.0, 1.05, 0.0)]
    signal = StillSignal(TIME, values, 1 / RATE, 0.1, phases)
    inside = [
        (t, y - phase.level)
        for phase in phases
        for t, y in zip(TIME, values, strict=True)
        if phase.start_s + 0.05 <= t < phase.end_s - 0.05 and np.isfinite(y)
    ]
    assert signal.n_inside == len(inside)
    which = np.array([0, 1, 3, 400, 900, 901, 1500, len(inside) - 1])
    np.testing.assert_array_equal(np.array(signal.inside(which)).T, np.array(inside)[which])


def test_mains_that_wander_quickly_are_left_to_the_noise():
    """A phase that goes by a radian in the root of a second can't be foretold through a motion."""
    random = np.random.default_rng(3)
    step = 1 / 2000
    time = step * np.arange(20_000)
    still = (time < 2) | (time > 8)
    phase = 2 * np.pi * 50 * time + np.cumsum(random.standard_normal(time.size)) * np.sqrt(step)
    steady = 2 * np.pi * 50 * time
    noise = 0.02 * random.standard_normal(time.size)
    assert fit_mains(time[still], (0.014 * np.sin(phase) + noise)[still], 50, step) is None
    assert fit_mains(time[still], (0.014 * np.sin(steady) + noise)[still], 50, step) is not None
