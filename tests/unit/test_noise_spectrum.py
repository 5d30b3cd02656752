"""Noise at rest: its spectrum, residuals against it, likelihood under it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from freerock.identification.against_noise import against_rest, octave_limits
from freerock.identification.likelihood import Whitened
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from freerock.identification.significance_levels import RESIDUAL
from freerock.noise.at_rest import noise_at_rest, quiet_stretches
from freerock.noise.spectrum import (
    averaged,
    expected_power,
    frequencies,
    slow_and_white,
    tapered_power,
    white_noise,
)

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
    return against_rest(residual + added, jacobian, [len(residual)], [at_rest])


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
        assert not found.is_noise
        assert found.low_hz <= 2.3 <= found.high_hz
        assert found.ratio > 3


@pytest.mark.parametrize("band", [0, 4, -1])
def test_a_residual_is_rejected_where_an_octave_is_louder_than_its_limit(band):
    """Noise of which a fit has taken nothing, with one octave scaled to either side of the limit."""
    stretches, residual, _, _ = run("white", 1)
    at_rest, n = noise_at_rest(stretches, RATE_HZ), len(residual)
    means = averaged(residual, at_rest.averaged)
    at = frequencies(len(means))
    mine = at_rest.band(at) == np.unique(at_rest.band(at))[band]
    own = (tapered_power(means - means.mean()) / expected_power(at_rest, len(means)))[mine].mean()
    low, high = at[mine][0] - 0.5 / len(means), at[mine][-1] + 0.5 / len(means)
    lines = np.fft.rfft(residual - residual.mean())
    inside = np.arange(len(lines)) / n * at_rest.averaged
    inside = (inside >= low) & (inside <= high)
    limit = octave_limits(at_rest, len(means))[at_rest.band(at)][mine][0]
    for by, agrees in ((0.8, True), (1.25, False)):
        louder = np.fft.irfft(np.where(inside, math.sqrt(by * limit / own), 1.0) * lines, n)
        assert against_rest(louder, np.zeros((n, 1)), [n], [at_rest]).is_noise is agrees


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


def test_without_a_rest_the_likelihood_is_that_of_least_squares():
    residual, column = np.random.default_rng(1).standard_normal((2, 1000))
    found = Whitened(residual, column[:, None], [1000], [None]).likelihood()
    left = residual - column * (column @ residual) / (column @ column)
    assert found.minus_two_log == pytest.approx(1000 * np.log(left @ left / 1000))
    assert found.effective == 1000
    (aic, bic), (aic_more, bic_more) = found.criteria(2), found.criteria(3)
    assert (aic_more - aic, bic_more - bic) == (pytest.approx(2), pytest.approx(np.log(1000)))


@pytest.mark.parametrize("slow, white, m", [(0.0, 1.0, 1), (3.0, 1.0, 1), (300.0, 1.0, 4), (300.0, 0.0, 4)])
def test_the_likelihood_is_that_of_a_dense_covariance(slow, white, m):
    """Of noise that is known, with the weighted least squares of one parameter."""
    n, generator = 301, np.random.default_rng(3)
    known = white_noise(math.sqrt(white), 400.0 * m)
    assert known.averaged == m
    known = type(known)(**{**vars(known), "slow": slow, "corner": 0.01})
    fine = np.arange(20_000) / 20_000
    covariance = toeplitz(np.fft.ifft(slow_and_white(fine, white, slow, 0.01, m)).real[:n])
    root, column = np.linalg.cholesky(covariance), np.linspace(1, -1, n)
    inverse = np.linalg.inv(covariance)
    values, exact = [], []
    for _ in range(2):
        residual = root @ generator.standard_normal(n)
        measured, trace = (
            np.repeat(each, m) / math.sqrt(m) for each in (residual, column)
        )  # before averaging
        values.append(Whitened(measured, trace[:, None], [n * m], [known]).likelihood().minus_two_log)
        best = (column @ inverse @ residual) / (column @ inverse @ column)
        left = residual - best * column
        exact.append(left @ inverse @ left)
    assert values[1] - values[0] == pytest.approx(exact[1] - exact[0], abs=0.05)
    with_none = Whitened(measured, np.zeros((n * m, 1)), [n * m], [known]).likelihood().minus_two_log
    assert with_none - values[1] == pytest.approx(residual @ inverse @ residual - exact[1], abs=0.05)


@pytest.mark.parametrize("kind", KINDS)
def test_a_needless_parameter_gains_as_chance_has_it(kind):
    """Twice the logarithm of the ratio of likelihoods follows χ² with one degree of freedom."""
    gains = []
    for seed in range(36):
        stretches, residual, jacobian, step = run(kind, seed)
        at_rest = [noise_at_rest(stretches, RATE_HZ, step)]
        extra = np.cos(8 * np.arange(8000) / RATE_HZ) * np.linspace(1, 0, 8000)
        both = np.column_stack([jacobian, extra])
        small, large = (Whitened(residual, own, [8000], at_rest).likelihood() for own in (jacobian, both))
        gains.append(small.minus_two_log - large.minus_two_log)
    assert np.mean(gains) < 2.5  # 1 ± 0.24
    assert max(gains) < 12


def test_a_block_that_swings_on_below_the_noise_is_not_at_rest():
    generator, n = np.random.default_rng(4), round(14 * RATE_HZ)
    time_s = np.arange(n) / RATE_HZ
    since = np.maximum(time_s - 4, 0)
    theta = np.where((time_s > 2) & (time_s < 4), 0.1, 0.0)
    theta += np.where(time_s >= 4, 0.1 * np.exp(-1.5 * since) * np.cos(12 * since), 0.0)
    theta += SIGMA * generator.standard_normal(n)
    theta[2000:2010] = np.nan
    found = [*quiet_stretches(time_s, theta, np.full(n, SIGMA))]
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
    found = [*quiet_stretches(time_s, theta + sigma * generator.standard_normal(n), sigma)]
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
