"""A block that bounces: closed forms, Housner's block as a limit, a scheme without modes, energy."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.models.bouncing import RIGHT, bounce, standing_on
from freerock.models.ground import accelerogram
from freerock.models.housner import housner_motion, housner_swings
from freerock.models.simulate import Solver, simulate, simulate_fitted

SLENDER = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
SQUARE = Block(height_m=0.06, width_m=0.06, mass_kg=0.05)


def energy(block, state):
    """Over the mass [m²/s²]."""
    _, z, _, vx, vz, rate = state.T
    return 0.5 * (vx**2 + vz**2 + block.inertia_cm / block.mass_kg * rate**2) + GRAVITY * z


def test_a_slender_block_without_bounce_is_housners():
    time, theta0 = np.linspace(0, 1.6, 1601), math.radians(10)
    found = bounce(SLENDER, 0.0, 5.0, standing_on(SLENDER, RIGHT, theta0, 0.0), time)
    swings = housner_swings(SLENDER, SLENDER.restitution_housner, theta0)
    assert found.impact_time_s == pytest.approx(swings.impact_time[: len(found.impact_time_s)], abs=1e-9)
    assert found.theta == pytest.approx(housner_motion(swings, time, theta0, 0.0)[0], abs=1e-9)


@pytest.mark.parametrize(("friction", "ratio"), [(0.0, -0.4), (50.0, 1 - 0.75 * 1.4)])
def test_a_square_turns_back_over_the_same_corner(friction, ratio):
    """At e times its rate where it slips; where it sticks, the corner it stood on leaves the ground."""
    start = standing_on(SQUARE, RIGHT, 1e-6, -10.0)
    start = (*start[:3], 0.0, *start[4:]) if friction == 0 else start
    found = bounce(SQUARE, 0.4, friction, start, np.linspace(0, 1e-6, 11))
    assert len(found.impact_time_s) == 1
    assert found.state[-1, 5] / found.state[0, 5] == pytest.approx(ratio, abs=5e-5)


def test_a_corner_below_the_centre_of_mass_bounces_as_a_point():
    fall, e = 0.02, 0.6
    start = (0.0, SQUARE.R + fall, SQUARE.theta_cr, 0.0, 0.0, 0.0)
    found = bounce(SQUARE, e, 0.3, start, np.linspace(0, 0.2, 201))
    first = math.sqrt(2 * fall / GRAVITY)
    assert found.impact_time_s[:2] == pytest.approx([first, first * (1 + 2 * e)], abs=1e-9)


def test_a_block_that_slides_flat_stops_by_coulombs_law():
    found = bounce(SQUARE, 0.0, 0.2, (0.0, SQUARE.h, 0.0, 0.5, 0.0, 0.0), np.array([1.0]))
    assert found.state[0, 0] == pytest.approx(0.5**2 / (2 * 0.2 * GRAVITY), abs=1e-12)


@pytest.mark.parametrize("friction", [0.1, 0.35, 2.0])
def test_a_scheme_without_modes_or_events_moves_alike(friction):
    start = standing_on(SQUARE, RIGHT, math.radians(25), -4.0)
    time = np.linspace(0, 0.13, 27)
    found = bounce(SQUARE, 0.4, friction, start, time)
    stepped = time_stepped(SQUARE, 0.4, friction, start, time, 4e-6)
    assert len(found.impact_time_s) >= 1
    assert np.degrees(found.theta) == pytest.approx(np.degrees(stepped[:, 2]), abs=0.05)
    assert found.state[:, 0] == pytest.approx(stepped[:, 0], abs=5e-5)


def time_stepped(block, e, mu, start, time, step):
    """States by Moreau's scheme: one set of impulses per step, from velocities alone."""
    q, v = np.array(start[:3]), np.array(start[3:])
    inverse = np.array([1.0, 1.0, block.mass_kg / block.inertia_cm])
    out, t = [], 0.0
    for until in time:
        while t < until - step / 2:
            v = v - [0, GRAVITY * step, 0]
            _, z, theta = q + 0.5 * step * v
            rows = []
            for side in (-block.b, block.b):
                rx = side * math.cos(theta) - block.h * math.sin(theta)
                rz = -side * math.sin(theta) - block.h * math.cos(theta)
                if z + rz <= 0:
                    rows.append((np.array([0, 1, -rx]), np.array([1, 0, rz])))
            if rows:
                v = struck(v, rows, e, mu, inverse)
            q = q + step * v
            t += step
        out.append([*q, *v])
    return np.array(out)


def struck(v, rows, e, mu, inverse):
    """Velocities after the impulses of some corners, by Gauss-Seidel sweeps on their normal and tangent."""
    before = [min(normal @ v, 0.0) for normal, _ in rows]
    before = [each if each < -1e-3 else 0.0 for each in before]
    push, drag = np.zeros(len(rows)), np.zeros(len(rows))
    for _ in range(100):
        last = v
        for i, (normal, tangent) in enumerate(rows):
            wanted = push[i] - (normal @ v + e * before[i]) / (normal**2 @ inverse)
            v = v + (max(wanted, 0.0) - push[i]) * inverse * normal
            push[i] = max(wanted, 0.0)
            wanted = drag[i] - tangent @ v / (tangent**2 @ inverse)
            kept = min(max(wanted, -mu * push[i]), mu * push[i])
            v = v + (kept - drag[i]) * inverse * tangent
            drag[i] = kept
        if np.abs(v - last).max() < 1e-13:
            break
    return v


def test_any_start_comes_to_an_end_and_never_gains_energy():
    draw, time = np.random.default_rng(7), np.linspace(0, 0.4, 401)
    for _ in range(300):
        block = (SQUARE, SLENDER)[int(draw.integers(2))]
        start = standing_on(block, RIGHT, draw.uniform(0.02, 0.9) * block.theta_cr, draw.uniform(-25, 10))
        lifted = (start[0], start[1] + draw.uniform(0, 0.02), *start[2:])
        found = bounce(block, draw.uniform(0, 0.7), 10 ** draw.uniform(-2, 2), lifted, time)
        gain = np.nanmax(np.diff(energy(block, found.state)), initial=0.0)
        assert gain < 2e-4 * GRAVITY * block.R  # a corner slower than QUIET is brought to rest


@pytest.mark.parametrize(
    ("e", "mu", "lift", "told"),
    [
        (1.0, 0.3, 0.0, "restitution < 1"),
        (0.3, -1.0, 0.0, "friction of 0 or more"),
        (0.3, 0.3, -0.01, "start higher"),
    ],
)
def test_impossible_input_is_refused(e, mu, lift, told):
    x, z, *others = standing_on(SQUARE, RIGHT, 0.3, 0.0)
    with pytest.raises(FreerockError, match=told):
        bounce(SQUARE, e, mu, (x, z + lift, *others), [0.1])


STICKS = {"e": 0.0, "mu": 50.0}


def test_the_public_door_gives_housners_block_as_a_limit():
    time, theta0 = np.linspace(-0.1, 1.6, 1701), -math.radians(10)
    rigid = simulate("housner", SLENDER, {"r": SLENDER.restitution_housner}, time, theta0=theta0)
    found = simulate("bouncing", SLENDER, STICKS, time, theta0=theta0)
    for name in ("theta", "theta_rate", "z_cb", "z_cb_rate"):
        assert getattr(found, name) == pytest.approx(getattr(rigid, name), abs=2e-8), name
    away = np.abs(rigid.theta) > 1e-4
    np.testing.assert_array_equal(found.contact[away], rigid.contact[away])
    assert found.impacts == pytest.approx(rigid.impacts[: len(found.impacts)], abs=1e-9)
    assert len(found.impacts) >= 5 and found.outcome == "completed"


@pytest.mark.parametrize("block", [SLENDER, replace(SLENDER, com_offset_m=2e-3)])
def test_on_a_base_that_leans_it_is_housners_block_too(block):
    """Which is integrated there, by other code."""
    time = np.linspace(0, 0.5, 501)  # to the second impact
    values = {"theta0": math.radians(8), "tilt": 0.01}
    rigid = simulate_fitted("housner", block, values | {"r": 0.9}, time)
    found = simulate_fitted("bouncing", block, values | STICKS, time)
    first = int(np.flatnonzero(rigid < 0)[0])
    assert found[:first] == pytest.approx(rigid[:first], abs=1e-7)


def test_a_block_slides_down_a_steep_base():
    tilt, mu = 0.3, 0.2
    start = 0.0, SQUARE.h, 0.0, 0.0, 0.0, 0.0
    found = bounce(SQUARE, 0.0, mu, start, np.array([0.4]), tilt)
    assert found.state[0, 0] == pytest.approx(0.5 * GRAVITY * (math.sin(tilt) - mu * math.cos(tilt)) * 0.4**2)
    assert bounce(SQUARE, 0.0, 0.4, start, np.array([0.4]), tilt).state[0, 0] == 0


def test_a_slender_block_whose_corner_bounces_flies():
    time = np.linspace(0, 0.4, 4001)
    found = simulate("bouncing", SLENDER, {"e": 0.5, "mu": 0.3}, time, theta0=math.radians(10))
    stretch = slice(*np.searchsorted(time, found.impacts[:2]))
    assert stretch.stop - stretch.start > 30 and np.all(found.contact[stretch] == 2)
    assert np.ptp(found.theta_rate[stretch]) < 1e-12
    centre = SLENDER.h * np.cos(found.theta) - found.z_cb  # its height
    falls = np.diff(centre[stretch], 2) / (time[1] - time[0]) ** 2
    assert falls == pytest.approx(-GRAVITY, rel=1e-5)


@pytest.mark.parametrize(
    ("theta0", "soon", "at_last"),
    [(0.3, "completed", "at_rest"), (0.0, "at_rest", "at_rest"), (0.9, "completed", "overturned")],
)
def test_how_a_motion_ends(theta0, soon, at_last):
    for until_s, outcome in ((0.05, soon), (5.0, at_last)):
        time = np.linspace(0, until_s, 31)
        found = simulate("bouncing", SQUARE, {"e": 0.3, "mu": 0.3}, time, theta0=theta0)
        assert found.outcome == outcome
        assert np.isnan(found.theta[-1]) == (outcome == "overturned")


def test_a_corner_that_bounces_for_ever_meets_the_limit_of_steps():
    scene = "bouncing", SQUARE, {"e": 0.9, "mu": 0.3}, np.linspace(0, 4, 41)
    found = simulate(*scene, theta0=0.4, solver=Solver(max_steps=5))
    assert found.outcome == "step_limit" and np.isnan(found.theta[-1])
    assert simulate(*scene, theta0=0.4).outcome == "at_rest"


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"e": 1.0, "mu": 0.3}, "not below 1"),
        ({"e": -0.1, "mu": 0.3}, "not a non-negative number"),
        ({"e": math.nan, "mu": 0.3}, "not a non-negative number"),
        ({"e": 0.3, "mu": math.inf}, "not a positive number"),
        ({"e": 0.3}, "missing"),
    ],
)
def test_what_the_door_refuses(parameters, told):
    with pytest.raises(FreerockError, match=told):
        simulate("bouncing", SQUARE, parameters, [0.0, 0.1], theta0=0.2)


def test_ground_that_moves_is_refused():
    pulse = accelerogram(np.linspace(0, 1, 11), np.zeros(11))
    scene = "bouncing", SQUARE, {"e": 0.3, "mu": 0.3}, [0.0, 0.1]
    with pytest.raises(FreerockError, match="ground at rest only"):
        simulate(*scene, theta0=0.2, base_excitation=pulse)
