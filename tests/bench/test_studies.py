"""The studies in their small size, and their figures."""

import inspect
import math
from importlib import import_module

import numpy as np
import pandas as pd
import pytest

from freerock.errors import FreerockError
from freerock.figures.style import save
from freerock.models.block import Block
from freerock.models.laws import LAWS, PAPER_MODELS
from freerock_bench import (
    choice,
    confusion,
    coverage,
    figures,
    inputs,
    model_cost,
    model_error,
    scatter,
    shared,
    speed_accuracy,
    stability,
    success,
)
from freerock_bench.atlas.cells import COLUMNS, STATES, attempt, judge
from freerock_bench.methods.by_name import freerock
from freerock_bench.methods.problem import Problem, Solution
from freerock_bench.naming import what_is_wrong
from freerock_bench.scenes import scenes
from freerock_bench.timing import interleaved
from freerock_bench.truths import place

pytestmark = pytest.mark.slow

TIME = np.arange(0, 0.6, 1e-3)
for name in figures.__all__:
    import_module(f"freerock_bench.figures.{name}")


@pytest.mark.parametrize("name", figures.__all__)
def test_a_study_is_one_module_with_one_function_and_so_is_its_figure(name):
    run = inspect.signature(import_module(f"freerock_bench.{name}").run)
    assert [(each.name, each.default) for each in run.parameters.values()] == [("size", "full")]
    draw = inspect.signature(getattr(figures, name).draw)
    assert list(draw.parameters) == ["frame", *(["page"] if name == "stability" else []), "labels"]


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


@pytest.mark.parametrize("name", ["speed_accuracy", "model_cost"])
def test_figures(name, request, tmp_path):
    frame = request.getfixturevalue({"speed_accuracy": "speeds", "model_cost": "choices"}[name])
    drawn, data = getattr(figures, name).draw(frame)
    _saved(drawn, data, tmp_path, name)
    assert len(data) == len(frame)


def test_each_page_of_the_atlas_is_a_figure(cells, tmp_path):
    n_cells = 0
    for page in figures.stability.PAGES:
        drawn, data = figures.stability.draw(cells, page)
        _saved(drawn, data, tmp_path, page)
        assert drawn.get_size_inches()[1] < 10  # of a sheet of paper
        n_cells += len(data)
    assert n_cells == len(cells)


def _saved(drawn, data, tmp_path, name):
    save(drawn, data, tmp_path / name)
    assert (tmp_path / f"{name}.pdf").stat().st_size > 5000
    assert (tmp_path / f"{name}.png").stat().st_size > 10000
    assert len(pd.read_csv(tmp_path / f"{name}.csv")) == len(data)


def test_every_start_reaches_the_global_minimum():
    frame = success.run("small")
    assert set(frame["model"]) == set(PAPER_MODELS)
    assert (frame["reached"] | frame["reported"]).all()
    figure, data = figures.success.draw(frame)
    assert len(figure.axes) == 3 and len(data) == len(frame)


def test_wrong_inputs_are_within_what_is_stated_of_them():
    frame = pd.DataFrame([row for case in (("caliper", 1), ("rule", 4)) for row in inputs.campaign(case)])
    assert (frame["u_total"] > frame["stderr"]).all()
    assert (frame["error"].abs() < 4 * frame["u_total"]).all()
    figure, data = figures.inputs.draw(frame)
    assert len(figure.axes) == 4 and len(data) == len(frame)


def test_means_of_runs_that_scatter_are_those_of_their_truths():
    frame = pd.DataFrame([row for i in range(4) for row in scatter.record((3, 0.03, i))])
    assert (np.abs(frame["error"] - frame["error_of_truths"]) < 0.002).all()
    assert frame["inside"].mean() >= 0.5 and (frame["tau"] > 0).all() and (frame["p"] < 1e-6).all()
    alike = pd.DataFrame(scatter.record((3, 0.0, 1)))
    assert (alike["tau"] < 0.001).all() and (alike["error"].abs() < 0.002).all()
    figure, data = figures.scatter.draw(pd.concat([frame, alike]))
    assert len(figure.axes) == 2 and list(data["n_records"]) == [4, 4, 1, 1]
    assert data["rms_ratio"].iloc[:2].between(0.8, 1.2).all()


def test_large_differences_between_blocks_are_seen_and_none_seldom():
    frame = shared.run("small")
    none = frame[frame["difference"] == 0]
    assert none["seen"].mean() < 0.06 and none["seen"].max() <= 0.25  # of 20 draws each
    assert none.loc[none["unlike"] == "first", "seen_pooled"].mean() > 0.1
    assert frame.loc[frame["difference"] == 12, "seen"].min() > 0.85
    figure, data = figures.shared.draw(frame)
    assert len(figure.axes) == 2 and len(data) == len(frame)


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
    assert frame["stderr"].to_numpy() == pytest.approx(frame["bound"].to_numpy(), rel=0.3)
    over = frame["stderr"] / frame["bound"]  # each octave of the noise is known from its own rests
    assert over.groupby(frame["parameter"]).mean().to_numpy() == pytest.approx(1.0, abs=0.1)
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


@pytest.mark.parametrize("family", choice.FAMILIES)
def test_the_choice_names_the_truth(family):
    rows = [row for i in (0, 1) for row in choice._choice((family, i))]
    frame = pd.DataFrame(rows)
    asked = choice.FAMILIES[family].rivals("hunt_crossley") != ()
    assert (frame["rival"] != "").any() == asked
    far = frame[frame["distance"] > figures.choice.FAR]
    assert far["right"].all() and far["held"].all()
    assert (far["wrong"] == "").all()
    summary = figures.choice.choice_summary(frame).set_index("quantity")["share"]
    assert summary["named"] == frame["right"].mean()
    figures.choice.draw(frame)


@pytest.mark.parametrize(
    "candidate, named, wrong",
    [
        ("winkler", "winkler", ""),
        ("winkler", "", ""),
        ("winkler", "housner_width", "rigid"),
        ("housner_width", "hunt_crossley", "compliant"),
        ("winkler", "hunt_crossley_pivoting", "law"),
        ("winkler", "winkler_pivoting_width", "kinematics"),
        ("hunt_crossley_width", "hunt_crossley", "width"),
        ("hunt_crossley", "general", "larger"),
        ("hunt_crossley", "hunt_crossley_width", "larger"),
        ("hunt_crossley", "general_pivoting", "kinematics"),
        ("general", "hunt_crossley", "law"),
    ],
)
def test_in_which_way_a_name_is_wrong(candidate, named, wrong):
    assert what_is_wrong(candidate, named) == wrong


def test_the_atlas_has_every_truth_under_every_noise_on_every_block():
    cells = list(confusion.cells())
    assert len(cells) == len(set(cells)) == 7 * len(confusion.WIDTHS) * len(confusion.NOISES) * 3
    for law in LAWS:
        places = {place(cell.scene) for cell in cells if cell.law == law}
        assert len(places) == 6


def test_a_cell_of_the_atlas_and_its_figure(tmp_path):
    worn = next(c for c in confusion.cells() if c.law == "housner" and c.width_fraction == 0.85)
    pivoting = [c for c in confusion.cells() if (c.law, c.kinematics) == ("hunt_crossley", "pivoting")]
    soft = next(cell for cell in pivoting if place(cell.scene)[0] == "config3")
    frame = pd.DataFrame([row for i, cell in enumerate((worn, soft)) for row in confusion._rows((i, cell))])
    assert frame["n_runs"].tolist() == [1, 3, 1, 3]
    assert frame["named"].tolist() == ["housner_width"] * 2 + ["hunt_crossley_pivoting"] * 2
    assert frame["right"].all() and frame["held"].all() and frame["explained"].all()
    assert frame["r_error_stderrs"].abs().max() < 4 and frame["k_error_stderrs"].abs().max() < 4
    assert (frame["paper_error_percent"] < -10).sum() == 2  # k, as if the squat block were guided
    pages, data = figures.confusion.draw(frame)
    save(pages, data, tmp_path / "confusion")
    assert len(pages) == 3
    assert data["n"].sum() == len(frame) and (data["share"] == 1).all()
