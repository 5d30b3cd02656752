"""The public door: symmetry, energy, outcomes, ground motion, many parameter sets, bad arguments."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from beds import beds, starts
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_law import accelerations
from scipy.integrate import solve_ivp

from freerock.errors import FreerockError
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State, energy, static_depth
from freerock.models.ground import accelerogram, pulse, tilted
from freerock.models.laws import CANDIDATES, Foundation, Rules
from freerock.models.simulate import Solver, simulate, simulate_fitted

BLOCKS = {1: Block(0.42, 0.07, 8.67), 2: Block(0.28, 0.07, 5.84), 3: Block(0.14, 0.07, 2.98)}
ALPHA = {1: math.radians(6), 2: math.radians(10), 3: math.radians(20)}
WINKLER, MARBLE = {"k": 6.77e6, "c": 2.17e4}, {"k": 6.88e6, "lambda": 1.30e8}
LAWS = [("housner", {"r": 0.93}), ("winkler", WINKLER), ("hunt_crossley", MARBLE)]
RULES = ["geometric", "tensionless"]
AEROSTOP = {"winkler": {"k": 4.50e6, "c": 4.05e4}, "hunt_crossley": {"k": 2.86e6, "lambda": 8.16e7}}


@pytest.mark.parametrize("model", AEROSTOP)
def test_tensionless_motion_of_an_independent_integration(model):
    path = Path(__file__).parent / "data/tensionless.csv"
    reference = np.genfromtxt(path, delimiter=",", names=True)
    time, theta = reference["time_s"].copy(), reference[f"theta_{model}_rad"]
    for rtol, bound in ((1e-6, 1e-9), (1e-8, 1e-13), (1e-11, 1e-18)):
        found = simulate(
            model,
            BLOCKS[3],
            AEROSTOP[model],
            time,
            theta0=ALPHA[3],
            rules=Rules("tensionless"),
            solver=Solver(rtol),
        )
        assert epsilon_theta(time, found.theta, theta) < bound


def moving(parameters, theta0, theta_rate0):
    """State of configuration 2 thrown from its static depth."""
    depth = static_depth(BLOCKS[2], Foundation.of(parameters), theta0)
    return State(depth, 0.0, theta0, theta_rate0)


@given(beds, starts, st.sampled_from(RULES))
@settings(max_examples=25)
def test_mirror_symmetry(bed, start, rule):
    model, parameters = bed
    time = np.linspace(0, 0.6, 61)
    one, other = (
        simulate(
            model,
            BLOCKS[2],
            parameters,
            time,
            theta0=moving(parameters, sign * start[0], sign * start[1]),
            rules=Rules(rule),
        )
        for sign in (1, -1)
    )
    assert one.theta == pytest.approx(-other.theta, abs=1e-9, nan_ok=True)
    assert one.z_cb == pytest.approx(other.z_cb, abs=1e-10, nan_ok=True)
    assert np.mean(np.where(one.contact == 2, 2, -one.contact) == other.contact) > 0.95
    assert one.outcome == other.outcome


@given(beds, starts, st.sampled_from(RULES))
@settings(max_examples=25)
def test_damping_never_adds_energy(bed, start, rule):
    model, parameters = bed
    time = np.linspace(0, 0.6, 601)
    found = simulate(
        model,
        BLOCKS[2],
        parameters,
        time,
        theta0=moving(parameters, *start),
        rules=Rules(rule),
        solver=Solver(1e-9),
    )
    level = energy(
        BLOCKS[2], Foundation.of(parameters), found.z_cb, found.z_cb_rate, found.theta, found.theta_rate
    )
    level = level[np.isfinite(level)]
    assert np.diff(level).max(initial=0) <= 1e-7 * level[0] + 1e-12


@pytest.mark.parametrize("number", BLOCKS)
def test_energy_without_damping_drifts_by_less_than_1e_8_in_100_s(number):
    time = np.linspace(0, 100, 5001)
    found = simulate(
        "winkler", BLOCKS[number], {"k": 6.88e6, "c": 0.0}, time, theta0=ALPHA[number], solver=Solver(1e-10)
    )
    level = energy(
        BLOCKS[number], Foundation(6.88e6), found.z_cb, found.z_cb_rate, found.theta, found.theta_rate
    )
    assert found.outcome == "completed"
    assert np.abs(level / level[0] - 1).max() <= 1e-8


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("model", "parameters"), LAWS)
def test_a_frame_that_accelerates_upward_is_a_change_of_gravity(model, parameters, rule):
    """z̈_g constant is g + z̈_g, in the law and in the static depth at the start."""
    block, time = BLOCKS[2], np.linspace(0, 1.0, 201)
    lift = accelerogram([0.0, 2.0], z=[3.0, 3.0])
    heavier = replace(block, gravity_m_s2=GRAVITY + 3.0)
    start = 0.17
    if model != "housner":
        start = State(static_depth(heavier, Foundation.of(parameters), 0.17), 0.0, 0.17, 0.0)
    options = {"rules": Rules(rule), "solver": Solver(1e-10)}
    moved = simulate(model, block, parameters, time, theta0=start, base_excitation=lift, **options)
    still = simulate(model, heavier, parameters, time, theta0=0.17, **options)
    assert moved.theta == pytest.approx(still.theta, abs=1e-8)
    assert len(still.impacts) > 1


@pytest.mark.parametrize(
    ("model", "values", "shape"),
    [
        ("housner", {"r": 0.93}, {}),
        ("housner", {"r": 0.93, "tilt": 2e-3}, {"com_offset_m": 1e-3}),
        ("winkler", {"k": 5e6, "c": 3e4, "tilt": 2e-3}, {}),
        ("hunt_crossley", {"k": 5e6, "lambda": 1e8, "edge_radius": 1e-3}, {}),
        ("hunt_crossley_pivoting", {"k": 5e6, "lambda": 1e8, "edge_radius": 1e-3, "tilt": 2e-3}, {}),
        ("general", {"k": 5e6, "c": 1e4, "lambda": 1e8}, {"com_height_m": 0.15}),
        ("general_pivoting", {"k": 5e6, "c": 1e4, "lambda": 1e8}, {"inertia_kg_m2": 0.05}),
    ],
)
def test_gravity_is_a_scale_of_time_and_force(model, values, shape):
    """Under 4 g all is twice as fast, if beds are 4 times as stiff, and their dampings twice as large."""
    law, rules = CANDIDATES[model].law, Rules(kinematics=CANDIDATES[model].kinematics)
    times = {"k": 4, "c": 2, "lambda": 2}
    faster = {name: value * times.get(name, 1) for name, value in values.items()}
    block, time = Block(0.28, 0.07, 5.84, **shape), np.arange(0, 1.5, 1e-3)
    heavy = replace(block, gravity_m_s2=4 * GRAVITY)
    slow = simulate_fitted(law, block, {**values, "theta0": 0.15}, time, rules=rules, solver=Solver(1e-10))
    fast = simulate_fitted(
        law, heavy, {**faster, "theta0": 0.15}, time / 2, rules=rules, solver=Solver(1e-10)
    )
    assert np.ptp(slow) > 0.2
    np.testing.assert_allclose(fast, slow, atol=1e-7)
    assert heavy.p == pytest.approx(2 * block.p) and heavy.weight == pytest.approx(4 * block.weight)


@pytest.mark.parametrize(("model", "parameters"), LAWS)
def test_impacts_are_where_theta_changes_its_sign(model, parameters):
    time = np.linspace(0, 2, 2001)
    found = simulate(model, BLOCKS[2], parameters, time, theta0=0.17)
    assert len(found.impacts) >= 4
    signs = np.sign(found.theta[np.searchsorted(time, found.impacts) - 1])
    assert np.array_equal(signs, (-1.0) ** np.arange(len(found.impacts)))
    there = simulate(model, BLOCKS[2], parameters, found.impacts, theta0=0.17)
    assert np.abs(there.theta).max() < 1e-12


@pytest.mark.parametrize("tilt", [2e-3, -1e-3])
@pytest.mark.parametrize("change", [{"edge_radius_m": 2e-3}, {"com_offset_m": 1e-3}, {}])
def test_on_a_base_that_leans_a_block_comes_to_rest_where_it_balances(change, tilt):
    """Steps end with the motion, however long the record; the bed then carries the block."""
    block = replace(BLOCKS[2], **change)
    law = ("winkler", {"k": 7e6, "c": 3e5}) if change else ("hunt_crossley", MARBLE)
    steps = []
    for until in (20, 400):
        time = np.linspace(0, until, 201)
        found = simulate(law[0], block, law[1], time, theta0=0.1, base_excitation=tilted(tilt, until))
        steps.append(found.statistics["steps"])
        last = State(found.z_cb[-1], found.z_cb_rate[-1], found.theta[-1], found.theta_rate[-1])
        x, z = tilted(tilt, until)([1.0])[:, 0]
        left = accelerations(block, Foundation.of(law[1]), last, x_ground=x, z_ground=z)
        # a thousandth of 1e-9 rad, times the squared frequency of a block on its bed
        assert (
            last[1] == last[3] == 0
            and last.theta * (block.h * tilt + block.e) > 0
            and np.abs(left).max() < 2e-5
        )
    assert steps[1] <= steps[0] + 1
    times = np.linspace(0, 2, 201)
    coarse, fine = (
        simulate(
            *law[:1], block, law[1], times, theta0=0.1, base_excitation=tilted(tilt, 2), solver=Solver(rtol)
        )
        for rtol in (1e-8, 1e-11)
    )
    assert coarse.theta == pytest.approx(fine.theta, abs=2e-8)


def test_without_damping_there_is_no_rest():
    found = simulate("winkler", BLOCKS[2], {"k": 3e6, "c": 0.0}, np.linspace(0, 10, 101), theta0=1e-5)
    assert found.outcome == "completed" and np.abs(found.theta[-20:]).max() > 5e-6


@given(
    st.floats(3, 13),
    st.floats(-6, 2),
    st.sampled_from(["winkler", "hunt_crossley"]),
    st.sampled_from([1, 2, 3]),
    st.sampled_from(RULES),
)
@settings(max_examples=25)
def test_any_law_ends_in_a_named_outcome(log_k, log_ratio, model, number, rule):
    damping = 10 ** (log_k + log_ratio)
    parameters = {"k": 10**log_k, "c" if model == "winkler" else "lambda": damping}
    time = np.linspace(0, 1, 11)
    found = simulate(
        model,
        BLOCKS[number],
        parameters,
        time,
        theta0=ALPHA[number],
        rules=Rules(rule),
        solver=Solver(1e-5, max_steps=50_000),
    )
    assert found.outcome in ("completed", "at_rest", "overturned", "step_limit")
    assert np.isfinite(found.theta[-1]) == (found.outcome in ("completed", "at_rest"))


RECORD = np.random.default_rng(1).standard_normal((2, 51))
MOTIONS = {
    "linear": accelerogram(np.arange(51) * 0.02, x=4 * RECORD[0], z=2 * RECORD[1]),
    "sine": pulse("sine", 0.5, x=3.2, z=1.0, start_s=0.1),
    "cosine": pulse("cosine", 0.5, x=-2.8, z=1.0, start_s=0.1),
}


@pytest.mark.parametrize(
    ("moved", "law", "rule"),  # each pair of two of them
    [(name, law, RULES[(i + j) % 2]) for i, name in enumerate(MOTIONS) for j, law in enumerate(LAWS[1:])],
)
def test_beds_on_moving_ground_against_scipy(moved, law, rule):
    motion, (model, parameters) = MOTIONS[moved], law
    block, time = BLOCKS[2], np.linspace(0, 0.8, 41)
    bed = Foundation.of(parameters)
    found = simulate(model, block, parameters, time, base_excitation=motion, rules=Rules(rule))
    state = [static_depth(block, bed, 0.0), 0.0, 0.0, 0.0]
    edges = np.unique(np.append(motion.breaks[(motion.breaks > 0) & (motion.breaks < 0.8)], [0.0, 0.8]))
    expected = np.zeros(time.size)
    for start, end in pairwise(edges):

        def rates(t, y, start=start, end=end):
            # the ground of this segment, from its inner side at both ends
            x, z = motion(np.clip(t, start + 1e-12, end - 1e-12))
            a, turn = accelerations(block, bed, State(*y), Rules(rule), x_ground=float(x), z_ground=float(z))
            return y[1], a, y[3], turn

        solution = solve_ivp(
            rates, (start, end), state, "LSODA", dense_output=True, rtol=1e-8, atol=[1e-11, 1e-9, 1e-10, 1e-8]
        )
        here = (time > start) & (time <= end)
        expected[here] = solution.sol(time[here])[2]
        state = solution.y[:, -1]
    followed = np.isfinite(found.theta)
    assert followed.sum() > 25 and np.abs(expected[followed]).max() > 1e-3
    assert found.theta[followed] == pytest.approx(expected[followed], abs=2e-6)


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("model", "parameters"), LAWS[1:])
def test_upright_block_dropped_flat_bounces_without_turning(model, parameters, rule, kinematics):
    block, time = BLOCKS[2], np.linspace(0, 0.4, 201)
    k, c, lam = parameters["k"], parameters.get("c", 0.0), parameters.get("lambda", 0.0)

    def rates(_, y):
        f = (k * y[0] + (c + lam * y[0]) * y[1]) * (y[0] > 0)
        f = max(f, 0.0) if rule == "tensionless" else f
        return y[1], GRAVITY - 2 * block.b * f / block.mass_kg

    expected = solve_ivp(rates, (0, 0.4), [-5e-3, 0.0], "DOP853", time, rtol=1e-11, atol=1e-13).y[0]
    dropped, both = State(-5e-3, 0.0, 0.0, 0.0), Rules(rule, kinematics)
    found = simulate(model, block, parameters, time, theta0=dropped, rules=both, solver=Solver(1e-10))
    assert np.all(found.theta == 0) and set(found.contact) == {0, 2}
    assert found.z_cb == pytest.approx(expected, abs=2e-9)


def test_housner_lifts_when_the_ground_exceeds_the_slope_of_the_block():
    block = BLOCKS[2]
    threshold = GRAVITY * math.tan(block.theta_cr)
    time = np.linspace(0, 3, 3001)
    ramp = accelerogram([0.0, 2.0, 2.02], x=[0.0, -1.02 * threshold, 0.0])
    found = simulate("housner", block, {"r": 0.5}, time, base_excitation=ramp)
    lifted = time[np.flatnonzero(found.theta)[0]]
    assert lifted == pytest.approx(2 / 1.02, abs=2e-3) and lifted > 2 / 1.02
    # the ground accelerates to the right, the block tilts to the left
    assert found.theta[np.argmax(np.abs(found.theta))] < 0
    assert found.outcome == "at_rest" and found.theta[-1] == 0
    below = accelerogram([0.0, 1.0, 2.0], x=[0.0, 0.999 * threshold, 0.0])
    assert np.all(simulate("housner", block, {"r": 0.5}, time, base_excitation=below).theta == 0)


def test_ground_motion_is_what_was_given():
    time = np.array([0.0, 0.5, 1.5])
    motion = accelerogram(time, x=[1.0, 3.0, -1.0], z=[0.0, 1.0, 0.0])
    assert motion([-1.0, 0.25, 1.0, 9.0]) == pytest.approx(np.array([[0, 2, 1, 0], [0, 0.5, 0.5, 0]]))
    half = pulse("half_sine", 2.0, x=3.0, start_s=1.0)
    assert half([0.9, 1.5, 1.99, 2.01])[0] == pytest.approx(
        [0, 3 * math.sin(math.pi / 2), 3 * math.sin(0.99 * math.pi), 0]
    )


@pytest.mark.parametrize(
    ("change", "where", "what"),
    [
        ({"model": "winkeler"}, "model", "winkeler"),
        ({"parameters": {"k": 1e6}}, "parameters.c", "missing"),
        ({"parameters": {"k": -1e6, "c": 1e4}}, "parameters.k", "-1000000.0"),
        ({"parameters": {"k": 0.0, "c": 1e4}}, "parameters.k", "0.0"),
        ({"parameters": {"k": 1e6, "c": math.nan}}, "parameters.c", "nan"),
        ({"model": "housner", "parameters": {"r": 1.2}}, "parameters.r", "above 1"),
        ({"time": [0.0, 2.0, 1.0]}, "time", "not an increasing"),
        ({"time": [0.0, math.nan]}, "time", "finite"),
        ({"theta0": math.inf}, "theta0", "the start is inf rad"),
        ({"rules": Rules("sticky")}, "debonding", "sticky"),
        ({"rules": Rules(kinematics="sliding")}, "kinematics", "sliding"),
        ({"solver": Solver(0.0)}, "rtol", "0.0"),
    ],
)
def test_bad_arguments_are_told_in_one_line(change, where, what):
    arguments = {"model": "winkler", "parameters": WINKLER, "time": [0.0, 1.0], "theta0": 0.1} | change
    with pytest.raises(FreerockError) as error:
        simulate(
            arguments.pop("model"), BLOCKS[2], arguments.pop("parameters"), arguments.pop("time"), **arguments
        )
    assert error.value.where == where and what in error.value.what
    assert "\n" not in str(error.value)
