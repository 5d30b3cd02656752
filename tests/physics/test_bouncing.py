"""A block that bounces: closed forms, Housner's block as a limit, a scheme without modes, energy."""

import math

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.models.bouncing import RIGHT, bounce, standing_on
from freerock.models.housner import housner_motion, housner_swings

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
