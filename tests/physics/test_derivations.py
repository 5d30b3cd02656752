"""The derivations of docs/equations.md, each checked by another way than the one it was derived by."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plain_law import accelerations, contact_force, contact_intervals
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State, energy, static_depth
from freerock.models.ground import pulse
from freerock.models.housner import housner_swings
from freerock.models.laws import Foundation, Rules
from freerock.models.simulate import Solver, simulate

BLOCKS = {1: Block(0.42, 0.07, 8.67), 2: Block(0.28, 0.07, 5.84), 3: Block(0.14, 0.07, 2.98)}
RELEASE = {1: math.radians(6), 2: math.radians(10), 3: math.radians(20)}
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}

blocks = st.builds(Block, st.floats(0.05, 3), st.floats(0.05, 1), st.floats(0.1, 1e3))
laws = st.tuples(st.floats(1e5, 1e9), st.sampled_from(["winkler", "hunt_crossley"]), st.floats(0, 0.1)).map(
    lambda x: (x[0], x[0] * x[2], 0.0) if x[1] == "winkler" else (x[0], 0.0, 1e3 * x[0] * x[2])
)
states = st.tuples(
    st.floats(-0.02, 0.02), st.floats(-1, 1), st.floats(-0.6, 0.6), st.floats(-5, 5)
)  # z_cb, ż_cb, θ, θ̇
rules = st.sampled_from(["geometric", "tensionless"])
kinematics = st.sampled_from(["guided", "pivoting"])
repeatable = settings(deadline=None, derandomize=True, max_examples=25)


def slope(function, step):
    """Derivative at 0, to fourth order in the step."""
    return (8 * (function(step) - function(-step)) - function(2 * step) + function(-2 * step)) / (12 * step)


def base_points(block, state, n=4000):
    """Depth and rate at the middles of n equal strips of the base, their u and width."""
    z, v, theta, w = state
    width = 2 * block.b / n
    u = -block.b + width * (np.arange(n) + 0.5)
    return z + u * math.sin(theta), v + u * w * math.cos(theta), u, width


@given(blocks, laws, states, st.floats(-5, 5), st.floats(-5, 5), kinematics)
@repeatable
def test_equation_1_follows_from_the_lagrangian(block, law, state, x_ground, z_ground, sideways):
    """d/dt ∂L/∂q̇ - ∂L/∂q + Q = 0 by differences, in an inertial frame: ẍ_g to the left, z̈_g up."""
    z, v, theta, w = state
    m, h = block.mass_kg, block.h
    path = accelerations(
        block,
        Foundation(*law),
        State(*state),
        Rules("geometric", sideways),
        x_ground=x_ground,
        z_ground=z_ground,
    )
    force = contact_force(block, Foundation(*law), State(*state))
    held = math.copysign(block.b, theta + 0.0) if sideways == "pivoting" else 0.0

    def centre(angle):
        """Place of the centre of mass: the turned lever from the point of the base that keeps its place."""
        return held - (math.cos(angle) * held - math.sin(angle) * h)

    def lagrangian(q, q_rate, t):
        x_rate = -x_ground * t + slope(lambda s: centre(q[1] + s), 1e-3) * q_rate[1]
        depth_rate = q_rate[0] - z_ground * t + h * math.sin(q[1]) * q_rate[1]
        depth = q[0] - 0.5 * z_ground * t**2 - h * math.cos(q[1])
        kinetic = 0.5 * m * (x_rate**2 + depth_rate**2) + 0.5 * block.inertia_cm * q_rate[1] ** 2
        return kinetic + m * GRAVITY * depth

    def along(t):
        q = np.array([z + v * t + path[0] * t**2 / 2, theta + w * t + path[1] * t**2 / 2])
        return q, np.array([v + path[0] * t, w + path[1] * t])

    scale = m * (GRAVITY + np.abs(path) @ [1, h] + h * w * w) + abs(force[0])
    for i in range(2):
        unit = np.eye(2)[i]

        def momentum(t, unit=unit):
            q, q_rate = along(t)
            return slope(lambda s: lagrangian(q, q_rate + s * unit, t), 0.1)

        fall = slope(lambda s, unit=unit: lagrangian(along(0)[0] + s * unit, (v, w), 0.0), 1e-3)
        step = 1e-3 / (1 + abs(w) + math.sqrt(abs(path[1])))
        residual = slope(momentum, step) - fall + force[i]
        assert abs(residual) < 1e-6 * scale * (1, h + block.b)[i]


@given(blocks, laws, states, st.floats(-5, 5), kinematics)
@repeatable
def test_vertical_ground_acceleration_is_a_change_of_gravity(block, law, state, z_ground, sideways):
    scene = Foundation(*law), State(*state), Rules("geometric", sideways)
    expected = accelerations(replace(block, gravity_m_s2=GRAVITY + z_ground), *scene)
    assert accelerations(block, *scene, z_ground=z_ground) == pytest.approx(expected, rel=1e-12)


def test_printed_pair_is_inconsistent():
    """With the printed sign of m h z̈_g sinθ in (1b), a lift that falls freely does not cancel the weight."""
    block, theta = BLOCKS[2], math.radians(5)
    aloft = State(-0.1, 0.0, theta, 0.0)
    assert accelerations(block, Foundation(1e7), aloft, z_ground=-GRAVITY) == pytest.approx((0, 0), abs=1e-12)
    m, h, s = block.mass_kg, block.h, math.sin(theta)
    matrix = [[m, m * h * s], [m * h * s, block.inertia_base]]
    printed = np.linalg.solve(matrix, [m * GRAVITY - m * GRAVITY, m * h * GRAVITY * s + m * h * GRAVITY * s])
    assert printed[1] == pytest.approx(9.07, abs=0.01)


def printed_forces(block, k, lam, z, v, theta, w):
    """Equations (2) and (3) of Spanos et al. 2017, term by term, without their gate against flight."""
    b, s, c = block.b, math.sin(theta), math.cos(theta)
    if z - b * abs(s) >= 0:
        force = 2 * b * k * z + 2 * b * lam * z * v + 2 / 3 * b**3 * lam * w * s * c
        return force, 2 / 3 * b**3 * c * (k * s + lam * v * s + lam * z * w * c)
    sign = math.copysign(1, theta)
    one, two = b + z / (2 * s) * sign, b**2 - z**2 / (3 * s**2)
    force = 0.5 * b**2 * k * s * sign + k * z * one + 0.5 * b**2 * lam * v * s * sign + lam * z * v * one
    force += b**3 / 3 * lam * w * c * s + 0.5 * lam * z * w * c * two * sign
    moment = b**3 / 3 * k * c * s + 0.5 * k * z * c * two * sign + b**3 / 3 * lam * v * c * s
    moment += 0.5 * lam * z * v * c * two * sign + b**4 / 4 * lam * w * s * c**2 * sign
    moment += lam * z * w * c**2 / 3 * (b**3 + z**3 / (4 * s**3) * sign)
    return force, moment


@given(blocks, st.floats(1e5, 1e9), st.floats(0, 100), states)
@repeatable
def test_moments_equal_the_printed_equations_where_the_base_touches(block, k, ratio, state):
    z, _, theta, _ = state
    if z + block.b * abs(math.sin(theta)) <= 0 or abs(theta) < 0.01:
        return
    found = contact_force(block, Foundation(k, lam=ratio * k), State(*state))
    scale = contact_force(block, Foundation(k, lam=ratio * k), State(*map(abs, state)))[0]
    printed = printed_forces(block, k, ratio * k, *state)
    assert found[0] == pytest.approx(printed[0], abs=1e-10 * scale)
    assert found[1] == pytest.approx(printed[1], abs=1e-10 * scale * block.b)


def test_printed_uplift_form_pushes_a_block_in_flight():
    block, theta = BLOCKS[2], math.radians(5)
    z = -block.b * math.sin(theta) - 5e-3
    marble, state = Foundation.of(MARBLE), State(z, 0.0, theta, 0.0)
    assert printed_forces(block, MARBLE["k"], MARBLE["lambda"], *state)[0] == pytest.approx(987, abs=0.5)
    assert contact_intervals(block, marble, state) == []
    assert contact_force(block, marble, state) == (0.0, 0.0)


@given(blocks, laws, states, rules)
@repeatable
def test_interval_is_where_the_base_touches_and_pushes(block, law, state, rule):
    k, c, lam = law
    intervals = contact_intervals(block, Foundation(*law), State(*state), Rules(rule))
    assert len(intervals) <= 1
    depth, rate, u, _ = base_points(block, state, 500)
    f = k * depth + c * rate + lam * depth * rate
    touches = (depth > 0) & ((f > 0) | (rule == "geometric"))
    inside = np.zeros(u.size, bool)
    for u0, u1 in intervals:
        inside |= (u > u0) & (u < u1)
    margin = 1e-9 * (np.abs(f).max() + k * np.abs(depth).max())
    certain = (np.abs(f) > margin) & (np.abs(depth) > 1e-12)
    assert np.array_equal(inside[certain], touches[certain])


@given(blocks, laws, states, rules, kinematics)
@repeatable
def test_damping_takes_energy_out_under_both_rules(block, law, state, rule, sideways):
    """dE/dt = -∫ (c + λ z) ż² du - (springs let go) <= 0, by quadrature over strips of the base."""
    k, c, lam = law
    z, v, theta, w = state
    assume(abs(theta) > 1e-5)  # at the change of corner E has a kink
    both = Rules(rule, sideways)
    acceleration = accelerations(block, Foundation(*law), State(*state), both)

    def along(t):
        there = (z + v * t, v + acceleration[0] * t, theta + w * t, w + acceleration[1] * t)
        return float(energy(block, Foundation(k), *there, both))

    step = 1e-7
    power = slope(along, step)
    depth, rate, _, width = base_points(block, state)
    f = k * depth + c * rate + lam * depth * rate
    held = (depth > 0) & ((f > 0) | (rule == "geometric"))
    lost = width * np.sum(np.where(held, (c + lam * depth) * rate**2, 0.0))
    let_go = width * np.sum(np.where((depth > 0) & ~held, -k * depth * rate, 0.0))
    assert lost >= 0 and let_go >= 0
    scale = width * np.sum(np.where(depth > 0, np.abs(f * rate) + k * np.abs(depth * rate), 0.0))
    kinks = 4 * k * block.b * np.max(rate**2) * step
    rounding = 1e-15 * (abs(along(0)) + block.mass_kg * GRAVITY * block.R) / step
    assert power == pytest.approx(-lost - let_go, abs=2e-3 * scale + kinks + 4 * rounding)


@pytest.mark.parametrize("number", BLOCKS)
def test_weight_sinks_the_block_to_its_static_depth(number):
    block, k = BLOCKS[number], MARBLE["k"]
    for theta in (0.0, 1e-4, -0.02, RELEASE[number], -0.3):
        z = static_depth(block, Foundation(k), theta)
        force, moment = contact_force(block, Foundation(k), State(z, 0.0, theta, 0.0))
        weight = block.mass_kg * GRAVITY
        assert force == pytest.approx(weight, rel=1e-12)
        if z < block.b * abs(math.sin(theta)):
            s = abs(math.sin(theta))
            lever = block.b - math.sqrt(2 * weight / (9 * k * s))
            assert moment == pytest.approx(math.copysign(weight * lever * math.cos(theta), theta), rel=1e-12)


def guided_quarter_period(block, theta0):
    """First impact of the rigid block whose base centre stays on a vertical line, by quadrature."""
    i_cm, b, h = block.inertia_cm / block.mass_kg, block.b, block.h

    def slowness(x):
        theta = theta0 * (1 - x * x)
        inertia = i_cm + h**2 + (b * math.cos(theta)) ** 2 - b * h * math.sin(2 * theta)
        drop = GRAVITY * block.R * (math.cos(block.theta_cr - theta0) - math.cos(block.theta_cr - theta))
        return 2 * theta0 * x * math.sqrt(inertia / (2 * drop))

    return quad(slowness, 0, 1, epsabs=1e-12)[0]


@pytest.mark.parametrize("number", BLOCKS)
def test_stiff_limit_is_the_guided_block_and_not_housners(number):
    block, theta0 = BLOCKS[number], RELEASE[number]
    limit = guided_quarter_period(block, theta0)
    late = []
    for k in (1e9, 1e10, 1e11):
        found = simulate(
            "hunt_crossley", block, {"k": k, "lambda": 19 * k}, np.array([0, 0.5]), theta0=theta0
        )
        late.append(found.impacts[0] / limit - 1)
    assert late[0] < 0.02
    assert np.array(late[1:]) / late[:-1] == pytest.approx(0.1**0.5, rel=0.08)
    housner = housner_swings(block, 1.0, theta0, until=0.1).impact_time[0]
    assert limit / housner - 1 == pytest.approx({1: -0.0089, 2: -0.0220, 3: -0.0786}[number], abs=1e-4)


def test_guided_block_follows_from_equation_1():
    """Base on the right corner, z_cb = -b sinθ: the corner's force eliminated from (1a) and (1b)."""
    block, theta, w = BLOCKS[3], 0.25, 1.7
    m, b, h, s, c = block.mass_kg, block.b, block.h, math.sin(theta), math.cos(theta)

    def unbalanced(turn):
        depth_acceleration = -b * (turn * c - w * w * s)
        force = m * (GRAVITY - depth_acceleration - h * (w * w * c + turn * s))
        return block.inertia_base * turn + force * b * c + m * h * (depth_acceleration - GRAVITY) * s

    turn = -unbalanced(0.0) / (unbalanced(1.0) - unbalanced(0.0))
    inertia = block.inertia_cm + m * (h**2 + (b * c) ** 2 - b * h * math.sin(2 * theta))
    inertia_slope = -m * (b**2 * math.sin(2 * theta) + 2 * b * h * math.cos(2 * theta))
    expected = (-m * GRAVITY * (b * c - h * s) - 0.5 * inertia_slope * w * w) / inertia
    assert turn == pytest.approx(expected, rel=1e-12)


@given(blocks)
@repeatable
def test_housners_restitution_keeps_the_angular_momentum_about_the_new_corner(block):
    """Angular momentum of a grid of point masses that turns about one corner, seen from the other."""
    n = 40
    x, y = np.meshgrid((np.arange(n) + 0.5) / n * block.width_m, (np.arange(n) + 0.5) / n * block.height_m)
    x_new = x - block.width_m
    before = np.sum(x_new * x + y * y)
    after = np.sum(x_new**2 + y * y)
    assert before / after == pytest.approx(block.restitution_housner, abs=2e-3)


@given(blocks, st.floats(0.05, 0.95), st.floats(0.1, 0.99))
@repeatable
def test_swing_times_by_quadrature(block, share, r):
    """Half a swing lasts ∫ dφ / (p √(2 (cos φ_peak - cos φ))); energies fall by r²."""
    theta0 = share * block.theta_cr
    swings = housner_swings(block, r, theta0, until=3 / block.p)
    for peak, half in zip(swings.peak[:3], (swings.impact_time - swings.peak_time)[:3], strict=False):

        def slowness(x, peak=peak):
            # θ = θ_peak (1 - x²) takes the root singularity away
            theta = peak * (1 - x * x)
            gap = math.sin(block.theta_cr - (peak + theta) / 2) * math.sin((peak - theta) / 2)
            return 2 * peak * x / (2 * block.p * math.sqrt(gap)) if x else peak_limit(peak)

        def peak_limit(peak):
            return math.sqrt(2 * peak / math.sin(block.theta_cr - peak)) / block.p

        assert half == pytest.approx(quad(slowness, 0, 1, epsabs=0, epsrel=1e-11)[0], rel=1e-9)
    cosine = np.cos(block.theta_cr - swings.peak) - math.cos(block.theta_cr)
    assert cosine[1:] == pytest.approx(r**2 * cosine[:-1], rel=1e-9)


@pytest.mark.parametrize("number", BLOCKS)
def test_closed_form_of_the_motion_against_an_integrator(number):
    """φ'' = p² sinφ step by step, stopped at φ = θ_cr and sent back with r times the rate."""
    block, r = BLOCKS[number], 0.87
    time = np.linspace(0, 1.2, 241)

    def impact(t, state):
        return state[0] - block.theta_cr

    impact.terminal, impact.direction = True, 1
    expected = np.full((2, time.size), np.nan)
    start, state, sign = 0.0, [block.theta_cr - RELEASE[number], 0.0], 1
    while start < time[-1]:
        swing = solve_ivp(
            lambda t, y: [y[1], block.p**2 * math.sin(y[0])],
            (start, time[-1]),
            state,
            events=impact,
            dense_output=True,
            rtol=1e-11,
            atol=1e-13,
        )
        here = (time >= start) & (time <= swing.t[-1])
        phi, rate = swing.sol(time[here])
        expected[:, here] = sign * (block.theta_cr - phi), -sign * rate
        start, state, sign = swing.t[-1], [block.theta_cr, -r * swing.y[1, -1]], -sign
    found = simulate("housner", block, {"r": r}, time, theta0=RELEASE[number])
    assert found.theta == pytest.approx(expected[0], abs=1e-9)
    assert found.theta_rate == pytest.approx(expected[1], abs=1e-7)


@given(blocks, st.floats(0.2, 0.9))
@repeatable
def test_rest_comes_after_a_geometric_series_of_swings(block, r):
    swings = housner_swings(block, r, 1e-4 * block.theta_cr)
    last = 2 * (swings.impact_time[0] - swings.peak_time[0]) * r
    assert swings.rest_time == pytest.approx(swings.impact_time[0] + last / (1 - r), rel=1e-3)


def test_froude_scaling_of_the_law():
    """Lengths by s, times by √s, masses by s³: k scales as s, c as s^1.5, λ as s^0.5, motions agree."""
    block, scale = BLOCKS[2], 5.0
    big = replace(
        block,
        height_m=scale * block.height_m,
        width_m=scale * block.width_m,
        mass_kg=scale**3 * block.mass_kg,
    )
    time = np.linspace(0, 2, 400)
    for model, parameters, powers in (
        ("winkler", {"k": 6.77e6, "c": 2.17e4}, {"k": 1.0, "c": 1.5}),
        ("hunt_crossley", MARBLE, {"k": 1.0, "lambda": 0.5}),
    ):
        scaled = {name: value * scale ** powers[name] for name, value in parameters.items()}
        small = simulate(model, block, parameters, time, theta0=0.17, solver=Solver(1e-10)).theta
        large = simulate(model, big, scaled, time * math.sqrt(scale), theta0=0.17, solver=Solver(1e-10)).theta
        assert large == pytest.approx(small, abs=1e-8)


@pytest.mark.parametrize("side", [1, -1])
def test_housners_block_on_moving_ground(side):
    """Moments about the corner, by cross products of the levers of the turned block, until the impact."""
    block, amplitude = BLOCKS[2], 6.0
    motion = pulse("sine", 0.4, x=side * amplitude, z=2.0)

    def state_rate(t, state):
        theta, rate = state
        sigma = math.copysign(1, theta) if theta else side
        turn = np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
        lever = turn @ [-sigma * block.b, block.h]  # from the corner to the centre of mass: right, up
        x_ground, z_ground = motion(np.array([t]))[:, 0]
        force = [x_ground, -(GRAVITY + z_ground)]  # per mass: weight and inertial forces
        clockwise = lever[1] * force[0] - lever[0] * force[1]
        return [rate, clockwise / (block.inertia_cm / block.mass_kg + block.R**2)]

    lift = brentq(
        lambda t: (
            side * motion(np.array([t]))[0, 0] * block.h - (GRAVITY + motion(np.array([t]))[1, 0]) * block.b
        ),
        1e-6,
        0.1,
    )
    time = np.linspace(lift, 0.4, 50)
    expected = solve_ivp(state_rate, (lift, 0.4), [0.0, 0.0], t_eval=time, rtol=1e-11, atol=1e-13).y
    found = simulate("housner", block, {"r": 0.9}, time, base_excitation=motion, solver=Solver(1e-10))
    same = time < (found.impacts[0] if len(found.impacts) else 1.0)
    assert same.sum() > 10 and side * found.theta[same][-1] > 0
    assert found.theta[same] == pytest.approx(expected[0][same], abs=1e-9)
    assert found.theta_rate[same] == pytest.approx(expected[1][same], abs=1e-7)


@pytest.mark.parametrize("debonding", ["geometric", "tensionless"])
@pytest.mark.parametrize(
    ("model", "parameters"), [("winkler", {"k": 6.77e6, "c": 2.17e4}), ("hunt_crossley", MARBLE)]
)
def test_error_follows_the_tolerance(model, parameters, debonding):
    time, theta0 = np.linspace(0, 3, 301), RELEASE[2]
    exact, *found = (
        simulate(
            model, BLOCKS[2], parameters, time, theta0=theta0, rules=Rules(debonding), solver=Solver(rtol)
        ).theta
        for rtol in (1e-12, 1e-6, 1e-8, 1e-10)
    )
    errors = [np.abs(theta - exact).max() / theta0 for theta in found]
    assert np.all(np.array(errors) < [1e-5, 1e-7, 1e-9])
