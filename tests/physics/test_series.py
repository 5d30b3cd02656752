"""Free rocking by Taylor series: the series against the law, the motion against the kernel's."""

import math
from pathlib import Path

import numpy as np
import plain_law
import pytest
import recurrences
from hypothesis import assume, given
from hypothesis import strategies as st

from freerock.models import block_on_bed, kernel, series, series_sums
from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State
from freerock.models.ground import tilted
from freerock.models.laws import LAWS, Foundation, Law, Rules
from freerock.models.simulate import Solver, simulate
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock.virtual_lab.published import TABLE_2

BLOCK = Block(0.28, 0.07, 5.84)
integrated = series.integrate_series
NO_GROUND = np.empty(0), np.empty((0, 10))
NO_SCATTER = np.empty(0), np.empty((0, 5))
SCENES = [
    (CONFIGURATIONS[block][0], CONFIGURATIONS[block][1], model, TABLE_2[foundation][model])
    for block in CONFIGURATIONS
    for foundation in TABLE_2
    for model in ("winkler", "hunt_crossley")
]

laws = st.tuples(st.floats(1e5, 1e8), st.floats(0, 0.02), st.floats(0, 20)).map(
    lambda x: (x[0], x[0] * x[1], x[0] * x[2])
)
angles = st.floats(0.01, 0.4)
rates = st.tuples(st.floats(-0.3, 0.3), st.floats(-3, 3))
kinematics = st.sampled_from(["guided", "pivoting"])
grounds = st.floats(-0.5, 0.5)  # m/s²: bases that lean by up to 3°


def coefficients(fill, law, state, sideways, ground):
    """Of the depth of the centre of mass and of the angle, as `fill` has them."""
    k, c, lam, b, h, inertia, g, corner, *_ = Foundation(*law).constants(BLOCK, sideways == "pivoting")
    z, v, theta, w = state
    a = math.copysign(corner, theta)
    s, cos = math.sin(theta), math.cos(theta)
    found = np.empty((2, series.ORDER + 1))
    fill(
        *found, z - h * cos, v + h * s * w, theta, w, s, cos, a, (k, c, lam, b, h, inertia - h * h, g, ground)
    )
    return found


def satisfies_the_law(fill, law, state, sideways, longest, ground=0.0):
    """Whether the motion has, a little later, the accelerations that the plain formulas require there."""
    found = coefficients(fill, law, state, sideways, ground)
    # the last terms are still small then beside what the series can reach
    last = np.max(np.abs(found[:, -2:]), axis=0) + 1e-300
    x = min(longest, *(1e-14 * BLOCK.b / last) ** (1 / np.array([series.ORDER - 1, series.ORDER])))
    depth, theta = (np.polynomial.Polynomial(row) for row in found)
    angle, w, h = theta(x), theta.deriv()(x), BLOCK.h
    s, cos = math.sin(angle), math.cos(angle)
    later = State(depth(x) + h * cos, depth.deriv()(x) - h * s * w, angle, w)
    assume(fill is not series_sums.on_corner or later.z + BLOCK.b * s > 0 > later.z - BLOCK.b * s)
    rules = Rules(kinematics=sideways)
    expected = plain_law.accelerations(BLOCK, Foundation(*law), later, rules, x_ground=ground)
    turning = theta.deriv(2)(x)
    falling = depth.deriv(2)(x) - h * (s * turning + cos * w * w)
    force, _ = plain_law.contact_force(BLOCK, Foundation(*law), later)
    scale = abs(force) / BLOCK.mass_kg + GRAVITY
    assert falling == pytest.approx(expected[0], abs=1e-7 * scale)
    assert turning == pytest.approx(expected[1], abs=1e-7 * scale / BLOCK.b)


def test_the_recurrences_are_those_that_are_written_out():
    text = Path(series_sums.__file__).read_text(encoding="utf-8")
    assert text == recurrences.written()


@given(laws, angles, st.floats(0.05, 0.95), rates, kinematics, grounds)
def test_series_on_a_corner_satisfies_the_law(law, theta, share, moving, sideways, ground):
    """The right corner is down, and the base in contact along a share of it."""
    state = (BLOCK.b * math.sin(theta) * (2 * share - 1), moving[0], theta, moving[1])
    satisfies_the_law(series_sums.on_corner, law, state, sideways, 1e-3, ground)


@given(laws, st.floats(-0.01, 0.01), st.floats(0, 3e-3), rates, kinematics, grounds)
def test_series_on_the_whole_base_satisfies_the_law(law, theta, deeper, moving, sideways, ground):
    assume(abs(theta) > 1e-4)
    state = (BLOCK.b * abs(math.sin(theta)) + deeper + 1e-3, 0.1 * moving[0], theta, 0.1 * moving[1])
    satisfies_the_law(series_sums.on_whole_base, law, state, sideways, 1e-5, ground)


@given(angles, rates, kinematics, grounds)
def test_series_in_the_air_satisfies_the_law(theta, moving, sideways, ground):
    state = (-BLOCK.b * math.sin(theta) - 0.01, moving[0], theta, moving[1])
    satisfies_the_law(series_sums.in_air, (1e6, 0.0, 0.0), state, sideways, 1e-3, ground)


def by_the_kernel(block, model, parameters, theta0, time, rtol, sideways="guided", tilt=0.0):
    """θ, z_cb, ż_cb, θ̇ and the impacts of the same scene, by Runge and Kutta."""
    foundation = Foundation.of(parameters)
    theta, others = np.empty(time.size), np.empty((time.size, 3))
    start = block_on_bed.static_depth(block, foundation, theta0), 0.0, theta0, 0.0
    base = tilted(tilt, time[-1])
    *_, impacts = kernel.integrate(
        foundation.constants(block, sideways == "pivoting"),
        -1.0,
        False,
        start,
        time,
        *((base.breaks, base.coefficients) if tilt else NO_GROUND),
        rtol * abs(theta0),
        1_000_000,
        *NO_SCATTER,
        theta,
        others,
    )
    return theta, *others.T, impacts


@pytest.mark.parametrize(
    ("law", "by_series"),
    [*((name, law.is_foundation) for name, law in LAWS.items()), ("new", False)],
)
def test_only_a_law_whose_row_says_so_is_simulated_by_series(monkeypatch, law, by_series):
    """A new law may have the parameters of one that `series` knows."""
    monkeypatch.setitem(LAWS, "new", Law("New", ("k", "lambda")))
    seen = []
    monkeypatch.setattr(series, "integrate_series", lambda *given: seen.append(1) or integrated(*given))
    numbers = {"r": 0.9, "k": 1e6, "c": 1e3, "lambda": 1e6}
    time = np.linspace(0.0, 0.1, 11)
    simulate(law, BLOCK, {name: numbers[name] for name in LAWS[law].parameters}, time, theta0=0.1)
    assert bool(seen) is by_series


def test_a_touch_that_begins_and_ends_within_a_step_is_found():
    """z_cb = x - 20 x² - 1e-4 m of an upright block: under the ground from 1e-4 s to 0.05 s, nearly."""
    depth, angle = np.zeros((2, series.ORDER + 1))
    depth[:3] = -1e-4 - BLOCK.h, 1.0, -20.0
    law = (1.0, 0.0, 0.0, BLOCK.b, BLOCK.h, 0.01, GRAVITY, 0.0)
    entry, way_out = (0.5 * (1 + side * math.sqrt(1 - 80 * 1e-4)) / 20 for side in (-1, 1))
    step = way_out + 1e-3
    end = step - 20 * step**2 - 1e-4
    found = series._crossing(depth, angle, step, 1.0, False, 1.0, end, 1 - 40 * step, 1e-15, law)
    assert found == pytest.approx(entry, rel=1e-9)
    # over before it begins: the depth only comes near the ground
    depth[0] -= 0.02
    assert (
        series._crossing(depth, angle, step, 1.0, False, 1.0, end - 0.02, 1 - 40 * step, 1e-15, law)
        == math.inf
    )


@pytest.mark.parametrize("sideways", ["guided", "pivoting"])
@pytest.mark.parametrize(("block", "theta0", "model", "parameters"), SCENES)
def test_motion_is_that_of_the_kernel(block, theta0, model, parameters, sideways):
    time = np.arange(4000) / 2000
    exact = by_the_kernel(block, model, parameters, theta0, time, 1e-13, sideways)
    rules = Rules(kinematics=sideways)
    found = simulate(model, block, parameters, time, theta0=theta0, rules=rules, solver=Solver(1e-8))
    seen = found.theta, found.z_cb, found.z_cb_rate, found.theta_rate
    kept, rough = (
        [np.max(np.abs(one - other)) for one, other in zip(motion[:4], exact, strict=False)]
        for motion in (seen, by_the_kernel(block, model, parameters, theta0, time, 1e-8, sideways))
    )
    assert np.all(np.array(kept) < 4 * np.array(rough) + 1e-12)
    assert found.impacts[:8] == pytest.approx(exact[4][:8], abs=1e-7)
    assert found.statistics["evaluations"] < 3000


def test_a_stiff_law_on_a_base_that_leans_goes_on_implicitly():
    block, time = CONFIGURATIONS["config2"][0], np.arange(1000) / 1000
    law = {"k": 1e11, "c": 3.2e8}
    base = tilted(0.01, 1.0)
    found = simulate("winkler", block, law, time, theta0=0.17, base_excitation=base, solver=Solver(1e-8))
    theta, *_ = by_the_kernel(block, "winkler", law, 0.17, time, 1e-10, tilt=0.01)
    assert found.statistics["implicit"] > 100
    assert found.theta == pytest.approx(theta, abs=1e-8)


@pytest.mark.parametrize("model", ["winkler", "hunt_crossley"])
def test_left_is_the_mirror_of_right(model):
    block, theta0, _ = CONFIGURATIONS["config2"]
    time = np.arange(4000) / 2000
    right, left = (
        simulate(model, block, TABLE_2["marble"][model], time, theta0=side * theta0) for side in (1, -1)
    )
    assert np.array_equal(right.theta, -left.theta) and np.array_equal(right.z_cb_rate, left.z_cb_rate)
    assert np.array_equal(right.impacts, left.impacts)


def test_error_is_as_small_however_stiff_the_bed():
    """Of Hunt and Crossley, whose fast oscillation is never damped out: k from 1e6 to 1e11 N/m²."""
    block, time = CONFIGURATIONS["config2"][0], np.arange(1000) / 1000
    for k in (1e6, 1e8, 1e10, 1e11):
        law = {"k": k, "lambda": 19 * k}
        loose, tight = (
            simulate("hunt_crossley", block, law, time, theta0=0.17, solver=Solver(rtol)).theta
            for rtol in (1e-6, 1e-11)
        )
        assert np.max(np.abs(loose - tight)) < 2e-6


def test_a_stiff_law_goes_on_implicitly_from_where_the_series_stop():
    block, time = CONFIGURATIONS["config2"][0], np.arange(2000) / 1000
    law = {"k": 1e11, "c": 3.2e8}
    found = simulate("winkler", block, law, time, theta0=0.17, solver=Solver(1e-8))
    theta, *_, impacts = by_the_kernel(block, "winkler", law, 0.17, time, 1e-10)
    assert found.statistics["implicit"] > 100
    assert found.theta == pytest.approx(theta, abs=1e-8)
    assert found.impacts[:8] == pytest.approx(impacts[:8], abs=1e-6)


def test_all_impacts_of_a_long_rattle_are_told():
    """More than there is room for at first."""
    block = CONFIGURATIONS["config3"][0]
    found = simulate("hunt_crossley", block, {"k": 5e7, "lambda": 1e6}, np.arange(60_000) / 1000, theta0=0.02)
    assert len(found.impacts) > 256 and np.all(np.diff(found.impacts) > 0)
    near = np.interp(found.impacts, found.time, found.theta)
    assert np.max(np.abs(near)) < 1e-3 * np.max(np.abs(found.theta)) + 1e-6


@given(st.floats(1e-30, 1e300))
def test_a_root_is_hardly_too_large(x):
    for n in (series.ORDER - 1, series.ORDER - 2):
        assert x ** (1 / n) * (1 - 1e-12) <= series._root(x, n) <= 1.062 * x ** (1 / n)


def test_both_dampings_at_once():
    """A law with c and λ: the general one."""
    assert LAWS["general"].is_foundation
    block, time = CONFIGURATIONS["config1"][0], np.arange(2000) / 1000
    law = {"k": 7e6, "c": 1e4, "lambda": 5e7}
    found = simulate("general", block, law, time, theta0=0.1, solver=Solver(1e-9))
    theta, *_ = by_the_kernel(block, "general", law, 0.1, time, 1e-12)
    assert found.theta == pytest.approx(theta, abs=1e-8)
