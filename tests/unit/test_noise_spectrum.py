"""Noise at rest: its spectrum, residuals against it, likelihood under it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from freerock.identification.goodness import goodness, minus_two_log
from freerock.identification.significance_levels import RESIDUAL
from freerock.noise.rotation_noise import noise_at_rest, quiet_stretches
from freerock.noise.spectrum import (
    averaged,
    slow_and_white,
    white_noise,
)
from freerock.noise.still_phases import stationary_phases

RATE_HZ = 2000.0
SIGMA = 1e-4


def correlated(n, time_s, generator):
    a = math.exp(-1 / (RATE_HZ * time_s))
    drive = math.sqrt(1 - a * a) * generator.standard_normal(n)
    return lfilter([1.0], [1.0, -a], drive, zi=[a * generator.standard_normal()])[0]


def noise(kind, n, generator):
    """Noise as the sensors of the studies have it, standard deviation about 1."""
    white, hum = generator.standard_normal(n), np.sin(2 * np.pi * 50 * np.arange(n) / RATE_HZ)
    return {
        "white": white,
        "correlated 2 ms": correlated(n, 2e-3, generator),
        "correlated 20 ms": correlated(n, 20e-3, generator),
        "correlated 200 ms": correlated(n, 0.2, generator),
        "hum": white + hum,
        "weak slow": white + 0.25 * correlated(n, 50e-3, generator),
        "converter 2": white,
        "converter 5": white,
    }[kind]


KINDS = [
    "white",
    "correlated 2 ms",
    "correlated 20 ms",
    "correlated 200 ms",
    "hum",
    "weak slow",
    "converter 2",
    "converter 5",
]


def run(kind, seed):
    """Two rests, the residual of a swinging block less what five parameters take, their derivatives, step."""
    generator = np.random.default_rng([seed, KINDS.index(kind)])
    hold, n, rest = (round(RATE_HZ * s) for s in (generator.uniform(1, 3), 4.0, generator.uniform(1, 5)))
    time_s = np.arange(n) / RATE_HZ
    swing = 1500 * np.exp(-time_s / 1.5) * np.cos(8 * time_s)
    theta = np.concatenate([np.full(hold, 1500.0), swing, np.zeros(rest)])
    measured, step = theta + noise(kind, len(theta), generator), 0.0
    if kind.startswith("converter"):
        step, offset = float(kind[-1]), generator.uniform()
        measured = step * (np.round(measured / step + offset) - offset)
    jacobian = np.column_stack(
        [swing, swing * time_s, np.gradient(swing), time_s * np.gradient(swing), np.sin(8 * time_s)]
    )
    error = measured - theta
    residual = error[hold : hold + n]
    residual = residual - jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
    stretches = SIGMA * error[:hold], SIGMA * error[hold + n :]
    return stretches, SIGMA * residual, jacobian, SIGMA * step


def judged(kind, seed, added=0.0):
    stretches, residual, jacobian, step = run(kind, seed)
    at_rest = noise_at_rest(stretches, RATE_HZ, step)
    means, columns = (averaged(each, at_rest.averaged) for each in (residual + added, jacobian))
    return goodness(means, columns, at_rest)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_noise_as_at_rest_passes(kind):
    """docs/validation.md has the same over thousands of cases."""
    assert min(judged(kind, seed).p for seed in range(12)) > RESIDUAL


@pytest.mark.parametrize("kind, amplitude", [("white", 0.5), ("correlated 2 ms", 2.0), ("converter 5", 4.0)])
def test_a_swing_that_is_left_does_not_pass(kind, amplitude):
    time_s = np.arange(8000) / RATE_HZ
    wave = amplitude * SIGMA * np.sin(2 * np.pi * 2.3 * time_s)
    for seed in range(6):
        found = judged(kind, seed, wave)
        assert not found.agrees
        assert found.low_hz <= 2.3 <= found.high_hz
        assert found.over_noise > 1.1


def test_the_spectrum_of_a_rest():
    generator = np.random.default_rng(2)
    stretches = [SIGMA * noise("correlated 20 ms", 8000, generator) for _ in range(20)]
    measured, frequency = noise_at_rest(stretches, RATE_HZ), np.geomspace(2e-3, 0.2, 30)
    m, a = measured.averaged, math.exp(-1 / (RATE_HZ * 20e-3))
    within = np.arange(m)[:, None] - np.arange(m)
    lags = np.arange(1, 400)
    covariance = [np.mean(a ** np.abs(m * lag + within)) * m for lag in (0, *lags)]
    exact = covariance[0] + 2 * np.cos(2 * np.pi * np.outer(frequency, lags)) @ covariance[1:]
    assert measured.rate_hz == 500 == RATE_HZ / m
    assert measured.density(frequency) == pytest.approx(SIGMA**2 * exact, rel=0.25)
    louder = measured.scaled(2.0)
    assert louder.density(frequency) == pytest.approx(4 * measured.density(frequency))


@pytest.mark.parametrize("m", [1, 2, 4, 16])
@pytest.mark.parametrize("time_s", [0.02, 0.2])
def test_the_law_is_that_of_means_of_slow_noise(m, time_s):
    """Means of m samples, times √m, of noise whose neighbours correlate; all their covariances summed."""
    lags = np.arange(200_000 * m) / RATE_HZ
    raw = np.exp(-lags / time_s)
    kernel = np.convolve(np.ones(m), np.ones(m)) / m
    both = np.concatenate([raw[m - 1 : 0 : -1], raw])
    of_means = np.convolve(both, kernel, "valid")[::m][: 8 * round(40 * time_s * RATE_HZ / m)]
    where = np.array([0, 1e-3, 0.01, 0.1, 0.3, 0.5])
    cosines = np.cos(2 * np.pi * np.outer(where, np.arange(len(of_means))))
    exact = cosines @ np.append(of_means[0], 2 * of_means[1:])
    corner = m / (2 * np.pi * time_s * RATE_HZ)
    assert slow_and_white(where, 0.0, exact[0], corner, m) / exact == pytest.approx(1, rel=0.05)


@pytest.mark.parametrize(
    "kind, time_s", [("correlated 2 ms", 2e-3), ("correlated 20 ms", 0.02), ("weak slow", 0.05)]
)
def test_the_corner_of_slow_noise_is_found(kind, time_s):
    """A fit that stops early, or that takes means for samples, gives two thirds of it."""
    rests = [noise(kind, 5000, np.random.default_rng([5, i])) for i in range(15)]
    corners = [found.corner * found.rate_hz for found in (noise_at_rest([each], RATE_HZ) for each in rests)]
    assert np.median(corners) == pytest.approx(1 / (2 * np.pi * time_s), rel=0.12)


def test_the_likelihood_of_a_residual_is_that_of_students_t_in_each_octave():
    """Of white noise whose level a rest of few samples tells, but for a constant."""
    n, generator = 512, np.random.default_rng(3)
    known = replace(white_noise(1.0, 400.0), dof=np.full_like(white_noise(1.0, 400.0).dof, 20.0))
    residuals = [scale * generator.standard_normal(n) for scale in (0.8, 1.0, 1.3)]
    found = [minus_two_log(each, known) for each in residuals]
    exact = []
    for each in residuals:
        power, at = np.abs(np.fft.rfft(each, norm="ortho")) ** 2, np.fft.rfftfreq(n)
        twice = np.where((at == 0) | (at == 0.5), 1.0, 2.0)
        of = [known.band(at) == band for band in np.unique(known.band(at))]
        exact.append(sum((twice[own].sum() + 20) * np.log(1 + (twice * power)[own].sum() / 20) for own in of))
    assert np.diff(found) == pytest.approx(np.diff(exact), rel=1e-6)


def test_a_block_that_swings_on_below_the_noise_is_not_at_rest():
    generator, n = np.random.default_rng(4), round(14 * RATE_HZ)
    time_s = np.arange(n) / RATE_HZ
    since = np.maximum(time_s - 4, 0)
    theta = np.where((time_s > 2) & (time_s < 4), 0.1, 0.0)
    theta += np.where(time_s >= 4, 0.1 * np.exp(-1.5 * since) * np.cos(12 * since), 0.0)
    theta += SIGMA * generator.standard_normal(n)
    theta[2000:2010] = np.nan
    found = [*quiet_stretches(time_s, theta, np.full(n, SIGMA), stationary_phases(time_s, theta))]
    assert len(found) == 4  # a rest in two pieces, the hold, the rest after the motion
    for each in found:
        assert each.std() == pytest.approx(SIGMA, rel=0.05)
    assert 1.5 * RATE_HZ < len(found[-1]) < 6 * RATE_HZ
    assert noise_at_rest(found, RATE_HZ).density(np.array([2e-3])) < 3 * SIGMA**2


def test_noise_is_as_loud_as_the_beam_makes_it():
    """The same displacement is another angle where the block is tilted."""
    generator, n = np.random.default_rng(5), round(10 * RATE_HZ)
    time_s = np.arange(n) / RATE_HZ
    since = np.maximum(time_s - 4, 0)
    theta = np.where(time_s < 4, 0.1, 0.1 * np.exp(-4 * since) * np.cos(12 * since))
    sigma = SIGMA * (1 + 5 * np.abs(theta))
    seen = theta + sigma * generator.standard_normal(n)
    found = [*quiet_stretches(time_s, seen, sigma, stationary_phases(time_s, seen))]
    usual = float(np.median(sigma))
    assert [each.std() for each in found] == pytest.approx([usual] * len(found), rel=0.05)


@pytest.mark.parametrize("coarse", [1.0, 3.0, 5.0, 10.0])
def test_a_block_that_stands_between_two_steps_is_off_by_no_more_than_is_stated(coarse):
    """The mean of many samples against the level, over all places between two steps of a converter."""
    generator = np.random.default_rng(5)
    place = coarse * np.linspace(-0.5, 0.5, 41)
    samples = place[:, None] + generator.standard_normal((41, 4000))
    off = (coarse * np.rint(samples / coarse)).mean(axis=1) - place
    sigma = math.hypot(1.0, coarse / math.sqrt(12))
    stated = replace(white_noise(1.0, 1e3), step=coarse / sigma).stuck * sigma**2
    seen = float(np.mean(off**2))
    assert seen < 1.05 * stated + 2 / 4000
    assert stated < max(2.5 * seen, 0.03)
