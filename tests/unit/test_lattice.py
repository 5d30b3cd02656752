"""The step of a converter, and the scatter of the noise that it rounds."""

import math

import numpy as np
import pytest

from freerock.noise.signal_noise import lattice_step, scatter

RESTS, SAMPLES = 4, 2000


def rounded(step, seed, hum=0.0):
    """Rests at levels anywhere between two values, of noise of variance 1; a hum is removed."""
    generator = np.random.default_rng([seed, round(10 * step)])
    levels = generator.uniform(0, step or 1.0, (RESTS, 1))
    tone = hum * np.sin(0.157 * np.arange(SAMPLES))
    x = levels + generator.standard_normal((RESTS, SAMPLES)) + tone
    return (np.rint(x / step) * step if step else x) - tone


@pytest.mark.slow
@pytest.mark.parametrize("hum", [0.0, 1.5])
@pytest.mark.parametrize("step", [0.0, 0.02, 0.1, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0])
def test_scatter_of_noise_and_rounding(step, hum):
    """Within 3 % as a rule, from 0 to 10 sigma a step; worst where hardly a sample toggles."""
    found = np.array([scatter(list(rounded(step, seed, hum)), step) for seed in range(20)])
    off = found / math.hypot(1.0, step / math.sqrt(12)) - 1
    assert abs(np.median(off)) < 0.03 and np.abs(off).max() < (0.05 if step < 4 else 0.16)


def test_scatter_is_robust():
    x = rounded(0.5, 1)
    x[:, ::100] += 40.0
    assert scatter(list(x), 0.5) == pytest.approx(math.hypot(1.0, 0.5 / math.sqrt(12)), rel=0.06)


def test_scatter_where_one_value_is_all_that_is_seen():
    assert 1 / math.sqrt(12) < scatter(np.zeros(1000), 1.0) < 0.35
    assert scatter(np.zeros(1000)) == 0 and math.isnan(scatter(np.full(3, np.nan)))


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
def test_the_step_is_found_in_rests_and_motion(bits):
    step, time = 21 / 2**bits, np.linspace(0, 20, 20_000)
    volts = (
        5 + np.where(time > 10, np.sin(9 * time), 0) + 2e-3 * np.random.default_rng(1).standard_normal(20_000)
    )
    assert lattice_step(np.rint(volts / step) * step) == pytest.approx(step, rel=1e-6)
    assert lattice_step(volts) == 0
