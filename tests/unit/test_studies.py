"""The studies in their small size, and their figures."""

import inspect
import math
from importlib import import_module

import numpy as np
import pandas as pd
import pytest

from freerock.errors import FreerockError
from freerock.figures import studies as figures
from freerock.figures.style import save
from freerock.models.block import Block
from freerock.models.laws import PAPER_MODELS
from freerock.studies import choice, coverage, model_cost, model_error, speed_accuracy, stability, success
from freerock.studies.atlas.cells import COLUMNS, STATES, attempt, judge
from freerock.studies.methods.by_name import freerock
from freerock.studies.methods.problem import Problem, Solution
from freerock.studies.scenes import scenes
from freerock.studies.timing import interleaved

pytestmark = pytest.mark.slow

TIME = np.arange(0, 0.6, 1e-3)
for name in figures.__all__:
    import_module(f"freerock.figures.studies.{name}")


@pytest.mark.parametrize("name", figures.__all__)
def test_a_study_is_one_module_with_one_function_and_so_is_its_figure(name):
    run = inspect.signature(import_module(f"freerock.studies.{name}").run)
    assert [(each.name, each.default) for each in run.parameters.values()] == [("size", "full")]
    draw = inspect.signature(getattr(figures, name).draw)
    assert list(draw.parameters) == ["frame", "labels"]


def test_interleaved_times_every_call_and_keeps_the_results():
    order = []
    calls = [lambda i=i: order.append(i) or i for i in range(3)]
    timed = interleaved(calls, rounds=2)
    assert [result for result, *_ in timed] == [0, 1, 2]
    assert [runs for *_, runs in timed] == [2, 2, 2]
    assert order == [0, 1, 2] * 3


@pytest.fixture(scope="module")
def speeds():
    return speed_accuracy.run("small")


@pytest.fixture(scope="module")
def choices():
    return model_cost.run("small")


@pytest.fixture(scope="module")
def cells():
    return stability.run("small")


def test_speed_accuracy(speeds):
    assert set(speeds["model"]) == {"housner", "winkler", "hunt_crossley"}
    assert (speeds["outcome"] == "completed").all()
    assert (speeds["time_s"] > 0).all()
    assert (speeds["reference_epsilon"] < 1e-20).all()
    own = speeds[speeds["method"] == "freerock"].groupby("model")["epsilon"].min()
    assert (own < 1e-14).all()
    assert len(scenes()) == 11


def test_model_choice(choices):
    epsilon = choices.set_index("model")["epsilon_theta"]
    assert epsilon["housner"] > 1e-2 > epsilon["winkler"] > epsilon["hunt_crossley"]
    assert epsilon["hunt_crossley"] == pytest.approx(choices["noise_epsilon"].iloc[0], rel=0.02)
    assert choices["success"].all()


def test_atlas(cells):
    assert list(cells.columns) == COLUMNS
    assert set(cells["state"]) <= set(STATES)
    assert set(cells["map"]) == {"stiffness", "step", "release", "springs", "tail", "housner_fit", "fit"}
    assert (cells["pipeline"] != "").all()
    assert (cells.loc[cells["method"] == "freerock", "state"] == "converged").all()
    failed = cells[~cells["state"].isin(["converged"])]
    assert (failed["cause"] != "").all()
    assert {"unstable", "inaccurate"} <= set(failed["state"])


@pytest.mark.parametrize(
    "solution, true, state",
    [
        (Solution(np.full(9, 0.1), 9, "completed"), Solution(np.full(9, 0.1), 9, "completed"), "converged"),
        (Solution(np.full(9, 0.1), 9, "completed"), Solution(np.full(9, 0.11), 9, "completed"), "inaccurate"),
        (Solution(np.full(9, 0.1), 9, "completed"), None, "inaccurate"),
        (Solution(np.full(9, 0.1), 9, "overturned"), Solution(np.full(9, 0.1), 9, "completed"), "unstable"),
        (Solution(np.full(9, math.nan), 9, "non_finite"), None, "unstable"),
        (Solution(np.full(9, math.nan), 9, "step_limit"), None, "too_slow"),
    ],
)
def test_states(solution, true, state):
    assert judge(solution, true)[0] == state


def test_refusals_are_cells_too():
    squat = Problem(
        "housner", Block(0.035, 0.07, 1.0), {"r": Block(0.035, 0.07, 1.0).restitution_housner}, 0.1
    )
    assert isinstance(attempt(freerock, squat, TIME, 1e-8, 100), FreerockError)


@pytest.mark.parametrize("name", ["speed_accuracy", "model_cost", "stability"])
def test_figures(name, request, tmp_path):
    frame = request.getfixturevalue(
        {"speed_accuracy": "speeds", "model_cost": "choices", "stability": "cells"}[name]
    )
    drawn, data = getattr(figures, name).draw(frame)
    save(drawn, data, tmp_path / name)
    assert (tmp_path / f"{name}.pdf").stat().st_size > 5000
    assert (tmp_path / f"{name}.png").stat().st_size > 10000
    assert len(pd.read_csv(tmp_path / f"{name}.csv")) == len(frame)


def test_every_start_reaches_the_global_minimum():
    frame = success.run("small")
    assert set(frame["model"]) == set(PAPER_MODELS)
    assert (frame["reached"] | frame["reported"]).all()
    figure, data = figures.success.draw(frame)
    assert len(figure.axes) == 3 and len(data) == len(frame)


def test_scatter_and_coverage_of_few_runs():
    rows = [
        row
        for i in range(6)
        for row in coverage._coverage(("config3", "marble", "hunt_crossley", "white", i))
    ]
    frame = pd.DataFrame(rows)
    summary = figures.coverage.coverage_summary(frame).set_index("parameter")
    assert set(summary.index) == {"k", "lambda"}
    assert (summary["n"] == 6).all() and (summary["failed"] == 0).all()
    assert summary["efficiency"].between(0.3, 2.0).all()  # of six runs
    assert frame["stderr"].to_numpy() == pytest.approx(frame["bound"].to_numpy(), rel=0.1)
    figures.coverage.draw(frame)


def test_the_residual_shows_an_imperfect_block():
    rows = [
        row
        for kind in ("none", "amplitude")
        for row in model_error._model_error(("config3", "marble", kind, 0))
    ]
    frame = pd.DataFrame(rows)
    assert frame["success"].all()
    assert frame.groupby("imperfection")["detected"].all().to_dict() == {"none": False, "amplitude": True}
    widened = frame.groupby("imperfection")["widened"].min()
    assert widened["none"] == pytest.approx(1, abs=0.1)
    assert widened["amplitude"] > 5
    figures.model_error.draw(frame)


@pytest.mark.parametrize("model", PAPER_MODELS)
def test_the_choice_names_the_true_law(model):
    frame = pd.DataFrame(choice._choice((model, 0)))
    assert frame["chosen"].tolist() == [model]
    figures.choice.draw(frame)
