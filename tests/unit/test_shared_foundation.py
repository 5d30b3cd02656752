"""Whether blocks share a foundation."""

import math

import numpy as np
import pandas as pd
import pytest

from freerock.populations.estimate import Estimate
from freerock.populations.shared_foundation import FOUNDATIONS, shared_foundation

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
    pooled = np.sqrt(np.mean([np.var(own, axis=0, ddof=1) for own in blocks], axis=0))  # of as many runs
    np.testing.assert_allclose(table["between_runs_percent"], 100 * pooled, rtol=1e-9)


@pytest.mark.parametrize("sizes", [(1, 1), (1, 1, 1), (2, 1)])
def test_one_run_a_block_never_answers(sizes):
    blocks = drawn(2, *sizes, shift=(1.0, 1.0))
    table = shared_foundation(
        [each for name, own in zip("abc", blocks, strict=False) for each in estimates(name, own)]
    )
    assert (
        table["shared"].isna().all() and table["f_p"].isna().all() and table["visible_percent"].isna().all()
    )


def test_a_block_of_a_single_run_may_differ():
    several, single = drawn(1, 4, 4), np.zeros((1, 2))
    for by, shared in ((0.0, None), (0.1, False)):
        blocks = [several[0], several[1] + by, single]
        table = shared_foundation(
            [each for name, own in zip("abc", blocks, strict=True) for each in estimates(name, own)]
        )
        assert [None if pd.isna(answer) else answer for answer in table["shared"]] == [shared] * 2
        assert (table["n_blocks"] == 3).all() and table["f_p"].notna().all()


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


def test_a_single_run_that_inputs_bring_near_shows_no_shared_foundation():
    """Runs that differ significantly by scatter alone, but not with the inputs of their blocks."""
    several, single = drawn(1, 4, 4), np.zeros((1, 2))
    widths = [{(block, "width_m"): np.array([0.1, 0.1])} for block in "abc"]
    table = shared_foundation(
        [
            each
            for name, own, width in zip("abc", (several[0], several[1] + 0.1, single), widths, strict=True)
            for each in estimates(name, own, width)
        ]
    )
    assert (table["f_p"] < 0.05).all() and (table["inputs_p"] > 0.05).all()
    assert table["shared"].isna().all()


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
