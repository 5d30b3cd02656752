"""Whether blocks differ by more than their runs do, where each block has a spread of its own."""

import numpy as np
import pytest
from scipy.stats import f, ncf, ttest_ind

from freerock.populations.between_blocks import (
    TEST,
    between_blocks,
    beyond,
    matched,
    visible_difference,
)

COVARIANCE = 1e-4 * np.array([[1.0, 0.8], [0.8, 1.0]])  # of ln k and ln λ from run to run


def drawn(seed, sizes, spreads=None, shift=0.0):
    """Runs of blocks, the last of which is shifted by so many spreads."""
    generator = np.random.default_rng(seed)
    blocks = [
        spread * generator.multivariate_normal(np.zeros(2), COVARIANCE, n)
        for n, spread in zip(sizes, spreads or [1.0] * len(sizes), strict=True)
    ]
    return [*blocks[:-1], blocks[-1] + 0.01 * shift]


def exact(n):
    """n runs whose scatter within the block is the covariance, with n - 1 degrees of freedom."""
    raw = np.random.default_rng(n).standard_normal((n, 2))
    raw -= raw.mean(axis=0)
    white = raw @ np.linalg.inv(np.linalg.cholesky(np.cov(raw.T))).T
    return white @ np.linalg.cholesky(COVARIANCE).T


def seen(sizes, spreads=None, shifts=None, n_draws=1500):
    """Share of draws in which p is below 5 %."""
    shifts = shifts or [0.0] * len(sizes)
    found = [
        between_blocks(
            [own + np.array([by, 0.0]) for own, by in zip(drawn([7, i], sizes, spreads), shifts, strict=True)]
        ).p
        for i in range(n_draws)
    ]
    return np.mean(np.array(found) < 0.05)


def test_of_one_parameter_and_two_blocks_it_is_welchs():
    one, other = (own[:, :1] for own in drawn(3, (5, 5), (1.0, 3.0)))
    expected = ttest_ind(one[:, 0], other[:, 0], equal_var=False)
    found = between_blocks([one, other])
    assert found.f_ratio == pytest.approx(expected.statistic**2) and found.p == pytest.approx(expected.pvalue)
    assert found.dof == pytest.approx((1.0, expected.df))


def test_of_one_parameter_and_more_blocks_it_is_brown_and_forsythes():
    """With the degrees of freedom of Mehrotra (1997, doi:10.1080/03610919708813431)."""
    blocks = [own[:, 0] for own in drawn(4, (4, 4, 4), (1.0, 2.0, 4.0), shift=8)]
    means, variances = np.mean(blocks, axis=1), np.var(blocks, axis=1, ddof=1)
    ratio = 4 * np.sum((means - means.mean()) ** 2) / np.sum(2 / 3 * variances)
    first = (2 / 3 * variances.sum()) ** 2 / (np.sum(variances**2) / 3 + (variances.sum() / 3) ** 2)
    second = variances.sum() ** 2 / np.sum(variances**2 / 3)
    found = between_blocks([own[:, None] for own in blocks])
    assert found.f_ratio == pytest.approx(ratio) and found.dof == pytest.approx((first, second))
    assert found.p == pytest.approx(f.sf(ratio, first, second))


def test_of_two_blocks_it_is_krishnamoorthy_and_yus():
    """T² and ν of their equations 1 and 7 (2004, doi:10.1016/j.spl.2003.10.012)."""
    blocks = drawn(5, (6, 6), (1.0, 3.0), shift=4)
    apart = blocks[0].mean(axis=0) - blocks[1].mean(axis=0)
    shares = [np.cov(own.T) / 6 for own in blocks]
    inverse = np.linalg.inv(sum(shares))
    terms = [(np.trace(each @ each) + np.trace(each) ** 2) / 5 for each in (own @ inverse for own in shares)]
    nu = 6 / sum(terms)
    ratio = (nu - 1) / (2 * nu) * apart @ inverse @ apart
    found = between_blocks(blocks)
    assert found.f_ratio == pytest.approx(ratio) and found.dof == pytest.approx((2, nu - 1))
    assert found.p == pytest.approx(f.sf(ratio, 2, nu - 1))


def test_of_blocks_that_scatter_alike_it_is_wilks():
    blocks = [exact(5) + np.array([0.01 * i, 0.0]) for i in range(3)]
    within = sum((own - own.mean(axis=0)).T @ (own - own.mean(axis=0)) for own in blocks)
    every = np.concatenate(blocks) - np.concatenate(blocks).mean(axis=0)
    root = np.sqrt(np.linalg.det(every.T @ every) / np.linalg.det(within))
    found = between_blocks(blocks)
    assert found.dof == pytest.approx((4, 22)) and found.f_ratio == pytest.approx((root - 1) * 22 / 4)


def test_the_block_with_the_fewest_runs_counts_for_more():
    scatter = matched([exact(3), exact(10)])
    weight = np.array([10 / 13, 3 / 13]) * (1 + TEST.caution / np.array([2, 9]))
    assert scatter.dof_within == pytest.approx(weight.sum() ** 2 / np.sum(weight**2 / [2, 9]))
    assert scatter.dof_within < 1 / (10**2 / 13**2 / 2 + 3**2 / 13**2 / 9)  # of Krishnamoorthy and Yu
    assert scatter.dof_between == pytest.approx(1)


def test_it_does_not_depend_on_units_or_on_how_parameters_are_mixed():
    blocks = drawn(6, (3, 4, 6), (1.0, 2.0, 0.5), shift=2)
    mixed = [own @ np.array([[3.0, 0.2], [-1.0, 1e-3]]) + np.array([7.0, -1.0]) for own in blocks]
    assert between_blocks(mixed).p == pytest.approx(between_blocks(blocks).p, rel=1e-6)
    assert between_blocks(mixed).dof == pytest.approx(between_blocks(blocks).dof, rel=1e-6)


@pytest.mark.parametrize("sizes", [(5, 5), (6, 6), (10, 10, 10), (5, 6, 8)])
def test_false_alarms_are_five_in_a_hundred(sizes):
    assert 0.03 < seen(sizes) < 0.07


@pytest.mark.parametrize(
    "sizes, spreads",
    [
        ((3, 5), (3.0, 1.0)),
        ((5, 5, 5), (4.0, 1.0, 1.0)),
        ((3, 8), (4.0, 1.0)),
        ((3, 4, 8), (4.0, 2.0, 1.0)),
        ((2, 2, 2), (1.0, 2.0, 4.0)),
        ((8, 3), (0.3, 1.0)),
        ((2, 4, 8, 10), (4.0, 1.0, 1.0, 1.0)),
    ],
)
def test_blocks_of_unlike_spreads_give_no_more_false_alarms(sizes, spreads):
    """None of them among the cases that the caution was set on; Wilks' Λ gives 10 to 56 %."""
    assert seen(sizes, spreads) < 0.07


@pytest.mark.parametrize("sizes", [(3, 3), (4, 4), (10, 10), (3, 6), (5, 5, 5)])
def test_the_visible_difference_is_seen_about_four_times_in_five(sizes):
    typical = np.median([visible_difference(drawn([8, i], sizes))[0] for i in range(60)])
    between = [0.0] * (len(sizes) - 2)
    assert 0.67 < seen(sizes, None, [-typical / 2, *between, typical / 2], 500) < 0.88


@pytest.mark.parametrize("sizes", [(3, 3), (3, 3, 3), (4, 4, 4), (4,) * 6])
def test_of_any_number_of_runs_and_blocks_there_is_a_visible_difference(sizes):
    visible = visible_difference([exact(n) for n in sizes])
    assert np.all(np.isfinite(visible)) and np.all(visible > 0)


@pytest.mark.parametrize("noncentrality", [1e-6, 0.3, 12.0, 400.0, 3100.0, TEST.largest])
@pytest.mark.parametrize(("first", "second"), [(1.0, 0.4), (2.7, 3.0), (4.0, 150.0)])
def test_the_chance_of_a_noncentral_f_is_as_scipy_has_it(first, second, noncentrality):
    for f_ratio in f.isf([0.9, 0.05], first, second):
        expected = ncf.sf(f_ratio, first, second, noncentrality)
        assert beyond(f_ratio, first, second, noncentrality) == pytest.approx(expected, abs=1e-10)


def test_a_block_of_a_single_run_takes_no_part():
    blocks = drawn(9, (4, 5), shift=3)
    with_single = [*blocks, np.array([[1.0, -1.0]])]
    assert between_blocks(with_single) == between_blocks(blocks)
    assert visible_difference(with_single) == pytest.approx(visible_difference(blocks))


@pytest.mark.parametrize("sizes", [(1, 1), (5, 1), (2, 1), (1, 1, 1)])
def test_of_one_block_with_several_runs_nothing_is_known(sizes):
    blocks = drawn(2, sizes, shift=100)
    assert np.isnan(between_blocks(blocks).p) and np.isnan(visible_difference(blocks)).all()


def test_of_runs_that_are_alike_nothing_is_known():
    alike = [np.ones((3, 2)), 2 * np.ones((3, 2))]
    assert np.isnan(between_blocks(alike).p) and np.isnan(visible_difference(alike)).all()


def test_where_no_difference_would_be_seen_none_is_given():
    assert np.isnan(visible_difference(drawn(1, (2, 2)))).all()
    assert not between_blocks(drawn(1, (2, 2), shift=10)).p < 0.05


def test_the_next_runs_show_the_degrees_of_freedom_of_half_a_run_less():
    """Of two blocks of three runs, four degrees of freedom of one parameter."""
    runs = np.array([[-1.0], [0.0], [1.0]])
    (visible,) = visible_difference([runs, runs])
    dof = 4 * (1 - 0.5 / 3)
    seen = ncf.sf(f.isf(TEST.significant, 1, dof), 1, dof, 3 * visible**2 / 2)
    assert seen == pytest.approx(TEST.power)
