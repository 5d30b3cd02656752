"""Predictions for other runs and blocks, and whether blocks share a foundation."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from freerock.identification.predict import FOUNDATIONS, PREDICTIONS, predictions, shared_foundation
from freerock.models.block import Block
from freerock.models.simulate import simulate_theta
from freerock.products.groups import runs_of
from freerock.runs.motion import Motion

BLOCKS = {"a": Block(0.28, 0.07, 5.84), "b": Block(0.14, 0.07, 2.98)}
TIME = np.arange(0, 2, 2e-3)
TRUTH = {"k": 6.88e6, "lambda": 1.30e8}


def tree(block, factors, stderr=1e-3, success=True, foundation="marble", width_m=None):
    """Fits of a record: a run per factor on k and λ, each with its own motion."""
    groups = {
        "/": xr.Dataset(
            attrs={"campaign": "made_up", "test": f"{block}_{foundation}", "block": block}
            | {"foundation": foundation, "origin": "simulated"}
        )
    }
    for run, factor in enumerate(factors, 1):
        value = {name: factor * number for name, number in TRUTH.items()}
        shape = replace(BLOCKS[block], contact_width_m=width_m)
        theta, _ = simulate_theta("hunt_crossley", shape, value, TIME, theta0=0.17)
        groups[f"run_{run}"] = xr.Dataset({"time": ("time", TIME), "theta": ("time", theta)})
        scale = np.array(list(value.values())) * stderr
        groups[f"run_{run}/hunt_crossley"] = xr.Dataset(
            {
                "value": ("parameter", [*value.values(), 0.17, *([width_m] if width_m else [])]),
                "covariance": (
                    ("parameter", "other"),
                    np.diag([*scale**2, 1e-12, *([1e-8] if width_m else [])]),
                ),
                "theta_model": ("time", theta),
                "success": ((), np.int8(success)),
            },
            {"parameter": ["k", "lambda", "theta0", *(["width"] if width_m else [])]},
        )
    return xr.DataTree.from_dict(groups)


def predicted(*trees):
    motions = {
        each.attrs["test"]: {
            run: Motion(group["time"].values, group["theta"].values, sigma_theta=1e-5, theta0=0.17)
            for run, group in runs_of(each).items()
        }
        for each in trees
    }
    return predictions(trees, motions.get, BLOCKS)


def test_other_runs_of_the_same_law_predict_a_run():
    table = predicted(tree("a", [1.0, 1.0, 1.0]))
    assert list(table) == PREDICTIONS
    assert table["basis"].tolist() == ["other runs"] * 3
    assert table["n_runs"].tolist() == [2] * 3
    assert table["epsilon_theta"].max() < 1e-12


def test_another_foundation_predicts_worse_and_other_blocks_are_told_apart():
    table = predicted(tree("a", [1.0, 1.5]), tree("b", [1.0]))
    assert set(table["basis"]) == {"other runs", "a", "b"}
    own = table.set_index(["test", "run", "basis"])["epsilon_theta"]
    assert own["a_marble", 1, "b"] < 1e-12  # its one run has the same k and λ
    assert own["a_marble", 2, "b"] > 1e-3
    assert own["a_marble", 1, "other runs"] > 1e-3
    assert table[(table["test"] == "b_marble") & (table["basis"] == "a")]["n_runs"].tolist() == [2]


def test_a_freed_width_goes_into_the_prediction():
    assert predicted(tree("a", [1.0, 1.0], width_m=0.066))["epsilon_theta"].max() < 1e-12


def test_failed_fits_neither_predict_nor_are_predicted():
    assert predicted(tree("a", [1.0, 1.0], success=False)).empty


@pytest.mark.parametrize("shift, shared", [(1.0, True), (1.2, False)])
def test_blocks_that_share_a_foundation(shift, shared):
    factors = np.exp(np.random.default_rng(1).normal(0, 0.01, 8))
    table = shared_foundation([tree("a", factors[:4]), tree("b", shift * factors[4:])])
    assert list(table) == FOUNDATIONS
    assert table["parameter"].tolist() == ["k", "lambda"]
    assert table["shared"].tolist() == [shared] * 2
    assert table["between_runs_percent"].between(0.3, 2.0).all()
    # standard errors of 0.1 % against a scatter of 1 %: the likelihood ratio alone rejects either
    assert (table["likelihood_ratio_p"] < 0.01).all() or shared


def test_likelihood_ratio_is_that_of_the_weighted_means():
    table = shared_foundation([tree("a", [1.0], stderr=1e-2), tree("b", [1.03], stderr=1e-2)])
    # two parameters, each the squared difference over the sum of two variances
    expected = 2 * math.log(1.03) ** 2 / (2 * 1e-4)
    assert table["likelihood_ratio"].tolist() == pytest.approx([expected] * 2, rel=1e-9)
    assert np.isnan(table["f_p"]).all() and table["shared"].all()


def test_one_block_is_no_question():
    assert shared_foundation([tree("a", [1.0, 1.1])]).empty
    assert shared_foundation([]).empty
