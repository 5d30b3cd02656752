"""The noise of a record, found once and read again."""

import numpy as np

from freerock.noise.sensor_noise import at_rest
from freerock.noise.spectrum import noise_told


def test_the_noise_of_a_record_is_read_again_to_the_last_digit():
    time_s = np.arange(0, 4, 1e-3)
    theta = 1e-5 * np.random.default_rng(1).standard_normal(time_s.size)
    sigma = np.full(time_s.size, 1e-5)
    found = at_rest(time_s, theta, sigma, 2e-6)
    again = noise_told(found.noise.told)
    for name, value in vars(found.noise).items():
        np.testing.assert_array_equal(getattr(again, name), value)
    assert [each.kind for each in found.phases] == ["rest"]
