"""Whether blocks differ by more than their runs do, where each block has a spread of its own."""

import numpy as np
import pytest
from scipy.stats import f, ttest_ind

from freerock.populations.between_blocks import (
    between_blocks,
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
