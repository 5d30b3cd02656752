"""Plain estimates from fit datasets."""

from dataclasses import replace

import numpy as np
import pytest
from fabricated import fits, record

from freerock.models.block import Block
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


def test_a_block_has_the_dimensions_that_belong_to_its_parameters():
    """A centre of mass and an inertia that are not given are moved from those of a uniform block."""
    block = Block(1.0, 0.25, 500.0)
    own = next(iter(estimates_in(fits(record("b1_marble")))))
    moved = replace(own, moved={"height_m": 0.01, "com_height_m": 2e-3, "inertia_kg_m2": 0.5}).block_of(block)
    taller = Block(1.01, 0.25, 500.0)
    assert (moved.height_m, moved.width_m) == (1.01, 0.25)
    assert moved.h == pytest.approx(0.507) and moved.inertia_cm == pytest.approx(taller.inertia_cm + 0.5)
    assert replace(own, moved={}).block_of(block) == block


def test_failed_fits_are_no_estimates():
    some = fits(record("b1_marble"), failed=["hunt_crossley"])
    assert {each.model for each in estimates_of([some])} == {"housner", "winkler"}
    assert estimates_of([fits(record("b1_marble"), failed=PAPER_MODELS)]) == []
