"""Monte-Carlo studies of the identification in their small size, and their figures."""

import numpy as np
import pandas as pd
import pytest

from freerock.figures.studies import choice, coverage, model_error, success
from freerock.models.laws import PAPER_MODELS
from freerock.models.simulate import Solver
from freerock.studies import choice as study_of_choice
from freerock.studies import coverage as study_of_coverage
from freerock.studies import model_error as study_of_model_error
from freerock.studies import success as study_of_success
from freerock.studies.model_error import imperfect_motion
from freerock.studies.virtual_run import Truth, draw_truth, noise
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS

BLOCK, THETA0, _ = CONFIGURATIONS["config3"]
TRUTH = Truth("hunt_crossley", BLOCK, FOUNDATIONS["marble"], THETA0, 1e-4)


@pytest.mark.parametrize("kind, slow", [("white", 0.0), ("coloured", 0.5), ("mains and drift", 0.2)])
def test_noise_has_the_stated_spread_and_colour(kind, slow):
    truth = Truth(**{**vars(TRUTH), "noise": kind})
    samples = noise(truth, 400_000, np.random.default_rng(1)) / truth.sigma_theta
    total = {"white": 1.0, "coloured": 1.0, "mains and drift": np.sqrt(1.5)}[kind]
    assert samples.std() == pytest.approx(total, rel=0.03)
    correlation = samples[1:] @ samples[:-1] / (samples @ samples)
    assert correlation > slow - 0.1 if slow else abs(correlation) < 0.01


def test_an_imperfect_block_without_imperfection_follows_the_law():
    from freerock.models.simulate import simulate

    time_s, theta = imperfect_motion(TRUTH, "none")
    exact = simulate("hunt_crossley", BLOCK, TRUTH.parameters, time_s, theta0=THETA0, solver=Solver(1e-9))
    assert np.max(np.abs(theta - exact.theta)) < 1e-4 * THETA0
    for imperfection in ("centre", "uneven", "amplitude"):
        _, other = imperfect_motion(TRUTH, imperfection)
        assert np.max(np.abs(other - theta)) > 1e-2 * THETA0


def test_truths_are_drawn_from_the_whole_range():
    generator = np.random.default_rng(1)
    drawn = [draw_truth("winkler", ("white",), generator) for _ in range(500)]
    k = np.array([truth.parameters["k"] for truth in drawn])
    ratio = np.array([truth.parameters["c"] for truth in drawn]) / k
    assert 1e6 <= k.min() < 1.1e6 and 9e7 < k.max() <= 1e8
    assert 1e-3 <= ratio.min() < 1.1e-3 and 1.8e-2 < ratio.max() <= 2e-2
    assert {truth.block for truth in drawn} == {block for block, *_ in CONFIGURATIONS.values()}


def test_every_start_reaches_the_global_minimum():
    frame = study_of_success.run("small")
    assert set(frame["model"]) == set(PAPER_MODELS)
    assert (frame["reached"] | frame["reported"]).all()
    figure, data = success.draw(frame)
    assert len(figure.axes) == 3 and len(data) == len(frame)


def test_scatter_and_coverage_of_few_runs():
    rows = [
        row
        for i in range(6)
        for row in study_of_coverage._coverage(("config3", "marble", "hunt_crossley", "white", i))
    ]
    frame = pd.DataFrame(rows)
    summary = coverage.coverage_summary(frame).set_index("parameter")
    assert set(summary.index) == {"k", "lambda"}
    assert (summary["n"] == 6).all() and (summary["failed"] == 0).all()
    assert summary["efficiency"].between(0.3, 2.0).all()  # of six runs
    assert frame["stderr"].to_numpy() == pytest.approx(frame["bound"].to_numpy(), rel=0.1)
    coverage.draw(frame)


def test_the_residual_tells_of_an_imperfect_block():
    rows = [
        row
        for kind in ("none", "amplitude")
        for row in study_of_model_error._model_error(("config3", "marble", kind, 0))
    ]
    frame = pd.DataFrame(rows)
    assert frame["success"].all()
    assert frame.groupby("imperfection")["detected"].all().to_dict() == {"none": False, "amplitude": True}
    widened = frame.groupby("imperfection")["widened"].min()
    assert widened["none"] == pytest.approx(1, abs=0.1)
    assert widened["amplitude"] > 5
    model_error.draw(frame)


@pytest.mark.parametrize("model", PAPER_MODELS)
def test_the_choice_names_the_true_law(model):
    frame = pd.DataFrame(study_of_choice._choice((model, 0)))
    assert frame["chosen"].tolist() == [model]
    choice.draw(frame)
