"""The tools of a laboratory: how they are asked, timed and compared."""

import math
import sys

import numpy as np
import pytest

from freerock_bench import peers, speed_accuracy
from freerock_bench.document import BEGIN, END, renew
from freerock_bench.methods.by_name import METHODS, freerock
from freerock_bench.methods.housner import housner_eventless
from freerock_bench.speed_accuracy import Scale, markdown, problem_of

TIME = np.arange(0, 0.605, 0.01)
DRIVER = """
from driver import answer, places, steps, substeps

def prepare(scene, setting):
    assert places(scene, 2)[0] == [-scene["b"] / 2, scene["b"] / 2]
    if setting["step_s"] > 1:
        raise ValueError("too long a step")
    return lambda: [scene["theta0"] - i * substeps(scene, setting["step_s"]) for i in range(steps(scene) + 1)]

answer(prepare)
"""


@pytest.fixture(scope="module")
def own():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peers, "installed", lambda: False)
        return speed_accuracy.run("small", None, 1)


@pytest.fixture
def fake(tmp_path, monkeypatch):
    """A driver in this environment."""
    (tmp_path / "driver.py").write_text((peers.DRIVERS / "driver.py").read_text(encoding="utf-8"))
    (tmp_path / "fake.py").write_text(DRIVER)
    monkeypatch.setattr(peers, "DRIVERS", tmp_path)
    monkeypatch.setattr(peers, "PYTHON", type(tmp_path)(sys.executable))


def test_a_driver_answers_each_setting(fake):
    problem = problem_of("winkler", "geometric")
    fine, failed = peers.solve("fake", problem, [{"step_s": 0.005}, {"step_s": 2.0}], TIME[:4], 2)
    assert fine.theta == pytest.approx(problem.theta0 - 2 * np.arange(4))
    assert 0 <= fine.seconds < 1
    assert (failed.theta.size, failed.message) == (0, "ValueError: too long a step")
    assert math.isnan(failed.seconds)


def test_freerock_is_within_its_tolerance_of_the_golden_solutions(own):
    rows = own[own["method"] == "freerock"]
    assert list(rows["model"].unique()) == ["housner", "winkler", "hunt_crossley"]
    assert rows[rows["setting"].isin(["rtol 1e-08", "closed form"])]["epsilon"].max() < 1e-15
    assert (own["outcome"] == "completed").all()
    assert set(own["kind"]) == {"freerock", "library", "time stepping"}


@pytest.mark.parametrize("model", ["winkler", "hunt_crossley"])
def test_an_error_is_the_shift_that_it_makes_in_a_fit(model):
    scale = Scale(problem_of(model, "geometric"), TIME)
    share = 1e-4
    k = scale.problem.parameters["k"]
    as_if = scale._theta({"k": k * (1 + share)}, 0.0) - scale.true
    unit = scale.stderrs(scale.jacobian[:, 0])  # of 1 N/m²
    assert scale.stderrs(as_if) == pytest.approx(unit * share * k, rel=2e-3)
    # what another freed number makes up for shifts nothing
    assert scale.stderrs(1e-4 * scale.jacobian[:, 2]) < 1e-6 * scale.stderrs(as_if)


def test_the_table_has_a_row_for_every_tool(own, tmp_path):
    lines = markdown(own).splitlines()
    assert len(lines) == 2 + own.groupby(["model", "method"]).ngroups
    path = tmp_path / "benchmark.md"
    begin, end = BEGIN.format("engines"), END.format("engines")
    path.write_text(f"before {begin}old{end} after")
    renew(path, "engines", markdown(own))
    assert path.read_text().startswith(f"before {begin}| law | tool |")
    assert path.read_text().endswith(f"{end} after")


# Methods


def error(found, true):
    return float(np.linalg.norm(found.theta - true) / np.linalg.norm(true))


@pytest.mark.parametrize("method", ["RK4", "Newmark"])
def test_time_stepping_converges(method):
    problem = problem_of("hunt_crossley", "geometric")
    true = freerock(problem, TIME, 1e-12).theta
    one, other = (error(METHODS[method](problem, TIME, step), true) for step in (4e-4, 1e-4))
    assert other < 1e-3
    order = math.log(one / other) / math.log(4)
    assert order > (2.5 if method == "RK4" else 1.7)


def test_impacts_that_are_not_sought_cost_the_order():
    problem = problem_of("housner", "")
    true = freerock(problem, TIME, 1e-8).theta
    errors = [error(housner_eventless(problem, TIME, step), true) for step in (1e-3, 1e-4, 1e-5)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] > 1e-6
