import numpy as np
import pytest

from freerock.runs.angular_rate import angular_rate


def test_rate_of_a_swing():
    time = np.arange(800) / 400
    rate = angular_rate(time, 0.1 * np.sin(6 * time))
    np.testing.assert_allclose(rate[10:-10], 0.6 * np.cos(6 * time)[10:-10], atol=2e-3)


def test_rate_beside_a_missing_sample_is_not_known():
    time = np.arange(100) / 400
    theta = 0.3 * time
    theta[50] = np.nan
    rate = angular_rate(time, theta)
    assert np.isnan(rate[46:55]).all()
    assert rate[10] == pytest.approx(0.3)


def test_a_motion_shorter_than_the_window_has_no_rate():
    assert np.isnan(angular_rate(np.arange(4) / 400, np.zeros(4))).all()
    assert np.isnan(angular_rate(np.zeros(1), np.zeros(1))).all()
