"""Methods to compare with: the same law, the same motion, and what each does at its limit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from freerock.models.block import Block
from freerock_bench.methods.by_name import METHODS, freerock
from freerock_bench.methods.foundation import plain_right_hand_side, right_hand_side
from freerock_bench.methods.housner import housner_events, housner_linearised
from freerock_bench.methods.problem import Problem, errors

BLOCK = Block(0.28, 0.07, 5.84)
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}
HC = Problem("hunt_crossley", BLOCK, MARBLE, math.radians(10))
WINKLER = Problem("winkler", BLOCK, {"k": 6.77e6, "c": 2.17e4}, math.radians(10))
TIME = np.arange(0, 0.6, 1e-3)
# CyRK compiles for half a minute: only the full studies run it
IN_PROCESS = [name for name in METHODS if not name.startswith("CyRK")]


def setting(method, fine=False):
    if method in ("RK4", "Newmark"):
        return 2e-5 if fine else 1e-4
    return 1e-9 if fine else 1e-6


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    scene=st.sampled_from([HC, WINKLER]),
    debonding=st.sampled_from(["geometric", "tensionless"]),
    state=st.tuples(
        st.floats(-5e-3, 5e-3),
        st.floats(-2.0, 2.0),
        st.one_of(st.just(0.0), st.floats(-0.25, 0.25)),
        st.floats(-5, 5),
    ),
)
def test_the_two_right_hand_sides_are_the_same_law(scene, debonding, state):
    scene = replace(scene, debonding=debonding)
    compiled = right_hand_side(0.0, np.array(state), scene.law)
    plain = plain_right_hand_side(scene)(0.0, np.array(state))
    np.testing.assert_allclose(compiled, plain, rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize("scene", [HC, WINKLER], ids=lambda scene: scene.model)
@pytest.mark.parametrize("method", IN_PROCESS)
def test_every_method_finds_the_same_motion(method, scene):
    true = METHODS["SciPy DOP853, numba"](scene, TIME, 1e-12)
    found = METHODS[method](scene, TIME, setting(method))
    assert found.outcome == "completed"
    assert found.evaluations > 0
    assert errors(found.theta, true.theta)[0] < 1e-7


@pytest.mark.parametrize("method", IN_PROCESS)
def test_every_method_stops_at_its_limit(method):
    found = METHODS[method](HC, TIME, setting(method, fine=True), 60)
    assert found.outcome == "step_limit"
    assert np.isnan(found.theta[-1])


@pytest.mark.parametrize("method, order", [("RK4", 4), ("Newmark", 2)])
def test_fixed_steps_have_their_order_before_the_first_impact(method, order):
    time = np.array([0.0, 0.2])
    true = METHODS["SciPy DOP853, numba"](HC, time, 1e-13).theta[-1]
    error = [abs(METHODS[method](HC, time, step).theta[-1] - true) for step in (2e-3, 1e-3, 5e-4)]
    assert np.log2(error[0] / error[2]) / 2 == pytest.approx(order, abs=0.4)


def test_linearised_housner():
    """Quarter period of configuration 2 from 10°: 0.268633 s linearised, 0.268884 s exact."""
    time = np.linspace(0, 0.5, 500_001)
    scene = Problem("housner", BLOCK, {"r": 0.958}, math.radians(10))
    methods = {"linearised": (housner_linearised, 0.0), "freerock": (freerock, 1e-10)}
    methods["SciPy DOP853, events"] = (housner_events, 1e-10)
    crossing = {
        name: time[np.argmax(solve(scene, time, rtol).theta < 0)] for name, (solve, rtol) in methods.items()
    }
    assert crossing["linearised"] == pytest.approx(0.268633, abs=2e-6)
    assert crossing["freerock"] == pytest.approx(0.268884, abs=2e-6)
    assert crossing["SciPy DOP853, events"] == pytest.approx(0.268884, abs=2e-6)
    # the slenderer the block, the better the small angle, wherever the record ends
    slender = replace(scene, block=Block(2.8, 0.07, 58.4), theta0=math.radians(1))
    for span in np.linspace(2, 3, 9):
        long = np.arange(0, span, 1e-3)
        linear, exact = (solve(slender, long, 1e-8).theta for solve in (housner_linearised, freerock))
        assert errors(linear, exact)[0] < 1e-5
