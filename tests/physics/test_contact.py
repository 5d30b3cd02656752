"""The contact law: closed form against quadrature, and its borders."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_law import accelerations, contact_force, contact_intervals
from scipy.optimize import brentq

from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import State, static_depth
from freerock.models.laws import Foundation, Rules

BLOCK = Block(0.28, 0.07, 5.84)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)

laws = st.tuples(st.floats(1e5, 1e9), st.floats(0, 0.1), st.floats(0, 50)).map(
    lambda x: (x[0], x[0] * x[1], x[0] * x[2])
)
one_damping = st.tuples(laws, st.booleans()).map(
    lambda x: (*x[0][:2], 0.0) if x[1] else (x[0][0], 0.0, x[0][2])
)
states = st.tuples(st.floats(-0.02, 0.02), st.floats(-1, 1), st.floats(-0.6, 0.6), st.floats(-5, 5))
rules = st.sampled_from(["geometric", "tensionless"])


def quadrature(law, state, rule, strips=64):
    """∫ f du, ∫ |f| du and ∫ f u du of the distributed law, sought for its borders strip by strip."""
    k, c, lam = law
    z, v, theta, w = state
    s, spin = math.sin(theta), w * math.cos(theta)

    def depth(u):
        return z + u * s

    def f(u):
        return k * depth(u) + (c + lam * depth(u)) * (v + u * spin)

    edges = np.linspace(-BLOCK.b, BLOCK.b, strips + 1)
    cuts = set(edges)
    for function in (depth, f):
        for low, high in itertools.pairwise(edges):
            if function(low) * function(high) < 0:
                cuts.add(brentq(function, low, high, xtol=1e-17, rtol=1e-15))
    cuts = np.sort(list(cuts))
    middle, half = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts) / 2
    held = (depth(middle) > 0) & ((f(middle) > 0) | (rule == "geometric"))
    u = middle[:, None] + half[:, None] * NODES
    pressure = f(u) * half[:, None] * WEIGHTS * held[:, None]
    return pressure.sum(), np.abs(pressure).sum(), (pressure * u).sum()


@given(laws, states, rules)
def test_closed_form_is_the_quadrature_of_the_distributed_law(law, state, rule):
    force, moment = contact_force(BLOCK, Foundation(*law), State(*state), Rules(rule))
    total, absolute, first = quadrature(law, state, rule)
    assert force == pytest.approx(total, abs=1e-12 * absolute + 1e-60)
    assert moment == pytest.approx(first * math.cos(state[2]), abs=1e-12 * absolute * BLOCK.b + 1e-60)


tilted = st.tuples(
    st.floats(0.02, 0.6).flatmap(lambda x: st.sampled_from([x, -x])), st.floats(-5, 5), st.floats(-1, 1)
)  # θ, θ̇, ż_cb


@given(one_damping, tilted, rules, st.sampled_from([1, -1]), st.booleans())
def test_force_is_continuous_where_a_corner_touches_or_ceases_to_push(law, state, rule, side, pushing):
    k, c, lam = law
    theta, w, v = state
    u = side * BLOCK.b
    z = -u * math.sin(theta)
    if pushing:
        rate = v + u * w * math.cos(theta)
        if lam:
            v -= rate + k / lam
        else:
            z -= c * rate / k
    near = [
        contact_force(BLOCK, Foundation(*law), State(z + shift, v + shift, theta, w), Rules(rule))
        for shift in (-1e-11, 1e-11)
    ]
    largest = k * (abs(z) + BLOCK.b) + (c + lam * (abs(z) + BLOCK.b)) * (abs(v) + BLOCK.b * abs(w))
    assert near[0] == pytest.approx(near[1], abs=1e-7 * largest * BLOCK.b)


@given(one_damping, states)
def test_tensionless_never_pulls(law, state):
    assert contact_force(BLOCK, Foundation(*law), State(*state), Rules("tensionless"))[0] >= 0


@given(laws, states, rules)
def test_mirror(law, state, rule):
    z, v, theta, w = state
    a, turn = accelerations(BLOCK, Foundation(*law), State(z, v, theta, w), Rules(rule), x_ground=1.5)
    mirrored = accelerations(BLOCK, Foundation(*law), State(z, v, -theta, -w), Rules(rule), x_ground=-1.5)
    scale = abs(a) + abs(turn) + 1
    assert mirrored == pytest.approx((a, -turn), abs=1e-9 * scale)


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
def test_a_hand_holds_the_tilted_block_and_turns_one_in_flight(kinematics):
    rules, bed, theta = Rules(kinematics=kinematics), Foundation(6.88e6, lam=1.3e8), 0.17
    state = State(static_depth(BLOCK, bed, theta), 0.0, theta, 0.0)
    weight = BLOCK.mass_kg * GRAVITY
    holding = contact_force(BLOCK, bed, state)[1] - weight * BLOCK.h * math.sin(theta)
    assert accelerations(BLOCK, bed, state, rules, hand=holding) == pytest.approx((0, 0), abs=1e-9)
    a, turn = accelerations(BLOCK, bed, State(-0.1, 0.0, 0.0, 0.0), rules, hand=0.3)
    assert (a, turn) == pytest.approx((GRAVITY, 0.3 / BLOCK.inertia_base), rel=1e-12)


def test_both_dampings_may_cut_a_hole():
    """With c and λ a downward-moving middle may hold where both sides let go, and the reverse."""
    scene = Foundation(1e6, 1e4, 1e7), State(1e-3, -0.05, 0.01, 2.0), Rules("tensionless")
    found = contact_intervals(BLOCK, *scene)
    total, absolute, _ = quadrature((1e6, 1e4, 1e7), (1e-3, -0.05, 0.01, 2.0), "tensionless")
    force, _ = contact_force(BLOCK, *scene)
    assert found and force == pytest.approx(total, abs=1e-12 * absolute + 1e-300)
