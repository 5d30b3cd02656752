"""What find_impacts does with gaps, ends, signs and nonsense."""

import math
import warnings
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from freerock.config.processing import ImpactLimits
from freerock.models.block import Block
from freerock.models.housner import housner_motion, housner_swings
from freerock.runs.impacts import Impacts, find_impacts

BLOCK = Block(0.28, 0.07, 5.84)
THETA0, R = math.radians(10), 0.9
SWINGS = housner_swings(BLOCK, R, THETA0, until=5.0)
TIME = np.arange(8000) / 2000
THETA = housner_motion(SWINGS, TIME, THETA0, rates=False)[0]
SIGMA = math.radians(0.01)
NOISY = THETA + SIGMA * np.random.default_rng(3).standard_normal(THETA.size)


def impacts(time=TIME, theta=NOISY, sigma=SIGMA, **options):
    return find_impacts(time, theta, sigma, BLOCK, **{"theta0": THETA0} | options)


def values(found):
    return {field.name: getattr(found, field.name) for field in fields(Impacts)}


def test_one_value_per_impact():
    found = impacts()
    lengths = {np.shape(value) for name, value in values(found).items() if name != "theta_uplift"}
    assert len(lengths) == 1 and found.time_s.size > 10
    assert isinstance(found.theta_uplift, float)


def test_error_of_the_release_angle_is_propagated_to_the_first_impact_only():
    sharp, blurred = impacts(), impacts(theta0_stderr=math.radians(0.1))
    assert blurred.peak_before_stderr_rad[0] == math.radians(0.1)
    assert blurred.restitution_stderr[0] > 5 * sharp.restitution_stderr[0]
    assert np.array_equal(blurred.restitution_stderr[1:], sharp.restitution_stderr[1:])


def test_invalid_samples_are_left_out():
    theta = NOISY.copy()
    theta[np.random.default_rng(1).random(theta.size) < 0.2] = np.nan
    whole, holed = impacts(), impacts(theta=theta)
    n = min(whole.time_s.size, holed.time_s.size)
    assert n > 10
    difference = (holed.restitution[:n] - whole.restitution[:n]) / holed.restitution_stderr[:n]
    assert np.abs(difference).max() < 4


def test_a_swing_cut_off_by_the_end_is_not_used():
    for end in (SWINGS.peak_time[4] - 0.05, SWINGS.peak_time[4] + 0.05):
        found = impacts(TIME[end > TIME], NOISY[end > TIME])
        assert found.time_s.size == 3


def test_thresholds_end_the_list():
    assert impacts(limits=ImpactLimits(min_amplitude_sigmas=100.0)).time_s.size < impacts().time_s.size
    assert np.abs(impacts(limits=ImpactLimits(min_amplitude_sigmas=100.0)).peak_after_rad).min() > 100 * SIGMA
    long = impacts(limits=ImpactLimits(min_samples=200)).time_s.size
    assert 0 < long < impacts().time_s.size


@pytest.mark.parametrize(
    "theta",
    [
        np.zeros(2000),
        np.full(2000, np.nan),
        np.full(2000, 0.1),
        SIGMA * np.random.default_rng(0).normal(size=2000),
    ],
    ids=["rest", "nothing valid", "held", "noise"],
)
def test_no_impact(theta):
    assert impacts(TIME[:2000], theta).time_s.size == 0


@settings(deadline=None, derandomize=True, max_examples=25)
@given(
    steps=arrays(float, st.integers(2, 400), elements=st.floats(-1, 1)),
    smoothing=st.integers(1, 60),
    scale=st.floats(1e-6, 1.9),
    sigma=st.sampled_from([0.0, 1e-4, 1e-2]),
    theta0=st.none() | st.floats(-2, 2),
    holes=st.integers(1, 9),
)
def test_any_signal_is_answered(steps, smoothing, scale, sigma, theta0, holes):
    theta = scale * np.convolve(np.repeat(steps, 10), np.ones(smoothing) / smoothing, "same")
    theta[:: 10 * holes] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of this call, not of what an earlier test left to be collected
        found = impacts(np.arange(theta.size) / 500, theta, sigma, theta0=theta0)
    assert np.isfinite(found.time_s).all()
    assert not (found.restitution < 0).any()
