"""Which candidates there are, where their fits start, and the quick fit that screens them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import fit_record, fit_run
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, GEOMETRIC, KINEMATICS, LAWS, Rules
from freerock.models.simulate import Solver, simulate_theta
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import BY_DEFAULT, Hypothesis, candidates, n_freed
from freerock.selection.quick import screen, start_from

BLOCK = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
FREE = {law: ("theta0", "t0") for law in LAWS}
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}


def motion(
    block=BLOCK, sigma=1e-4, model="hunt_crossley", values=MARBLE, theta0_deg=10.0, span=4.0, rules=GEOMETRIC
):
    time, theta0 = np.arange(0, span, 5e-4), math.radians(theta0_deg)
    theta, _ = simulate_theta(model, block, values, time, theta0=theta0, rules=rules, solver=Solver(1e-10))
    noise = np.random.default_rng(3).normal(0, sigma, len(time))
    return Motion(time, theta + noise, sigma, theta0, 2e-5, 2e-4)


def test_candidates_go_from_few_freed_numbers_to_many():
    found = candidates(tuple(LAWS), KINEMATICS, FREE)
    assert set(found) == set(CANDIDATES) and found[0] == "housner"
    counts = [n_freed(model, FREE) for model in found]
    assert counts == sorted(counts)
    assert (n_freed("housner", FREE), n_freed("housner_width", FREE)) == (3, 4)
    assert (n_freed("winkler_pivoting", FREE), n_freed("general_pivoting_width", FREE)) == (4, 6)


def test_rivals_are_those_of_the_laws_and_kinematics_asked_for():
    assert candidates(("winkler",), ("guided",), FREE) == ("winkler", "winkler_width")
    pivoting = ("winkler", "winkler_pivoting", "winkler_pivoting_width")
    assert candidates(("winkler",), ("pivoting",), FREE) == pivoting
    assert candidates(("housner",), ("guided",), FREE) == ("housner", "housner_width")
    bare = dict.fromkeys(LAWS, ())
    assert candidates(("winkler", "housner"), (), bare) == ("housner", "winkler")


def test_a_width_that_is_freed_anyway_makes_no_further_candidate():
    free = FREE | {"winkler": ("width", "theta0"), "housner": ("width",)}
    assert candidates(("housner", "winkler"), KINEMATICS, free) == ("housner", "winkler", "winkler_pivoting")
    assert n_freed("winkler", free) == n_freed("winkler_width", free) == 4


def test_a_rival_starts_where_the_best_smaller_candidate_ended():
    run = motion()
    fits = {model: fit_run(model, BLOCK, run) for model in ("housner", "winkler", "hunt_crossley")}
    found = dict(zip(fits["hunt_crossley"].parameters, fits["hunt_crossley"].value, strict=True))
    assert start_from(Hypothesis("hunt_crossley_pivoting"), [fits["hunt_crossley"]]) == found
    assert start_from(Hypothesis("hunt_crossley", ("tilt",)), [fits["hunt_crossley"]]) == found
    general = start_from(Hypothesis("general"), [fits["winkler"], fits["hunt_crossley"]])
    assert general == found | {"c": 1e-4 * found["k"]}
    wide = start_from(Hypothesis("winkler_width"), [fits["winkler"]])
    assert wide["c"] == fits["winkler"].value[1]
    assert (
        start_from(Hypothesis("housner_width"), [fits["housner"]]) is None
    )  # r and width are scanned together
    failed = replace(fits["winkler"], success=False)
    assert start_from(Hypothesis("winkler_width"), [failed]) is None


def test_neighbours_of_a_hypothesis_add_one_step():
    beside = {*BY_DEFAULT.neighbours(Hypothesis("winkler"))}
    models = ("general", "winkler_pivoting", "winkler_width")
    widened = ("release", "tilt", "edge_radius")
    assert beside == {
        *(Hypothesis(model) for model in models),
        *(Hypothesis("winkler", (each,)) for each in widened),
    }
    further = {*BY_DEFAULT.neighbours(Hypothesis("winkler_pivoting", ("tilt",)))}
    assert further == {
        Hypothesis("winkler", ("tilt",)),
        Hypothesis("general_pivoting", ("tilt",)),
        Hypothesis("winkler_pivoting_width", ("tilt",)),
        Hypothesis("winkler_pivoting", ("release", "tilt")),
        Hypothesis("winkler_pivoting", ("tilt", "edge_radius")),
    }
    reached, found = {*map(Hypothesis, BY_DEFAULT.always_fitted)}, set()
    while reached:
        found |= reached
        reached = {other for each in reached for other in BY_DEFAULT.neighbours(each)} - found
    assert {each.model for each in found} == {*BY_DEFAULT.candidates}


def test_a_pivoting_block_is_found_from_the_guided_fit_that_is_far_off():
    squat = Block(height_m=0.14, width_m=0.07, mass_kg=2.98)
    run = motion(squat, theta0_deg=20, rules=Rules(kinematics="pivoting"))
    guided = {"hunt_crossley": fit_run("hunt_crossley", squat, run)}
    assert guided["hunt_crossley"].value[0] < 0.7 * MARBLE["k"]
    start = start_from(Hypothesis("hunt_crossley_pivoting"), [*guided.values()])
    found = screen("hunt_crossley_pivoting", squat, run, FitSettings(), start)
    assert found.values["k"] == pytest.approx(MARBLE["k"], rel=0.05)
    assert np.std(found.residual) == pytest.approx(run.sigma_theta, rel=0.1)


@pytest.mark.parametrize("r, share", [(0.98, 0.98), (0.8, 0.85), (0.986, 0.755), (0.95, 0.91)])
def test_a_rigid_block_with_worn_corners_is_found(r, share):
    """The third from the nominal width alone ended with the width at its bound."""
    worn = replace(BLOCK, contact_width_m=share * BLOCK.width_m)
    run = motion(worn, model="housner", values={"r": r}, span=8.0)
    fit = fit_run("housner_width", BLOCK, run)
    assert fit.success and fit.diagnostics["residual_over_sigma"] < 1.1
    truth = {"r": r, "width": worn.contact_width_m}
    for name, value, stderr in zip(fit.parameters, fit.value, fit.stderr, strict=True):
        assert name not in truth or abs(value - truth[name]) < 4 * stderr, name


def test_a_screening_finds_what_the_fit_finds_from_fewer_samples():
    worn = replace(BLOCK, contact_width_m=0.067)
    run = motion(worn)
    start = start_from(Hypothesis("hunt_crossley_width"), [fit_run("hunt_crossley", BLOCK, run)])
    found = screen("hunt_crossley_width", BLOCK, run, FitSettings(), start)
    fit = fit_run("hunt_crossley_width", BLOCK, run)
    assert list(found.values) == list(fit.parameters)
    for name, value, stderr in zip(fit.parameters, fit.value, fit.stderr, strict=True):
        assert abs(found.values[name] - value) < 10 * stderr, name
    assert 900 < len(found.residual) == len(found.time_s) < 1200
    assert np.std(found.residual) == pytest.approx(run.sigma_theta, rel=0.1)
    assert 0 < found.evaluations < 60


def test_a_fit_may_start_from_names_as_from_the_laws_parameters_in_their_order():
    run, start = motion(span=2.0), {"k": 6.5e6, "lambda": 1.2e8}
    by_name = fit_record("hunt_crossley", BLOCK, [run], start=start | {"theta0": math.radians(10)})
    in_order = fit_record("hunt_crossley", BLOCK, [run], start=list(start.values()))
    assert np.allclose(by_name.value, in_order.value, rtol=1e-5, atol=1e-8)


def test_a_start_whose_end_is_poor_is_not_believed():
    squat, truth = Block(height_m=0.14, width_m=0.07, mass_kg=2.98), {"k": 2e7, "c": 8e3}
    run = motion(squat, model="winkler", values=truth, theta0_deg=20)
    start = {"k": 3e7, "c": 8e3}
    false = screen("winkler", squat, run, FitSettings(), start)
    assert np.std(false.residual) > 10 * run.sigma_theta
    fit = fit_record("winkler", squat, [run], start=start)
    assert fit.diagnostics["residual_over_sigma"] < 1.1
    assert abs(fit.value[0] - truth["k"]) < 4 * fit.stderr[0]
