"""Covariance of least-squares parameters."""

import math

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from freerock.identification.against_noise import against_rest, noise_of_residual
from freerock.identification.intervals import covariance
from freerock.noise.at_rest import noise_at_rest
from freerock.noise.spectrum import white_noise

RATE_HZ = 400.0  # at which nothing is averaged
N = 1600
SIGMA = 1e-4


def columns(n=N):
    """Derivatives as of a block that swings ever lower."""
    time_s = np.arange(n) / RATE_HZ
    fading = np.exp(-time_s)
    return np.column_stack([fading * np.cos(12 * time_s), time_s * fading * np.sin(12 * time_s)])


def slow_noise(n, generator, time_s=0.05):
    a = math.exp(-1 / (RATE_HZ * time_s))
    drive = math.sqrt(1 - a * a) * generator.standard_normal(n)
    return lfilter([1.0], [1.0, -a], drive, zi=[a * generator.standard_normal()])[0]


def of_noise(residual, jacobian, noise, *, is_noise=True):
    theta = np.zeros(len(residual))
    return covariance(residual, jacobian, (len(residual),), (noise,), theta, is_noise=is_noise)


@pytest.mark.parametrize("corner", [1e-3, 1e-2])
def test_it_is_that_of_a_dense_covariance(corner):
    """Of noise that is known, by matrices."""
    known = white_noise(SIGMA, RATE_HZ)
    noise = type(known)(**{**vars(known), "slow": 30 * SIGMA**2, "corner": corner})
    fine = np.arange(40_000) / 40_000
    dense = toeplitz(np.fft.ifft(noise.density(np.minimum(fine, 1 - fine))).real[:N])
    jacobian = columns()
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    exact = inverse @ jacobian.T @ dense @ jacobian @ inverse
    found = of_noise(SIGMA * np.random.default_rng(1).standard_normal(N), jacobian, noise)
    assert found.covariance == pytest.approx(exact, rel=0.02)


def test_parameters_that_the_data_do_not_separate_have_no_standard_error():
    generator = np.random.default_rng(1)
    column, residual = generator.normal(size=(2, N))
    noise = white_noise(1.0, RATE_HZ)
    assert np.all(np.isnan(of_noise(residual, np.column_stack([column, column]), noise).covariance))
    one = of_noise(residual, column[:, None], noise)
    assert not one.coloured
    assert one.covariance[0, 0] == pytest.approx(1 / (column @ column), rel=0.05)


def scores(draw, seeds, *, rests=True):
    """Errors of two fitted numbers over their standard errors, and the degrees of freedom of these."""
    jacobian, found, dofs = columns(), [], []
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    for seed in range(seeds):
        noise = SIGMA * draw(np.random.default_rng(seed))
        rest, error = noise[: len(noise) - N], noise[-N:]
        residual = error - jacobian @ (inverse @ jacobian.T @ error)
        if rests:
            at_rest = against_rest(residual, jacobian, [N], [noise_at_rest([rest], RATE_HZ)])
            known = of_noise(residual, jacobian, at_rest.noises[0])
        else:
            (alone,) = noise_of_residual(residual, jacobian, [N], [RATE_HZ])
            known = of_noise(residual, jacobian, alone, is_noise=False)
        found.append(inverse @ jacobian.T @ error / np.sqrt(np.diag(known.covariance)))
        dofs.append(known.dof)
    return np.array(found), np.array(dofs)


KINDS = {
    "white": lambda g: g.standard_normal(N + 1000),
    "50 ms": lambda g: slow_noise(N + 1000, g),
    "white and slow": lambda g: g.standard_normal(N + 1000) + 0.5 * slow_noise(N + 1000, g),
    "hum": lambda g: g.standard_normal(N + 1000) + 2 * np.sin(0.785 * np.arange(N + 1000) + g.uniform(0, 6)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_errors_scatter_as_stated_where_a_rest_shows_the_noise(kind):
    """Root mean square of 2 × 150 scores: 1 within three of its own standard errors."""
    found, dofs = scores(KINDS[kind], 150)
    assert np.sqrt(np.mean(found**2)) == pytest.approx(1.0, abs=0.17)
    assert np.median(dofs) > 10


def test_where_no_rest_shows_it_slow_noise_is_seen_in_the_residual():
    """Not in full: what the fit takes of it does not show."""
    white, _ = scores(KINDS["white"], 100, rests=False)
    slow, _ = scores(KINDS["white and slow"], 100, rests=False)
    assert 0.75 < np.sqrt(np.mean(white**2)) < 1.15
    assert np.sqrt(np.mean(slow**2)) < 1.5


def test_a_residual_that_is_not_noise_is_not_known_better_than_it_scatters():
    wave = 20 * SIGMA * np.sin(2 * np.pi * np.arange(N) / RATE_HZ)
    quiet = white_noise(SIGMA, RATE_HZ)
    as_noise = of_noise(wave, columns(), quiet)
    doubted = of_noise(wave, columns(), quiet, is_noise=False)
    assert doubted.coloured
    assert np.all(np.diag(doubted.covariance) > 100 * np.diag(as_noise.covariance))


@pytest.mark.parametrize("step, least", [(3.0, 0.0), (8.0, 1.3)])
def test_a_converter_that_the_block_goes_through_slowly(step, least):
    """The same motion with white noise through the steps, from anywhere between two."""
    time_s = np.arange(N) / RATE_HZ
    theta = 40 * SIGMA * np.exp(-time_s) * np.cos(3 * time_s)
    jacobian = np.column_stack([np.exp(-time_s) * np.cos(3 * time_s), np.exp(-time_s) * np.sin(3 * time_s)])
    influence = jacobian @ np.linalg.inv(jacobian.T @ jacobian)
    noise = noise_at_rest([np.zeros(1000)], RATE_HZ, step * SIGMA)
    found, white = [], []
    for seed in range(150):
        generator = np.random.default_rng(seed)
        offset = generator.uniform()
        before = theta + SIGMA * generator.standard_normal(N)
        error = step * SIGMA * (np.round(before / (step * SIGMA) + offset) - offset) - theta
        residual = error - jacobian @ (influence.T @ error)
        at_rest = against_rest(residual, jacobian, [N], [noise])
        known = covariance(residual, jacobian, (N,), at_rest.noises, theta, is_noise=True)
        found.append(influence.T @ error / np.sqrt(np.diag(known.covariance)))
        white.append(influence.T @ error / np.sqrt(np.diag(influence.T @ influence) * np.mean(residual**2)))
    assert 0.75 < np.sqrt(np.mean(np.square(found))) < 1.15
    assert np.sqrt(np.mean(np.square(white))) > least  # what white noise of as much power would claim


def test_noise_that_is_louder_where_a_number_counts_widens_its_error():
    """Speckle grows with the rotation: the error stated is that of many draws, for each number."""
    generator = np.random.default_rng(3)
    time_s = np.arange(N) / RATE_HZ
    fading = np.exp(-time_s)
    jacobian = np.column_stack([fading**2, np.ones(N)])
    loud = SIGMA * (0.3 + 3 * fading)
    draws = loud[:, None] * generator.standard_normal((N, 2000))
    scatter = np.std(np.linalg.lstsq(jacobian, draws, rcond=None)[0], axis=1)
    noise = white_noise(float(np.sqrt(np.mean(loud**2))), RATE_HZ)
    stated = np.median(
        [np.sqrt(np.diag(of_noise(each, jacobian, noise).covariance)) for each in draws.T[:50]], axis=0
    )
    assert stated[0] == pytest.approx(scatter[0], rel=0.05)
    assert stated[1] >= 0.95 * scatter[1]
