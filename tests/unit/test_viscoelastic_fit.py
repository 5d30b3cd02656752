"""The law of a bed that relaxes: when it is tried, and what a fit tells of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.models.block import GRAVITY, Block
from freerock.models.contact import Foundation, static_depth
from freerock.models.corners import corners_over_time
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate
from freerock.models.viscoelastic import CELLS, integrate_viscoelastic
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import identify_run

BLOCK, K = Block(0.28, 0.07, 5.84), 6.88e6
SIGMA, THETA0 = math.radians(0.006), 0.12
GUIDED = replace(BY_DEFAULT, kinematics=("guided",))
LISTED = replace(GUIDED, laws=("winkler", "hunt_crossley", "viscoelastic"))


def measured(law, parameters, seed, kinematics="guided"):
    """A run of 4 s with white noise; under the law that relaxes on four times as many cells as usual."""
    time, rules = np.arange(0, 4, 2e-3), Rules(kinematics=kinematics)
    if law == "viscoelastic":
        bed, exact = Foundation.of(parameters), np.empty(time.size)
        start = static_depth(BLOCK, bed, THETA0), 0.0, THETA0, 0.0
        memory = parameters["c"] / BLOCK.mass_kg, parameters["tau"]
        level = np.empty(0), np.empty((0, 14))
        scene = bed.constants(BLOCK, kinematics == "pivoting"), memory, start, time, *level
        integrate_viscoelastic(*scene, 1e-10 * THETA0, 1_000_000, exact, np.empty((0, 3)), cells=4 * CELLS)
    else:
        exact = simulate(law, BLOCK, parameters, time, theta0=THETA0, rules=rules, solver=Solver(1e-10)).theta
    return Motion(time, exact + np.random.default_rng(seed).normal(0, SIGMA, time.size), SIGMA, THETA0)


@pytest.mark.parametrize(("damping_s", "relaxes_s"), [(5e-3, 2e-3), (0.02, 0.2)])
def test_stiffness_damping_and_relaxation_are_found(damping_s, relaxes_s):
    truth = {"k": K, "c": damping_s * K, "tau": relaxes_s}
    found = identify_run(BLOCK, measured("viscoelastic", truth, 4), LISTED)
    choice = found.choice(LISTED)
    assert (choice.selected, choice.explained) == ("viscoelastic", True)
    fit = found.fits["viscoelastic"]
    assert fit.parameters == ("k", "c", "tau", "theta0", "t0")
    for name, stderr in zip(truth, fit.stderr, strict=False):
        assert abs(fit.values[name] - truth[name]) < 3 * stderr < 0.1 * truth[name]


def test_a_pivoting_block_on_such_a_bed_is_found():
    hypotheses = replace(LISTED, kinematics=("guided", "pivoting"))
    truth = {"k": K, "c": 5e-3 * K, "tau": 0.01}
    found = identify_run(BLOCK, measured("viscoelastic", truth, 4, "pivoting"), hypotheses)
    assert found.choice(hypotheses).selected == "viscoelastic_pivoting"


@pytest.mark.parametrize(
    ("law", "more"), [("winkler", {"c": 5e-3 * K}), ("hunt_crossley", {"lambda": 1.3e8})]
)
def test_a_bed_that_does_not_relax_is_named_as_it_is(law, more):
    choice = identify_run(BLOCK, measured(law, {"k": K, **more}, 4), LISTED).choice(LISTED)
    assert (choice.selected, choice.explained) == (law, True)


def test_it_is_tried_only_where_it_is_listed():
    truth = {"k": K, "c": 5e-3 * K, "tau": 0.01}
    motion = measured("viscoelastic", truth, 4)
    assert not any("viscoelastic" in name for name in BY_DEFAULT.candidates)
    found = identify_run(BLOCK, motion, replace(GUIDED, laws=("winkler", "hunt_crossley")))
    assert not found.explained
    tried = {*found.fits, *found.ruled_out, *found.errors}
    assert tried and not any("viscoelastic" in name for name in tried)


def test_the_force_of_such_a_bed_is_what_moves_the_block():
    """In flight it is none; as τ shrinks it comes to Winkler's."""
    time, values = np.linspace(0, 0.5, 2001), {"k": K, "c": 5e-3 * K, "theta0": THETA0}
    plain = corners_over_time("winkler", BLOCK, values, time).force
    quick = corners_over_time("viscoelastic", BLOCK, {**values, "tau": 1e-5}, time).force
    inner = slice(2, -2)
    assert np.abs(quick - plain)[inner].max() < 0.1 * plain.max()
    assert np.median(np.abs(quick - plain)) < 1e-2 * BLOCK.mass_kg * GRAVITY
