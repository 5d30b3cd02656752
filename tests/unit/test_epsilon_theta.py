import numpy as np
import pytest

from freerock.identification.epsilon_theta import epsilon_theta


def test_epsilon_theta_of_a_scaled_motion_is_the_squared_relative_difference():
    time = np.linspace(0, 2, 2001)
    theta = 0.1 * np.cos(5 * time)
    assert epsilon_theta(time, 1.1 * theta, theta) == pytest.approx(0.01, rel=1e-12)


def test_epsilon_theta_integrates_over_uneven_time():
    time = np.sort(np.random.default_rng(1).uniform(0, 1, 4000))
    time[[0, -1]] = 0, 1
    theta = np.sin(2 * np.pi * time)
    # ∫ t² dt / ∫ sin² dt = (1/3) / (1/2)
    assert epsilon_theta(time, theta + time, theta) == pytest.approx(2 / 3, rel=1e-3)


def test_epsilon_theta_leaves_flagged_samples_out():
    time = np.linspace(0, 1, 101)
    theta = np.ones(101)
    model = np.full(101, 1.1)
    model[20:30] = np.nan
    assert epsilon_theta(time, model, theta) == pytest.approx(0.01)


def test_epsilon_theta_of_several_runs_adds_their_integrals():
    time = np.linspace(0, 1, 101)
    ones = np.ones(101)
    both = epsilon_theta(
        np.tile(time, 2), np.concatenate([1.1 * ones, 3.3 * ones]), np.repeat([1.0, 3.0], 101)
    )
    assert both == pytest.approx((0.01 + 0.09) / (1 + 9))


@pytest.mark.parametrize("theta", [np.zeros(5), np.full(5, np.nan)])
def test_epsilon_theta_of_no_motion_is_undefined(theta):
    assert np.isnan(epsilon_theta(np.arange(5.0), np.ones(5), theta))
