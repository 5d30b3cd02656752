"""A channel coupled for AC."""

import numpy as np
import pytest

from freerock.rotation.ac_coupling import ac_cutoff


def test_ac_coupling_is_seen_in_a_held_angle():
    t = 1e-3 * np.arange(12_000)
    held = 5.0 + np.where((t > 3) & (t < 5), 1.0, 0.0) * np.cos(np.maximum(t - 5, 0))
    noisy = held + 0.002 * np.random.default_rng(1).standard_normal(t.size)
    assert ac_cutoff(1e-3, noisy) is None
    rate = 2 * np.pi * 0.1
    coupled = np.zeros(t.size)
    for i in range(1, t.size):
        coupled[i] = (coupled[i - 1] + noisy[i] - noisy[i - 1]) / (1 + rate * 1e-3)
    assert ac_cutoff(1e-3, coupled) == pytest.approx(0.1, rel=0.05)
