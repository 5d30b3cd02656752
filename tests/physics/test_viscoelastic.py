"""A bed that relaxes, a standard linear solid: q̇ = (c/τ) ż - q/τ beside k z."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.models.contact import Foundation, energy, static_depth
from freerock.models.ground import pulse, tilted
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate, simulate_theta
from freerock.models.viscoelastic import CELLS, integrate_viscoelastic, nodes

BLOCK = Block(0.28, 0.07, 5.84)
OFFSET = replace(BLOCK, com_height_m=0.13, com_offset_m=2e-3)
K, THETA0 = 6.88e6, 0.12
NOTHING = np.empty(0), np.empty((0, 14))
KINEMATICS = ["guided", "pivoting"]


def on_a_bed(damping_s, relaxes_s, k=K):
    return {"k": k, "c": k * damping_s, "tau": relaxes_s}


def moved(parameters, time, block=BLOCK, rtol=1e-8, theta0=THETA0, kinematics="guided"):
    rules, solver = Rules(kinematics=kinematics), Solver(rtol)
    return simulate("viscoelastic", block, parameters, time, theta0=theta0, rules=rules, solver=solver)


def of_cells(parameters, time, cells, block=BLOCK, rtol=1e-11, pivots=False, theta0=THETA0):
    """θ on a bed of so many cells."""
    foundation, theta = Foundation.of(parameters), np.empty(time.size)
    start = static_depth(block, foundation, theta0), 0.0, theta0, 0.0
    law = foundation.constants(block, pivots)
    scene = start, time, *NOTHING, rtol * theta0, 1_000_000, theta, np.empty((0, 3))
    element = parameters["c"] / block.mass_kg, parameters["tau"]
    integrate_viscoelastic(law, element, *scene, cells=cells)
    return theta


class Cells:
    """The same cells as they are said to be: q of each node is a state, and that of the two places between
    which q at the end of the contact lies; SciPy's DOP853, restarted at each event."""

    def __init__(self, block, parameters, cells, pivots):
        self.block, self.u = block, nodes(block.b, cells)
        self.k, self.c, self.tau = (parameters[name] for name in ("k", "c", "tau"))
        self.side = 1.0 if pivots else 0.0

    def rates(self, t, y, contact, ends, grows):
        z, v, theta, w, total, moment, *two = y[:8]
        m, b, s, cos = self.block.mass_kg, self.block.b, math.sin(theta), math.cos(theta)
        x = self.end(y) if contact else 0.0
        low, high = {"left": (-b, x), "right": (x, b), "whole": (-b, b), "": (0, 0)}[contact]
        n = [(high**i - low**i) / i for i in (1, 2, 3)]
        force = self.k * (z * n[0] + s * n[1]) + total
        couple = (self.k * (z * n[1] + s * n[2]) + moment) * cos
        lift, above = self.block.com(s, cos)
        slide, bend = above + self.side * b * s, self.side * b * cos - lift
        left = [[m, m * lift], [m * lift, self.block.inertia_cm + m * (slide**2 + lift**2)]]
        right = [m * GRAVITY - force - m * above * w**2]
        right += [m * GRAVITY * lift - couple - m * slide * bend * w**2 - lift * m * above * w**2]
        a, turn = np.linalg.solve(left, right)
        fast, q = self.c / self.tau, y[8:]
        gain = fast * (v * n[0] + w * cos * n[1]), fast * (v * n[1] + w * cos * n[2])
        if contact in ("left", "right"):
            (u0, u1), (q0, q1) = ends, two
            at_end = (q0 + (q1 - q0) * (x - u0) / (u1 - u0)) * (v + x * w * cos) / abs(s)
            gain = gain[0] + at_end, gain[1] + x * at_end
        touched = self.touched if contact else np.zeros(len(q))
        of_two = [0.0 if grows else fast * (v + u * w * cos) for u in ends]
        return [
            *(v, a, w, turn, gain[0] - total / self.tau, gain[1] - moment / self.tau),
            *(load - each / self.tau for load, each in zip(of_two, two, strict=True)),
            *(touched * fast * (v + self.u * w * cos) - q / self.tau),
        ]

    def end(self, y):
        return -y[0] / math.sin(y[2]) if y[2] else 0.0

    def solve(self, theta0, span_s):
        """Instants, and the states there, shape (n, 4)."""
        y = np.zeros(8 + len(self.u))
        y[0], y[2] = static_depth(self.block, Foundation(self.k), theta0), theta0
        self.side *= math.copysign(1.0, theta0)
        self.touched = (y[0] + self.u * math.sin(theta0) > 0).astype(float)
        t, grows, found, last = 0.0, False, [], len(self.u) - 1
        ends = self.beside(self.contact(), grows)[1]
        while t < span_s:
            contact = self.contact()
            inner, outer = self.beside(contact, grows)[0]
            watched = (0, last) if contact in ("", "whole") else (inner, outer)
            events = [self.at(node) for node in watched] + [lambda t, y: self.side * y[2] + (not self.side)]
            if contact in ("left", "right"):
                events.append(
                    lambda t, y, on=grows: (y[1] + self.end(y) * y[3] * math.cos(y[2])) * (2 * on - 1)
                )
            for event in events:
                event.terminal, event.direction = True, -1
            rates, told = self.rates, (contact, ends, grows)
            step = solve_ivp(
                lambda t, y, told=told, rates=rates: rates(t, y, *told),
                (t, span_s),
                y,
                "DOP853",
                events=events,
                rtol=1e-12,
                atol=1e-15,
                max_step=2e-3,
                dense_output=True,
            )
            found.append((t, step.t[-1], step.sol))
            t, y = step.t[-1], step.y[:, -1]
            if not step.status:
                break
            which = next(i for i, at in enumerate(step.t_events) if len(at))
            if which == 2:
                self.side = -self.side
                continue
            if which == 3:
                grows = not grows
                node, x = (inner if not grows else outer), self.end(y)
                (u0, u1), (q0, q1) = ends, y[6:8]
                y[6:8] = y[8 + node], q0 + (q1 - q0) * (x - u0) / (u1 - u0)
                ends = self.u[node], x
                continue
            before = contact
            self.touched[watched[which]] = 1 - self.touched[watched[which]]
            grows = before == "" or (grows and before != "whole")
            if self.contact() == "":
                y[4:6] = 0.0
            if self.contact() in ("left", "right"):
                # growing between the node just met and the next; shrinking from the node just left
                (inner, outer), ends = self.beside(self.contact(), grows)
                y[6:8] = y[8 + inner], y[8 + outer]
        return found

    def contact(self):
        if self.touched.all():
            return "whole"
        return "left" if self.touched[0] else "right" if self.touched[-1] else ""

    def beside(self, contact, grows):
        """The last node in contact and the first out of it, and where they are."""
        if contact not in ("left", "right"):
            return (0, 0), (0.0, 1.0)
        inner = int(self.touched.sum()) - 1 if contact == "left" else int(len(self.u) - self.touched.sum())
        outer = inner + (1 if contact == "left" else -1)
        return (inner, outer), (self.u[inner], self.u[outer])

    def at(self, node):
        sign = 2 * self.touched[node] - 1
        return lambda t, y: sign * (y[0] + self.u[node] * math.sin(y[2]))


@pytest.mark.parametrize(
    ("block", "kinematics", "relaxes_s"),  # each pair of two of them
    [
        (BLOCK, "guided", 1e-3),
        (BLOCK, "pivoting", 0.02),
        (OFFSET, "guided", 0.02),
        (OFFSET, "pivoting", 1e-3),
    ],
)
def test_an_independent_integrator_of_the_same_cells_finds_the_same_motion(block, kinematics, relaxes_s):
    parameters, pivots = on_a_bed(5e-3, relaxes_s), kinematics == "pivoting"
    spans = Cells(block, parameters, 8, pivots).solve(THETA0, 1.2)
    time = np.concatenate([np.linspace(first, last, 4)[1:] for first, last, _ in spans if last > first])
    theta = np.concatenate(
        [of(np.linspace(first, last, 4)[1:])[2] for first, last, of in spans if last > first]
    )
    found = of_cells(parameters, time, 8, block, 1e-13, pivots)
    assert np.sum(np.diff(np.sign(theta)) != 0) >= 3
    assert np.abs(found - theta).max() < 1e-10 * THETA0


@pytest.mark.parametrize(("relaxes_s", "share"), [(1e-3, 1e-8), (1e-2, 2e-5), (0.03, 3e-4), (0.1, 4e-4)])
def test_more_cells_come_to_the_bed_that_has_none(relaxes_s, share):
    """The usual cells are as near to it, relative to θ₀, over 4 s; half as many a quarter as near."""
    time, parameters = np.linspace(0, 4, 801), on_a_bed(5e-3, relaxes_s)
    fine = of_cells(parameters, time, 4 * CELLS)
    half, usual = (np.abs(of_cells(parameters, time, n) - fine).max() / THETA0 for n in (CELLS // 2, CELLS))
    assert usual < share
    assert usual < half / 3 or usual < 1e-8


@pytest.mark.parametrize("kinematics", KINEMATICS)
def test_a_bed_that_relaxes_at_once_is_winklers(kinematics):
    time, rules = np.linspace(0, 2, 401), Rules(kinematics=kinematics)
    plain = simulate("winkler", BLOCK, {"k": K, "c": 5e-3 * K}, time, theta0=THETA0, rules=rules).theta
    off = [
        np.abs(moved(on_a_bed(5e-3, each), time, kinematics=kinematics).theta - plain).max()
        for each in (1e-4, 1e-5)
    ]
    assert off[0] < 0.05 * THETA0 and off[1] < 0.12 * off[0]


def test_a_bed_that_never_relaxes_is_stiffer():
    """Stiffness k + c/τ where the bed was free at first; less where it was held, for q is zero then."""
    time, stiff = np.linspace(0, 0.5, 201), 2 * K
    free = -BLOCK.b * math.sin(THETA0)
    start = np.array([free, 0.0, THETA0, 0.0])
    scene = time, *NOTHING, 1e-12, 1_000_000
    theta, plain = np.empty(201), np.empty(201)
    law, element = Foundation(K).constants(BLOCK), (K * 1e6 / BLOCK.mass_kg, 1e6)
    integrate_viscoelastic(law, element, tuple(start), *scene, theta, np.empty((0, 3)))
    integrate_viscoelastic(
        Foundation(stiff).constants(BLOCK), (0.0, 1.0), tuple(start), *scene, plain, np.empty((0, 3))
    )
    assert np.abs(theta - plain).max() < 1e-5 * THETA0
    held = moved(on_a_bed(1e6, 1e6), time).theta
    assert np.abs(held - moved(on_a_bed(0.0, 1.0, stiff), time).theta).max() > 1e-3 * THETA0


@pytest.mark.parametrize("kinematics", KINEMATICS)
def test_without_damping_it_is_a_bed_of_springs(kinematics):
    time, rules = np.linspace(0, 2, 401), Rules(kinematics=kinematics)
    plain = simulate("winkler", BLOCK, {"k": K, "c": 0.0}, time, theta0=THETA0, rules=rules).theta
    assert np.abs(moved(on_a_bed(0.0, 0.01), time, kinematics=kinematics).theta - plain).max() < 1e-6 * THETA0


@pytest.mark.parametrize(("kinematics", "relaxes_s"), [("guided", 0.05), ("pivoting", 2e-3)])
def test_energy_is_lost_by_what_relaxes_alone(kinematics, relaxes_s):
    """With q of 400 places found from the motion, the bed's ∫ τ q²/2c du and the loss ∫∫ q²/c du dt."""
    parameters, time = on_a_bed(5e-3, relaxes_s), np.arange(0, 1.5, 5e-5)
    found = moved(parameters, time, rtol=1e-10, kinematics=kinematics)
    u, c = (np.arange(400) - 199.5) * BLOCK.b / 200, parameters["c"]
    q, loss, held, lost = np.zeros(400), 0.0, [0.0], [0.0]
    fades = math.exp(-5e-5 / relaxes_s)
    depth = found.z_cb[:, None] + u * np.sin(found.theta)[:, None]
    for before, after in pairwise(depth):
        pressed = np.maximum(after, 0) - np.maximum(before, 0)
        q0 = q
        q = fades * q + c / relaxes_s * math.sqrt(fades) * pressed
        loss += 5e-5 * np.sum(q0 * q0 + q * q0 + q * q) / 3 / c * BLOCK.b / 200
        held.append(relaxes_s / (2 * c) * np.sum(q * q) * BLOCK.b / 200)
        lost.append(loss)
    motion = found.z_cb, found.z_cb_rate, found.theta, found.theta_rate
    stays = energy(BLOCK, Foundation(K), *motion, Rules(kinematics=kinematics)) + held
    assert np.diff(stays[::20]).max() < 1e-4 * stays[0]
    assert stays[-1] < 0.9 * stays[0]
    assert np.abs(stays + lost - stays[0]).max() < 5e-3 * stays[0]


@pytest.mark.parametrize("name", ["k", "c", "tau", "theta0"])
@pytest.mark.parametrize("kinematics", KINEMATICS)
def test_the_motion_is_smooth_in_each_number(kinematics, name):
    time, at = np.linspace(0, 3, 601), {**on_a_bed(2e-2, 0.02), "theta0": THETA0}

    def slope(step):
        ends = [{**at, name: at[name] * (1 + sign * step)} for sign in (1, -1)]
        one, other = (moved(each, time, BLOCK, 1e-12, each["theta0"], kinematics).theta for each in ends)
        return (one - other) / (2 * step)

    coarse, fine = slope(1e-5), slope(1e-6)
    assert np.abs(coarse - fine).max() < 1e-4 * np.abs(fine).max()


@pytest.mark.parametrize("kinematics", KINEMATICS)
def test_on_ground_that_moves(kinematics):
    """Without damping as on springs; one that relaxes at once as on springs and dashpots."""
    shaken, rules = pulse("sine", 0.5, x=0.15 * GRAVITY), Rules(kinematics=kinematics)
    how = {"theta0": 0.03, "base_excitation": shaken, "rules": rules}
    time = np.linspace(0, 2, 401)
    plain = simulate("winkler", BLOCK, {"k": K, "c": 0.0}, time, **how).theta
    assert (
        np.abs(simulate("viscoelastic", BLOCK, on_a_bed(0.0, 0.01), time, **how).theta - plain).max() < 1e-6
    )
    damped = simulate("winkler", BLOCK, {"k": K, "c": 5e-3 * K}, time, **how).theta
    quick = simulate("viscoelastic", BLOCK, on_a_bed(5e-3, 1e-5), time, **how).theta
    assert np.abs(quick - damped).max() < 1e-2 * np.abs(damped).max()


def test_it_comes_to_rest_where_the_bed_has_forgotten():
    found = moved(on_a_bed(5e-2, 0.03), np.linspace(0, 20, 101), rtol=1e-6)
    assert found.outcome == "at_rest" and found.theta[-1] == 0
    assert found.z_cb[-1] == pytest.approx(static_depth(BLOCK, Foundation(K), 0.0))


def test_every_door_finds_one_motion():
    parameters, time = on_a_bed(5e-3, 0.02), np.linspace(0, 2, 201)
    one = moved(parameters, time).theta
    assert simulate_theta("viscoelastic", BLOCK, parameters, time, theta0=THETA0)[0].tolist() == one.tolist()
    mirrored, _ = simulate_theta("viscoelastic", BLOCK, parameters, time, theta0=-THETA0)
    assert np.abs(one + mirrored).max() < 1e-12
    level = simulate("viscoelastic", BLOCK, parameters, time, theta0=THETA0, base_excitation=tilted(0.0, 2.0))
    assert np.abs(level.theta - one).max() < 1e-6 * THETA0
    leans = {**parameters, "tilt": 1e-5}
    tilted_theta, _ = simulate_theta("viscoelastic", BLOCK, leans, time, theta0=THETA0)
    assert 1e-5 < np.abs(tilted_theta - one).max() < 1e-2
    quick, plain = {**on_a_bed(5e-3, 1e-5), "tilt": 1e-3}, {"k": K, "c": 5e-3 * K, "tilt": 1e-3}
    winklers = simulate_theta("winkler", BLOCK, plain, time, theta0=THETA0)[0]
    level = simulate_theta("winkler", BLOCK, plain | {"tilt": 0.0}, time, theta0=THETA0)[0]
    relaxed = simulate_theta("viscoelastic", BLOCK, quick, time, theta0=THETA0)[0]
    assert np.abs(relaxed - winklers).max() < 0.05 * np.abs(level - winklers).max()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"tau": 0.0}, "parameters.tau: 0.0 is not a positive number; give tau in s"),
        ({"tau": math.nan}, "parameters.tau: nan is not a positive number; give tau in s"),
        ({"c": -1.0}, "parameters.c: -1.0 is not a non-negative number; give c in N s m-2"),
    ],
)
def test_bad_numbers_are_refused(changed, message):
    with pytest.raises(FreerockError) as caught:
        moved(on_a_bed(5e-3, 0.02) | changed, np.linspace(0, 1, 11))
    assert str(caught.value) == message


def test_the_tensionless_rule_is_refused():
    rules, time = Rules("tensionless"), np.linspace(0, 1, 11)
    with pytest.raises(FreerockError, match=r"debonding: .*not available for c and tau together"):
        simulate("viscoelastic", BLOCK, on_a_bed(5e-3, 0.02), time, theta0=0.1, rules=rules)
