"""Covariance of least-squares parameters."""

import numpy as np
import pytest
from scipy.signal import lfilter

from freerock.identification.covariance import covariance, noise_spectrum


def test_slow_noise_is_seen_in_its_spectrum():
    generator = np.random.default_rng(1)
    slow = lfilter([1.0], [1.0, -0.999], generator.standard_normal(16000)) * np.sqrt(1 - 0.999**2)
    noise = generator.standard_normal(16000) + slow + 0.5 * np.sin(0.157 * np.arange(16000))
    density = noise_spectrum(noise)
    frequency = np.array([1e-3, 1e-2, 0.1, 0.4])
    turn = 2 * np.pi * frequency
    exact = 1 + (1 - 0.999**2) / (1 - 2 * 0.999 * np.cos(turn) + 0.999**2)
    assert density(frequency) == pytest.approx(exact, rel=0.3)


def test_parameters_that_the_data_do_not_separate_have_no_standard_error():
    generator = np.random.default_rng(1)
    column, residual = generator.normal(size=(2, 500))
    both, _ = covariance(residual, np.column_stack([column, column]), (500,))
    assert np.all(np.isnan(both))
    one, coloured = covariance(residual, column[:, None], (500,))
    assert not coloured
    assert one[0, 0] == pytest.approx(1 / (column @ column), rel=0.2)
