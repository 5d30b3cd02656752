"""Impacts against closed forms, the printed numbers of the case, and noise."""

import math

import numpy as np
import pytest

from freerock.models.block import GRAVITY, Block
from freerock.models.housner import housner_swings
from freerock.models.simulate import simulate, simulate_fitted
from freerock.runs.impacts import find_impacts

BLOCKS = {1: Block(0.42, 0.07, 8.67), 2: Block(0.28, 0.07, 5.84), 3: Block(0.14, 0.07, 2.98)}
RELEASE_DEG = {1: 6.0, 2: 10.0, 3: 20.0}
FOUNDATIONS = {"marble": {"k": 6.88e6, "lambda": 1.30e8}, "aerstop": {"k": 2.86e6, "lambda": 8.16e7}}
SCENES = [(block, foundation) for block in BLOCKS for foundation in FOUNDATIONS]
SIGMA = math.radians(0.01)


def motion(model, number, parameters, theta0_deg=None, duration_s=8.0, rate_hz=2000.0):
    time = np.arange(round(duration_s * rate_hz)) / rate_hz
    theta0 = math.radians(RELEASE_DEG[number] if theta0_deg is None else theta0_deg)
    found = simulate(model, BLOCKS[number], parameters, time, theta0=theta0)
    assert found.outcome in ("completed", "at_rest")
    return time, found.theta, theta0


def noisy(theta, seed, sigma=SIGMA):
    return theta + sigma * np.random.default_rng(seed).standard_normal(theta.size)


@pytest.mark.parametrize(
    ("r", "times", "peaks_deg"),
    [
        (0.958, [0.26888, 0.71043, 1.09557, 1.44071, 1.75486], [8.4603, 7.3517, 6.4754, 5.7520]),
        (0.895, [0.26888, 0.62923, 0.91424, 1.15108], [6.8169, 5.0438, 3.8421, 2.9724]),
    ],
)
def test_housner_motion_to_the_digits_printed(r, times, peaks_deg):
    time, theta, theta0 = motion("housner", 2, {"r": r})
    found = find_impacts(time, theta, 0.0, BLOCKS[2], theta0=theta0)
    assert found.time_s[: len(times)] == pytest.approx(times, abs=6e-6)
    signs = np.resize([-1, 1], len(peaks_deg))
    assert np.degrees(found.peak_after_rad[: len(peaks_deg)]) == pytest.approx(signs * peaks_deg, abs=6e-5)
    assert found.peak_before_rad[0] == theta0
    assert found.peak_before_rad[1:] == pytest.approx(found.peak_after_rad[:-1], abs=0)
    assert found.restitution == pytest.approx(np.full(found.time_s.size, r), abs=1e-5)
    assert found.theta_uplift == 0


def test_no_bias_and_honest_errors_on_rigid_motion_down_to_ten_sigma():
    generator = np.random.default_rng(1)
    scores = {"restitution": [], "peak": [], "time": []}
    lowest = []
    for _ in range(120):
        block = BLOCKS[generator.integers(1, 4)]
        r, theta0 = generator.uniform(0.75, 0.96), block.theta_cr * generator.uniform(0.5, 0.8)
        time = generator.uniform(0, 5e-4) + np.arange(16000) / 2000
        theta = simulate_fitted("housner", block, {"r": r, "theta0": theta0}, time)
        theta += SIGMA * generator.standard_normal(theta.size)
        found = find_impacts(time, theta, SIGMA, block, theta0=theta0)
        swings = housner_swings(block, r, theta0, until=9.0)
        true = slice(0, found.time_s.size)
        after = swings.peak[1:][true]
        scores["time"].extend((found.time_s - swings.impact_time[true]) / found.time_stderr_s)
        scores["peak"].extend((np.abs(found.peak_after_rad) - after) / found.peak_after_stderr_rad)
        scores["restitution"].extend((found.restitution - r) / found.restitution_stderr)
        lowest.append(after[-1] / SIGMA)
    for name, score in scores.items():
        score = np.array(score)[np.isfinite(score)]
        assert score.size > 1500, name
        assert abs(score.mean()) < 0.1, name
        assert 0.93 < np.mean(np.abs(score) < 1.96) < 0.97, name
    assert np.median(lowest) < 13


@pytest.mark.parametrize(
    ("foundation", "peaks_deg", "low", "high"),
    [
        ("marble", [7.9027, 6.5832, 5.5949, 4.8059], 0.9385, 0.9435),
        ("aerstop", [5.547, 3.641, 2.479, 1.716], 0.83, 0.86),
    ],
)
def test_hunt_crossley_first_peaks_and_restitution(foundation, peaks_deg, low, high):
    time, theta, theta0 = motion("hunt_crossley", 2, FOUNDATIONS[foundation])
    found = find_impacts(time, theta, 0.0, BLOCKS[2], theta0=theta0)
    digits = 6e-5 if foundation == "marble" else 6e-4
    assert np.abs(np.degrees(found.peak_after_rad[:4])) == pytest.approx(peaks_deg, abs=digits)
    assert np.all((low < found.restitution[:7]) & (found.restitution[:7] < high))
    assert found.time_s[0] == pytest.approx({"marble": 0.3077, "aerstop": 0.3487}[foundation], abs=1e-4)


@pytest.mark.parametrize(("number", "foundation"), SCENES)
@pytest.mark.parametrize("sigma", [0.0, SIGMA / 2], ids=["clean", "noisy"])
def test_uplift_amplitude_from_the_tail(number, foundation, sigma):
    block = BLOCKS[number]
    time, theta, theta0 = motion("hunt_crossley", number, FOUNDATIONS[foundation], duration_s=12.0)
    found = find_impacts(time, noisy(theta, number, sigma), sigma, block, theta0=theta0)
    sink = block.mass_kg * GRAVITY / (2 * block.b * FOUNDATIONS[foundation]["k"])
    assert found.theta_uplift == pytest.approx(math.asin(sink / block.b), rel=0.05)
    assert np.all(np.abs(found.peak_after_rad) >= found.theta_uplift)


@pytest.mark.parametrize(("number", "foundation"), SCENES)
def test_errors_cover_the_scatter_on_compliant_bases(number, foundation):
    time, theta, theta0 = motion("hunt_crossley", number, FOUNDATIONS[foundation])
    clean = find_impacts(time, theta, 0.0, BLOCKS[number], theta0=theta0)
    peaks, restitutions = [], []
    for seed in range(6):
        found = find_impacts(time, noisy(theta, seed), SIGMA, BLOCKS[number], theta0=theta0)
        n = min(found.time_s.size, clean.time_s.size)
        peaks.extend((found.peak_after_rad - clean.peak_after_rad[:n])[:n] / found.peak_after_stderr_rad[:n])
        restitutions.extend((found.restitution - clean.restitution[:n])[:n] / found.restitution_stderr[:n])
    for scores in (peaks, restitutions):
        assert np.sqrt(np.mean(np.square(scores))) < 1.35
