"""The studies in their small size, and their figures."""

import inspect
import math
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module

import numpy as np
import pandas as pd
import pytest

from freerock.figures.declared import declared
from freerock.figures.style import save
from freerock.models.laws import LAWS, PAPER_MODELS
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import identify_run
from freerock_bench import confusion, figures, harness, stability, success
from freerock_bench.confusion import answer
from freerock_bench.methods.problem import Solution
from freerock_bench.stability import COLUMNS, STATES, judge
from freerock_bench.timing import interleaved
from freerock_bench.truths import place, record
from freerock_bench.virtual_run import SEED

pytestmark = pytest.mark.slow

for name in figures.__all__:
    import_module(f"freerock_bench.figures.{name}")


@pytest.mark.parametrize("name", [*figures.__all__, "bits", "success", "kinds"])
def test_a_study_is_one_module_with_one_function(name):
    run = inspect.signature(import_module(f"freerock_bench.{name}").run)
    assert [(each.name, each.default) for each in run.parameters.values()] == [("size", "full")]


@pytest.mark.parametrize("name", figures.__all__)
def test_a_figure_is_one_module_with_one_function_and_its_caption(name):
    assert declared(f"freerock_bench.figures.{name}")["caption"].endswith(".")
    draw = inspect.signature(getattr(figures, name).draw)
    assert list(draw.parameters) == ["frame", *(["page"] if name == "stability" else [])]


def test_interleaved_times_every_call_and_keeps_the_results():
    order = []
    calls = [lambda i=i: order.append(i) or i for i in range(3)]
    timed = interleaved(calls, rounds=2)
    assert [result for result, *_ in timed] == [0, 1, 2]
    assert [runs for *_, runs in timed] == [2, 2, 2]
    assert order == [0, 1, 2] * 3


@pytest.fixture
def in_one_process(monkeypatch):
    """Cases of a study are tried here: another process imports for longer. Those of `kinds` have others."""
    monkeypatch.setattr(harness, "ProcessPoolExecutor", lambda *_: ThreadPoolExecutor(1))


@pytest.fixture(scope="module")
def cells():
    return stability.run("small")


def test_atlas(cells):
    assert list(cells.columns) == COLUMNS
    assert set(cells["state"]) <= set(STATES)
    assert set(cells["map"]) == {"stiffness", "step", "release"}
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


def _saved(drawn, data, tmp_path, name):
    save(drawn, data, tmp_path / name)
    assert (tmp_path / f"{name}.pdf").stat().st_size > 5000
    assert (tmp_path / f"{name}.png").stat().st_size > 10000
    assert len(pd.read_csv(tmp_path / f"{name}.csv")) == len(data)


def test_every_start_reaches_the_global_minimum(in_one_process):
    frame = success.run("small")
    assert set(frame["model"]) == set(PAPER_MODELS) and list(frame)[:8] == harness.NUMBERS
    assert (frame["reached"] | frame["reported"]).all()
    assert len(frame) == 4 + 5 * 2 * 2  # r of each; k and a damping of each
    data = harness.coverage(frame)
    assert data["z"].max() < 5 and (data["error"] < 5).all()


def made_up(case, parameter, value, stderr, u=None):
    return harness.number_row(case, parameter, -2.0, value, stderr, u)


def test_a_number_is_inside_1_96_of_its_uncertainty_and_of_its_standard_error():
    row = made_up("a", "k", -2.3, 0.1, 0.2)
    assert (row["inside_stderr"], row["inside"], row["u"]) == (False, True, 0.2)
    assert made_up("a", "k", -2.2, 0.1)["inside_stderr"] is False  # 2.0 standard errors
    assert made_up("a", "k", -2.195, 0.1)["inside"] is True
    unknown = made_up("a", "k", -2.0, math.nan)
    assert math.isnan(unknown["value"]) and math.isnan(unknown["inside"])


def test_coverage_counts_shares_and_medians_by_case_and_number():
    rows = [
        made_up("a", "k", -2.3, 0.1, 0.2),
        made_up("a", "k", -2.1, 0.1),
        made_up("b", "r", -2.5, 0.1, 0.2),
    ]
    frame = pd.DataFrame([*rows, made_up("b", "r", 9.0, math.nan)])
    known = harness.coverage(frame).set_index("case")
    assert known["n"].to_dict() == {"a": 2, "b": 1}
    assert known["inside_stderr"].to_dict() == {"a": 50, "b": 0}
    assert known["inside"].to_dict() == {"a": 100, "b": 0}
    assert known.loc["a", ["error", "stderr", "u"]].tolist() == pytest.approx([10, 5, 7.5])
    assert known["z"].tolist() == pytest.approx([math.hypot(1.5, 1) / math.sqrt(2), 2.5])
    table = harness.Study(lambda size: [], lambda case: [], []).markdown(frame).splitlines()
    assert table[2] == "| a | k | 2 | 10 % | 5 % | 7.5 % | 50 % | 100 % |" and len(table) == 4


def test_the_atlas_has_every_truth_under_every_noise_on_every_block():
    cells = list(confusion.cells())
    assert len(cells) == len(set(cells)) == 7 * len(confusion.WIDTHS) * len(confusion.NOISES) * 3
    for law in (name for name, row in LAWS.items() if row.by_default):
        places = {place(cell.scene) for cell in cells if cell.law == law}
        assert len(places) == 6


def test_a_cell_of_the_atlas_and_its_figure(tmp_path):
    worn = next(c for c in confusion.cells() if c.law == "housner" and c.width_fraction == 0.85)
    pivoting = [c for c in confusion.cells() if (c.law, c.kinematics) == ("hunt_crossley", "pivoting")]
    soft = next(cell for cell in pivoting if place(cell.scene)[0] == "config3")
    frame = pd.DataFrame([row for i, cell in enumerate((worn, soft)) for row in confusion._rows((i, cell))])
    assert frame["named"].tolist() == ["housner_width", "hunt_crossley_pivoting"]
    assert frame["right"].all() and frame["held"].all() and frame["explained"].all()
    assert frame["r_error_stderrs"].abs().max() < 4 and frame["k_error_stderrs"].abs().max() < 4
    assert (frame["paper_error_percent"] < -10).sum() == 1  # k, as if the squat block were guided
    figure, data = figures.confusion.draw(frame)
    _saved(figure, data, tmp_path, "confusion")
    assert data["n"].sum() == len(frame) and (data["share"] == 1).all()
    wrong = frame["law"].eq("hunt_crossley")
    (ax,) = figures.confusion.draw(frame.assign(right=frame["right"] & ~wrong))[0].axes
    assert len(ax.get_yticks()) == 1 and [text.get_text() for text in ax.texts] == ["1"]  # one truth of two


def test_a_law_three_steps_from_the_papers_is_found_where_all_on_the_way_are_given_up():
    """Both dampings, pivoting on a narrower contact: each hypothesis on the way leaves thirty times the noise
    of the first swings."""
    (cell,) = [
        each
        for each in confusion.cells()
        if (each.law, each.kinematics, each.noise) == ("general", "pivoting", "2 ms")
        and (each.width_fraction, each.scene) == (0.95, 2)
    ]
    number = [*confusion.cells()].index(cell)
    truth, motion = record(cell.truth, np.random.default_rng([SEED, 5, number]))
    assert answer(cell.candidate, truth, identify_run(truth.nominal, motion, BY_DEFAULT))["right"]
