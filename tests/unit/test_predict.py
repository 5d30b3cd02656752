"""Predictions for other runs and blocks."""

from dataclasses import replace

import numpy as np

from freerock.models.block import Block
from freerock.models.simulate import simulate_theta
from freerock.populations.estimate import Estimate
from freerock.populations.predict import PREDICTIONS, predictions
from freerock.runs.motion import Motion

BLOCKS = {"a": Block(0.28, 0.07, 5.84), "b": Block(0.14, 0.07, 2.98)}
TIME = np.arange(0, 2, 2e-3)
TRUTH = {"k": 6.88e6, "lambda": 1.30e8}


def record(block, factors, width_m=None):
    """Estimate and motion of each run of a record: a run per factor on k and λ, each with its own motion."""
    estimates, motions = [], {}
    for run, factor in enumerate(factors, 1):
        law = {name: factor * number for name, number in TRUTH.items()}
        shape = replace(BLOCKS[block], contact_width_m=width_m)
        theta, _ = simulate_theta("hunt_crossley", shape, law, TIME, theta0=0.17)
        values = law | {"theta0": 0.17} | ({"width": width_m} if width_m else {})
        names = "made_up", f"{block}_marble", run, block, "marble", "hunt_crossley"
        estimates.append(Estimate(*names, values, np.eye(2)))
        motions[run] = Motion(TIME, theta, sigma_theta=1e-5, theta0=0.17)
    return estimates, motions


def predicted(*records):
    estimates = [each for found, _ in records for each in found]
    motions = {found[0].test: measured for found, measured in records}
    return predictions(estimates, motions.__getitem__, BLOCKS)


def test_other_runs_of_the_same_law_predict_a_run():
    table = predicted(record("a", [1.0, 1.0, 1.0]))
    assert list(table) == PREDICTIONS
    assert table["basis"].tolist() == ["other runs"] * 3
    assert table["n_runs"].tolist() == [2] * 3
    assert table["epsilon_theta"].max() < 1e-12


def test_another_foundation_predicts_worse_and_other_blocks_are_told_apart():
    table = predicted(record("a", [1.0, 1.5]), record("b", [1.0]))
    assert set(table["basis"]) == {"other runs", "a", "b"}
    own = table.set_index(["test", "run", "basis"])["epsilon_theta"]
    assert own["a_marble", 1, "b"] < 1e-12  # its one run has the same k and λ
    assert own["a_marble", 2, "b"] > 1e-3
    assert own["a_marble", 1, "other runs"] > 1e-3
    assert table[(table["test"] == "b_marble") & (table["basis"] == "a")]["n_runs"].tolist() == [2]


def test_a_freed_width_goes_into_the_prediction():
    assert predicted(record("a", [1.0, 1.0], width_m=0.066))["epsilon_theta"].max() < 1e-12


def test_the_restitution_of_a_rigid_block_is_its_own():
    records = record("a", [1.0, 1.0]), record("b", [1.0])
    rigid = [
        ([replace(each, model="housner", values={"r": 0.9, "theta0": 0.17}) for each in found], motions)
        for found, motions in records
    ]
    assert predicted(*rigid)["basis"].tolist() == ["other runs"] * 2
