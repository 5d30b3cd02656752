import math

import numpy as np
import pytest
from scipy.stats import t

from freerock.populations.random_effects import common_spread, likely_spreads, population


def test_runs_that_scatter_far_beyond_their_noise_give_the_intervals_of_a_sample():
    values, n = np.array([1.0, 1.3, 0.8, 1.1]), 4
    found = population(values, np.full(n, 1e-4))
    s, quantile = values.std(ddof=1), t.ppf(0.975, n - 1)
    assert found.mean == pytest.approx(values.mean())
    assert (found.high - found.low) / 2 == pytest.approx(quantile * s / math.sqrt(n), rel=0.02)
    assert found.stderr == pytest.approx((found.high - found.low) / 2 / 1.96, rel=1e-3)
    assert found.tau == pytest.approx(s, rel=1e-3)
    following = quantile * s * math.sqrt(1 + 1 / n)
    assert (found.next_high - found.next_low) / 2 == pytest.approx(following, rel=0.02)
    assert found.tau_low < found.tau < found.tau_high
    assert found.p < 1e-6


def test_runs_that_agree_by_chance_are_known_no_better_than_their_noise_allows():
    found = population([1.0, 1.001, 0.999], [0.01, 0.01, 0.01])
    assert (found.tau, found.tau_low) == (0.0, 0.0)
    assert found.p > 0.9
    assert 0.01 / math.sqrt(3) < found.u < 2 * 0.01 / math.sqrt(3)
    assert 1.96 * 0.01 * math.sqrt(4 / 3) < found.next_high - found.mean < 2 * 1.96 * 0.01 * math.sqrt(4 / 3)


def test_values_with_next_to_no_noise():
    draw = np.random.default_rng(1)
    for _ in range(100):
        values = draw.normal(0, 1, 3)
        assert population(values, np.full(3, 1e-12)).tau == pytest.approx(values.std(ddof=1))


def test_members_of_which_one_has_no_noise():
    with np.errstate(invalid="raise"):
        found = population([0.0, 1.0], [1e-100, 1e-10])
    assert found.mean == pytest.approx(0.5) and found.tau == pytest.approx(math.sqrt(0.5))


def test_a_value_counts_by_its_noise():
    near = population([1.0, 2.0, 1.01], [0.01, 10.0, 0.01])
    assert near.mean == pytest.approx(1.005, abs=1e-3)


def test_a_single_value_says_nothing_of_a_population():
    found = population([2.0], [0.5])
    assert (found.n, found.mean, found.stderr) == (1, 2.0, 0.5)
    assert (found.low, found.high) == pytest.approx((2 - 0.98, 2 + 0.98), abs=1e-3)
    assert all(math.isnan(each) for each in (found.tau, found.tau_high, found.next_low, found.p))


@pytest.mark.parametrize("stderrs", [[0.0, 1.0], [math.nan, 1.0]])
def test_values_without_noise_are_refused(stderrs):
    with pytest.raises(ValueError, match="standard errors above zero"):
        population([1.0, 2.0], stderrs)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("n", "tau", "sigma"),
    [(3, 0.03, 1e-4), (3, 0.03, 0.03), (3, 0.03, 0.01), (3, 0.0, 1e-3), (10, 0.03, 1e-3)],
)
def test_intervals_hold_the_truth_as_often_as_they_say(n, tau, sigma):
    draw, runs = np.random.default_rng(5), 300
    held = np.zeros(3)
    for _ in range(runs):
        values = draw.normal(0, tau, n + 1) + draw.normal(0, sigma, n + 1)
        found = population(values[:n], np.full(n, sigma))
        held += (
            found.low <= 0 <= found.high,
            found.next_low <= values[n] <= found.next_high,
            found.tau_low <= tau,
        )
    mean, following, spread = held / runs
    assert 0.9 < mean < (0.98 if tau else 1)
    assert 0.9 < following < (0.98 if tau else 1)
    assert spread > 0.95


@pytest.mark.parametrize("tau", [0.0, 0.01, 0.05])
def test_the_spread_of_several_populations_lies_in_its_interval(tau):
    draw, n, runs = np.random.default_rng(8), 3, 300
    stderrs = np.array([0.02, 0.01, 0.03])
    held = found = 0.0
    for _ in range(runs):
        samples = [
            (mean + draw.normal(0, tau, n) + draw.normal(0, stderrs), stderrs**2)
            for mean in (1.0, 2.0, 5.0, 9.0)
        ]
        middle, low, high = common_spread(samples)
        assert low <= middle <= high
        held += low <= tau <= high
        found += middle**2 / runs
    assert held / runs > 0.92
    assert found == pytest.approx(tau**2, abs=2e-4)


@pytest.mark.parametrize("tau", [0.0, 1.0, 5.0])
def test_two_values_predict_a_third_as_often_as_they_say(tau):
    """Also where the two agree by chance: a spread that is drawn from what they make likely allows for it."""
    draw, held = np.random.default_rng(6), []
    for _ in range(300):
        values, third = draw.normal(0.0, math.hypot(1.0, tau), 2), draw.normal(0.0, tau)
        chances, squares = likely_spreads([(values, np.ones(2))])
        spread = np.sqrt(draw.choice(squares, 400, p=chances) * 1.5 + 0.5)
        low, high = np.percentile(values.mean() + spread * draw.standard_normal(400), [2.5, 97.5])
        held.append(low <= third <= high)
    assert np.mean(held) > 0.88


def test_members_whose_noise_is_below_rounding_beside_what_they_share():
    shared = np.array([[0.001], [0.0010000000000000002], [0.001]])
    found = population([21.274, 21.274 + 2e-10, 21.274], [2.6e-15, 4.5e-13, 3e-14], shared)
    assert found.mean == pytest.approx(21.274) and found.u == pytest.approx(0.001, rel=1e-3)
