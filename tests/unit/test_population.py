"""Whether blocks share a foundation."""

import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f, f_oneway

from freerock.identification.estimate import Estimate
from freerock.identification.population import (
    FOUNDATIONS,
    between_blocks,
    shared_foundation,
    visible_difference,
)

TRUTH = {"k": 6.88e6, "lambda": 1.30e8}
COVARIANCE = 1e-4 * np.array([[1.0, 0.8], [0.8, 1.0]])  # of ln k and ln λ from run to run


def estimates(block, logs, shifts=None):
    """An estimate per row of what ln k and ln λ are off."""
    found = []
    for run, off in enumerate(np.atleast_2d(logs), 1):
        values = {name: math.exp(by) * TRUTH[name] for name, by in zip(TRUTH, off, strict=True)}
        names = "made_up", f"{block}_marble", run, block, "marble", "hunt_crossley"
        found.append(Estimate(*names, values, np.eye(2), shifts or {}))
    return found


def drawn(seed, *sizes, shift=(0.0, 0.0)):
    """Runs of blocks, the last of which is shifted."""
    generator = np.random.default_rng(seed)
    blocks = [generator.multivariate_normal(np.zeros(2), COVARIANCE, n) for n in sizes]
    return [*blocks[:-1], blocks[-1] + np.array(shift)]


@pytest.mark.parametrize("shift, shared", [(0.0, True), (0.1, False)])
def test_blocks_that_share_a_foundation(shift, shared):
    blocks = drawn(1, 4, 4, shift=(shift, shift))
    table = shared_foundation([*estimates("a", blocks[0]), *estimates("b", blocks[1])])
    assert list(table) == FOUNDATIONS
    assert table["parameter"].tolist() == ["k", "lambda"]
    assert table["shared"].tolist() == [shared] * 2
    assert table["between_runs_percent"].between(0.3, 2.0).all()


def test_of_one_parameter_it_is_the_analysis_of_variance():
    blocks = [each[:, :1] for each in drawn(3, 3, 4, 5)]
    expected = f_oneway(*(each[:, 0] for each in blocks))
    found = between_blocks(blocks)
    assert found.f_ratio == pytest.approx(expected.statistic) and found.p == pytest.approx(expected.pvalue)


def test_of_two_blocks_it_is_hotellings():
    one, other = drawn(4, 4, 6, shift=(0.02, 0.0))
    apart = one.mean(axis=0) - other.mean(axis=0)
    pooled = (3 * np.cov(one.T) + 5 * np.cov(other.T)) / 8
    squared = 4 * 6 / 10 * apart @ np.linalg.solve(pooled, apart)
    ratio = (10 - 2 - 1) / (2 * 8) * squared
    found = between_blocks([one, other])
    assert found.f_ratio == pytest.approx(ratio) and found.p == pytest.approx(f.sf(ratio, 2, 7))


@pytest.mark.parametrize("sizes", [(3, 3), (3, 3, 3), (2, 3, 5), (2, 2)])
def test_false_alarms_are_five_in_a_hundred(sizes):
    p = np.array([between_blocks(drawn([7, i], *sizes)).p for i in range(1500)])
    assert 0.033 < np.mean(p < 0.05) < 0.067


@pytest.mark.parametrize("sizes", [(4, 4), (5, 5, 5)])
def test_the_visible_difference_is_seen_four_times_in_five(sizes):
    found = [visible_difference(drawn([8, i], *sizes))[0] for i in range(60)]
    runs = np.linalg.inv(COVARIANCE)[0, 0]
    truly = visible_difference([_exact(n) for n in sizes])[0]  # of runs with just this covariance
    assert np.median(found) == pytest.approx(truly, rel=0.25) and truly > 1 / math.sqrt(runs)
    between = (0.0,) if len(sizes) == 3 else ()
    seen = 0
    for i in range(500):
        blocks = drawn([9, i], *sizes)
        shifts = [-truly / 2, *between, truly / 2]
        blocks = [each + np.array([by, 0.0]) for each, by in zip(blocks, shifts, strict=True)]
        seen += between_blocks(blocks).p < 0.05
    assert 0.74 < seen / 500 < 0.86


@pytest.mark.parametrize("sizes", [(3, 3), (3, 3, 3), (4, 4, 4), (4,) * 6])
def test_of_any_number_of_runs_and_blocks_there_is_a_visible_difference(sizes):
    visible = visible_difference([_exact(n) for n in sizes])
    assert np.all(np.isfinite(visible)) and np.all(visible > 0)


def _exact(n):
    """n runs whose scatter within the block is the covariance, with n - 1 degrees of freedom."""
    raw = np.random.default_rng(n).standard_normal((n, 2))
    raw -= raw.mean(axis=0)
    white = raw @ np.linalg.inv(np.linalg.cholesky(np.cov(raw.T))).T
    return white @ np.linalg.cholesky(COVARIANCE).T


@pytest.mark.parametrize("sizes", [(1, 1), (1, 1, 1), (2, 1)])
def test_one_run_a_block_never_answers(sizes):
    blocks = drawn(2, *sizes, shift=(1.0, 1.0))
    table = shared_foundation(
        [each for name, own in zip("abc", blocks, strict=False) for each in estimates(name, own)]
    )
    assert (
        table["shared"].isna().all() and table["f_p"].isna().all() and table["visible_percent"].isna().all()
    )


def test_blocks_that_differ_by_no_more_than_their_widths_may_are_not_told_apart():
    one, other = drawn(6, 4, 4, shift=(0.08, 0.08))
    exact = shared_foundation([*estimates("a", one), *estimates("b", other)])
    assert not exact["shared"].any() and exact["by_inputs_percent"].tolist() == [0, 0]
    widths = [{(block, "width_m"): np.array([0.05, 0.05])} for block in "ab"]
    rough = shared_foundation([*estimates("a", one, widths[0]), *estimates("b", other, widths[1])])
    assert rough["shared"].all() and (rough["inputs_p"] > 0.05).all()
    assert rough["by_inputs_percent"].tolist() == pytest.approx([5.0, 5.0])
    laser = {("laser", "scale_fraction"): np.array([0.05, 0.05])}  # shifts both alike
    alike = shared_foundation([*estimates("a", one, laser), *estimates("b", other, laser)])
    assert not alike["shared"].any()


def test_one_block_is_no_question():
    assert shared_foundation(estimates("a", [[0, 0], [0.1, 0.1]])).empty
    assert shared_foundation([]).empty


def test_a_law_that_the_runs_reject_says_nothing_of_the_foundation():
    blocks = drawn(5, 3, 2, shift=(0.5, 0.5))
    found = [*estimates("a", blocks[0]), *estimates("b", blocks[1])]
    each = [(fit.test, fit.run, fit.model) for fit in found]
    for rejected, shared in ((each[:2], False), (each[:3], None), (each, None)):
        table = shared_foundation(found, set(rejected))
        assert table["n_runs_rejected"].tolist() == [len(rejected)] * 2
        assert [None if pd.isna(answer) else answer for answer in table["shared"]] == [shared] * 2
    others = {(test, run, "winkler") for test, run, _ in each}
    assert shared_foundation(found, others)["n_runs_rejected"].tolist() == [0, 0]
