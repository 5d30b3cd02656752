"""The studies in their small size, and their figures."""

import inspect
import math
from importlib import import_module

import numpy as np
import pandas as pd
import pytest

from freerock.figures.style import save
from freerock_bench import evidence, figures, stability
from freerock_bench.campaigns import HELD_OUT
from freerock_bench.methods.problem import Solution
from freerock_bench.stability import COLUMNS, STATES, judge
from freerock_bench.timing import interleaved

for name in figures.__all__:
    import_module(f"freerock_bench.figures.{name}")


@pytest.mark.parametrize("name", evidence.STUDIES)
def test_a_study_is_one_module_with_its_seed_run_and_table(name):
    study = import_module(f"freerock_bench.{name}")
    assert isinstance(study.SEED, int)
    assert [*inspect.signature(study.run).parameters] == ["size", "folder", "cores"]
    assert [*inspect.signature(study.markdown).parameters] == ["frame"]


@pytest.mark.parametrize("name", figures.__all__)
def test_a_figure_is_one_module_with_one_function(name):
    draw = inspect.signature(getattr(figures, name).draw)
    assert list(draw.parameters) == ["frame", *(["page"] if name == "stability" else [])]


def test_interleaved_times_every_call_and_keeps_the_results():
    order = []
    calls = [lambda i=i: order.append(i) or i for i in range(3)]
    timed = interleaved(calls, rounds=2)
    assert [result for result, *_ in timed] == [0, 1, 2]
    assert [runs for *_, runs in timed] == [2, 2, 2]
    assert order == [0, 1, 2] * 3


@pytest.fixture(scope="module")
def cells():
    return stability.run("small", None, 1)


def test_atlas(cells):
    assert list(cells.columns) == COLUMNS
    assert set(cells["state"]) <= set(STATES)
    assert set(cells["map"]) == {"stiffness", "step", "release"}
    assert (cells.loc[cells["method"] == "freerock", "state"] == "converged").all()
    assert stability.markdown(cells).count("\n") > 3
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


def test_right_intervals_lie_on_the_diagonal_and_the_selected_candidate_is_ringed():
    rng = np.random.default_rng(1)
    rows = {"case": "σ_r 1 %", "parameter": "k", "truth": 1.0, "value": 1 + 0.1 * rng.standard_normal(4000)}
    figure, data = figures.coverage.draw(pd.DataFrame(rows | {"u": 0.1}))
    central = data[data["normal"].abs() < 2]
    np.testing.assert_allclose(central["error_over_u"], central["normal"], atol=0.15)
    of = {"case": "σ_r 1 %", "test": "a"}
    fits = [(0.5, "housner"), (0.1, "winkler"), (0.02, "hunt_crossley"), (0.04, "hunt_crossley")]
    left_out = [of | {"parameter": HELD_OUT, "value": value, "note": model} for value, model in fits]
    left_out.append(of | {"parameter": "true law first", "note": "hunt_crossley"})
    figure, data = figures.parsimony.draw(pd.DataFrame(left_out))
    ring = next(line for line in figure.axes[0].lines if line.get_label() == "selected")
    assert (list(ring.get_xdata()), list(ring.get_ydata())) == ([2], [3.0])
