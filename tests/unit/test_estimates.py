"""Plain estimates from fit datasets."""

from dataclasses import replace

import numpy as np
import pytest
from fabricated import fits, record

from freerock.models.block import Block
from freerock.models.laws import PAPER_MODELS
from freerock.products.estimates import estimates_in
from freerock.rotation.laboratory import Input
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View


def test_every_usable_fit_is_an_estimate():
    tree = fits(record("b1_marble"))
    found = list(estimates_in([tree]))
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


def test_the_laboratory_has_the_inputs_that_the_fit_moved():
    """Two standard uncertainties of the height, one of the scale of the one laser."""
    block, own = Block(1.0, 0.25, 500.0), next(estimates_in([fits(record("b1_marble"))]))
    height, scale = Input("b1", "height_m", 5e-3, True), Input("laser", "scale_fraction", 1e-3, True)
    view = View(block, Laser("horizontal", 0.4, 0.1))
    known = replace(own, moved={height: 2.0, scale: 1.0}).laboratory(block, view)
    moved = known.moved({height: 2.0, scale: 1.0})
    assert moved.block == Block(1.01, 0.25, 500.0) and moved.scales[0] == pytest.approx(1.001)
    other = Input("second", "scale_fraction", 1e-3, True)
    assert replace(own, moved={height: 2.0, scale: 1.0, other: 1.0}).laboratory(block, view).inputs == (
        height,
    )
    assert replace(own, moved={}).laboratory(block, None).inputs == ()


def test_failed_fits_are_no_estimates():
    some = fits(record("b1_marble"), failed=["hunt_crossley"])
    assert {each.model for each in estimates_in([some])} == {"housner", "winkler"}
    assert [*estimates_in([fits(record("b1_marble"), failed=PAPER_MODELS)])] == []
