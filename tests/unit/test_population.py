"""Whether blocks share a foundation."""

import math

import numpy as np
import pandas as pd
import pytest

from freerock.identification.estimate import Estimate
from freerock.identification.population import FOUNDATIONS, shared_foundation

TRUTH = {"k": 6.88e6, "lambda": 1.30e8}


def estimates(block, factors, stderr=1e-3):
    """An estimate per factor on k and λ, with a relative standard error."""
    found = []
    for run, factor in enumerate(factors, 1):
        values = {name: factor * number for name, number in TRUTH.items()}
        covariance = np.diag((np.array(list(values.values())) * stderr) ** 2)
        names = "made_up", f"{block}_marble", run, block, "marble", "hunt_crossley"
        found.append(Estimate(*names, values, covariance))
    return found


@pytest.mark.parametrize("shift, shared", [(1.0, True), (1.2, False)])
def test_blocks_that_share_a_foundation(shift, shared):
    factors = np.exp(np.random.default_rng(1).normal(0, 0.01, 8))
    table = shared_foundation([*estimates("a", factors[:4]), *estimates("b", shift * factors[4:])])
    assert list(table) == FOUNDATIONS
    assert table["parameter"].tolist() == ["k", "lambda"]
    assert table["shared"].tolist() == [shared] * 2
    assert table["between_runs_percent"].between(0.3, 2.0).all()
    # standard errors of 0.1 % against a scatter of 1 %: the likelihood ratio alone rejects either
    assert (table["likelihood_ratio_p"] < 0.01).all() or shared


def test_likelihood_ratio_is_that_of_the_weighted_means():
    table = shared_foundation([*estimates("a", [1.0], stderr=1e-2), *estimates("b", [1.03], stderr=1e-2)])
    # two parameters, each the squared difference over the sum of two variances
    expected = 2 * math.log(1.03) ** 2 / (2 * 1e-4)
    assert table["likelihood_ratio"].tolist() == pytest.approx([expected] * 2, rel=1e-9)
    assert np.isnan(table["f_p"]).all() and table["shared"].all()


def test_one_block_is_no_question():
    assert shared_foundation(estimates("a", [1.0, 1.1])).empty
    assert shared_foundation([]).empty


def test_a_law_that_the_runs_reject_says_nothing_of_the_foundation():
    found = [*estimates("a", [1.0, 1.01, 1.02]), *estimates("b", [1.5, 1.51])]
    each = [(fit.test, fit.run, fit.model) for fit in found]
    for rejected, shared in ((each[:2], False), (each[:3], None), (each, None)):
        table = shared_foundation(found, set(rejected))
        assert table["n_runs_rejected"].tolist() == [len(rejected)] * 2
        assert [None if pd.isna(answer) else answer for answer in table["shared"]] == [shared] * 2
    others = {(test, run, "winkler") for test, run, _ in each}
    assert shared_foundation(found, others)["n_runs_rejected"].tolist() == [0, 0]
