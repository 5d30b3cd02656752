"""A line in a rest that nothing came before: found, and none where there is noise alone."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from freerock.noise.interference import slow_line

RATE = 1000.0


def correlated(draw, n, time_s):
    """Noise of variance 1 that is correlated over a time."""
    a = math.exp(-1 / (RATE * time_s))
    drive = math.sqrt(1 - a * a) * draw.standard_normal(n)
    return lfilter([1.0], [1.0, -a], drive, zi=[a * draw.standard_normal()])[0]


NOISES = {
    "white": lambda draw, n: draw.standard_normal(n),
    "2 ms": lambda draw, n: correlated(draw, n, 2e-3),
    "20 ms": lambda draw, n: correlated(draw, n, 0.02),
    "200 ms": lambda draw, n: correlated(draw, n, 0.2),
    "white and slow": lambda draw, n: draw.standard_normal(n) + 0.25 * correlated(draw, n, 0.05),
    "drift": lambda draw, n: draw.standard_normal(n) + np.linspace(0, 20 * draw.uniform(-1, 1), n),
    "walk": lambda draw, n: draw.standard_normal(n) + 0.02 * np.cumsum(draw.standard_normal(n)),
    "hum": lambda draw, n: draw.standard_normal(n) + np.sin(2 * np.pi * 50 * np.arange(n) / RATE),
    "steps": lambda draw, n: np.round(0.3 * draw.standard_normal(n) + draw.uniform()),
    "constant": lambda draw, n: np.full(n, 5.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", NOISES)
@pytest.mark.parametrize("rest_s", [0.5, 1.3, 2.5, 12.0])
def test_no_line_in_noise(kind, rest_s):
    for seed in range(10):
        rest = NOISES[kind](np.random.default_rng(seed), round(rest_s * RATE))
        assert slow_line(rest, 1 / RATE) is None


@pytest.mark.parametrize(
    ("rest_s", "frequency_hz", "sigmas"), [(1.3, 12.0, 0.8), (3.0, 6.0, 0.5), (20.0, 2.5, 0.3)]
)
def test_frequency_and_amplitude_of_a_line(rest_s, frequency_hz, sigmas):
    time, amplitudes = np.arange(0, rest_s, 1 / RATE), []
    for seed in range(20):
        draw = np.random.default_rng(seed)
        line = sigmas * np.sin(2 * np.pi * frequency_hz * time + draw.uniform(0, 2 * np.pi))
        found = slow_line(5 + line + draw.standard_normal(time.size), 1 / RATE)
        assert found and found[0] == pytest.approx(frequency_hz, abs=1.5 / min(rest_s, 10.0))
        amplitudes.append(found[1])
    assert np.mean(amplitudes) == pytest.approx(sigmas, rel=0.1)
