"""Plain estimates from fit datasets."""

import numpy as np
from fabricated import fits, record

from freerock.models.laws import PAPER_MODELS
from freerock.products.estimates import estimates_in, estimates_of


def test_every_usable_fit_is_an_estimate():
    tree = fits(record("b1_marble"))
    found = list(estimates_in(tree))
    assert [(each.run, each.model) for each in found] == [
        (run, model) for run in (1, 2) for model in PAPER_MODELS
    ]
    for each in found:
        group = tree[f"run_{each.run}"][each.model]
        assert (each.test, each.block, each.foundation) == ("b1_marble", "b1", "marble")
        assert list(each.values) == group["parameter"].values.tolist()
        assert list(each.values.values()) == group["value"].values.tolist()
        n = len(each.parameters)
        np.testing.assert_array_equal(each.covariance, group["covariance"].values[:n, :n])


def test_failed_fits_are_no_estimates():
    some = fits(record("b1_marble"), failed=["hunt_crossley"])
    assert {each.model for each in estimates_of([some])} == {"housner", "winkler"}
    assert estimates_of([fits(record("b1_marble"), failed=PAPER_MODELS)]) == []
