"""Contributions of the laboratory's inputs: each is what a fit finds with the input moved."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import fit_run
from freerock.identification.least_squares import least_squares
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.simulate import Solver
from freerock.populations.sensitivity import contributions
from freerock.rotation.as_measured import as_measured
from freerock.rotation.beam import displacement_from_rotation, rotation_from_displacement
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View, view_of
from freerock.runs.motion import Motion

BLOCK = Block(0.28, 0.07, 5.84)
LASER = Laser("horizontal", 0.2, 0.1)
INPUTS = {
    "height_m": Input("b", "height_m", 3e-4, False),
    "width_m": Input("b", "width_m", 3e-4, False),
    "position_m": Input("l", "position_m", 6e-4, True),
    "scale_fraction": Input("l", "scale_fraction", 1e-3, False),
    "sampling_rate_fraction": Input("l", "sampling_rate_fraction", 6e-5, False),
    "mass_kg": Input("b", "mass_kg", 0.00584, False),
}
LAWS = {"hunt_crossley": {"k": 2.86e6, "lambda": 8.16e7}, "housner": {"r": 0.9}}


def measured(law, seed=5):
    """A run as its laser sees it, with noise."""
    generator, time_s = np.random.default_rng(seed), np.arange(0, 2.5, 1 / 2000)
    sigma, theta0 = math.radians(0.006), math.radians(10)
    view = view_of([LASER], BLOCK)
    theta = as_measured(law, BLOCK, {**LAWS[law], "theta0": theta0}, time_s, view, solver=Solver(1e-9))
    theta = theta + sigma * generator.standard_normal(theta.size)
    return Motion(time_s, theta, sigma, theta0, 1e-5, 2e-4, 0.03, view=view)


@pytest.fixture(scope="module")
def fits():
    """Motion and fit of each law."""
    found = {}
    for law in LAWS:
        motion = measured(law)
        found[law] = motion, fit_run(law, BLOCK, motion)
    return found


def refitted(law, motion, fit, name, by):
    """Parameters of a fit with an input moved by so much of its uncertainty, posed by hand."""
    u, block, laser, clock, scale = INPUTS[name].u * by, BLOCK, LASER, 1.0, 1.0
    if name == "sampling_rate_fraction":
        clock = 1 / (1 + u)
    elif name == "scale_fraction":
        scale = 1 + u
    elif name == "position_m":
        laser = replace(LASER, position_m=LASER.position_m + u)
    else:
        block = replace(BLOCK, **{name: getattr(BLOCK, name) + u})

    def reread(theta):
        return rotation_from_displacement(
            scale * displacement_from_rotation(theta, BLOCK, LASER), block, laser
        )

    moved = replace(
        motion,
        time_s=motion.time_s * clock,
        fit_start_s=motion.fit_start_s * clock,
        theta=reread(motion.theta),
        theta0=float(reread(np.array(motion.theta0))),
        view=View(block, replace(motion.view.laser, position_m=laser.position_m)),
    )
    problem = replace(posed(law, (block,), (moved,), FitSettings()), rtol=1e-8)
    end = least_squares(problem, problem.start_at(fit.values), problem.samples(), 1e-13)
    return problem.physical(end.x)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", INPUTS)
def test_a_contribution_is_that_of_a_fit_with_the_input_moved(fits, law, name):
    motion, fit = fits[law]
    known = contributions(fit, motion, Laboratory(BLOCK, {"l": LASER}, (INPUTS[name],)), FitSettings())
    share = 0.1
    ends = [refitted(law, motion, fit, name, by) for by in (share, -share)]
    expected = (ends[0] - ends[1]) / (2 * share)
    n = len(LAWS[law])
    np.testing.assert_allclose(known.values[:n, 0], expected[:n], rtol=0.02, atol=2e-3 * fit.stderr[:n].max())


@pytest.mark.parametrize("stated_ms", [0.0, 3.0])
@pytest.mark.parametrize("law", LAWS)
def test_a_response_contributes_what_a_fit_finds_with_a_sensor_that_is_slower_by_all_of_its_uncertainty(
    fits, law, stated_ms
):
    """Its effect grows with the square of the time, so that its derivative at 0 would tell nothing; r of a
    rigid block, told by the times between impacts, hardly knows it."""
    laser, more_ms = replace(LASER, response_ms=stated_ms), 2.9
    motion = replace(fits[law][0], view=view_of([laser], BLOCK))
    slow = replace(motion, view=view_of([replace(laser, response_ms=stated_ms + more_ms)], BLOCK))
    ends = []
    for each in (motion, slow):
        problem = replace(posed(law, (BLOCK,), (each,), FitSettings()), rtol=1e-8)
        start = problem.start_at(fits[law][1].values)
        ends.append(problem.physical(least_squares(problem, start, problem.samples(), 1e-13).x))
    fit = replace(fits[law][1], value=ends[0])
    source = Input("l", "response_ms", more_ms, False)
    known = contributions(fit, motion, Laboratory(BLOCK, {"l": laser}, (source,)), FitSettings())
    n, expected = len(LAWS[law]), ends[1] - ends[0]
    assert np.any(np.abs(expected[:n]) > 0.1 * fit.stderr[:n]) == (law == "hunt_crossley")
    np.testing.assert_allclose(known.values[:n, 0], expected[:n], rtol=0.05, atol=0.02 * fit.stderr[:n].max())


def test_an_exact_input_contributes_nothing_and_the_total_is_a_root_sum_of_squares(fits):
    motion, fit = fits["hunt_crossley"]
    inputs = (INPUTS["width_m"], replace(INPUTS["height_m"], u=0.0), INPUTS["mass_kg"])
    known = contributions(fit, motion, Laboratory(BLOCK, {"l": LASER}, inputs), FitSettings())
    assert np.all(known.values[:, 1] == 0)
    assert known.values[:2, 2] == pytest.approx(fit.value[:2] * 1e-3)
    squares = fit.stderr**2 + known.values[:, 0] ** 2 + known.values[:, 2] ** 2
    np.testing.assert_allclose(known.total(fit.stderr), np.sqrt(squares))


def test_a_levelled_base_counts_unless_its_tilt_was_fitted(fits):
    motion, fit = fits["hunt_crossley"]
    laboratory = Laboratory(BLOCK, {"l": LASER}, (Input("f", "levelled_deg", 0.02, True),))
    assert abs(contributions(fit, motion, laboratory, FitSettings()).values[0, 0]) > 1e-4 * fit.value[0]
    free = FitSettings(("theta0", "t0", "tilt"))
    tilted = fit_run("hunt_crossley", BLOCK, motion, free)
    assert np.all(contributions(tilted, motion, laboratory, free).values == 0)
