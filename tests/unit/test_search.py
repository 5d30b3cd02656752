"""Starts of a fit, and the horizons over which they are followed."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification import search
from freerock.identification.diverging_motions import PURSUIT
from freerock.identification.fit import fit_run
from freerock.identification.intervals import Uncertainty
from freerock.identification.least_squares import Solution
from freerock.identification.model_discrepancy import failure
from freerock.identification.search import follow, growing_horizons
from freerock.identification.start import posed, scan
from freerock.models.block import Block
from freerock.models.laws import MODELS
from freerock.models.simulate import simulate_theta
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.success import demanding
from freerock_bench.virtual_run import Truth, drawn_run, virtual_motion

BLOCK = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
TIME = np.arange(0, 4, 1e-3)


def motion(model, values, theta0=0.17):
    law = dict(zip(MODELS[model], values, strict=True))
    theta, _ = simulate_theta(model, BLOCK, law, TIME, theta0=theta0)
    return Motion(TIME, theta, 1e-4, theta0)


@pytest.mark.parametrize("model, values", [("winkler", [4.5e6, 4.05e4]), ("hunt_crossley", [6.88e6, 1.30e8])])
def test_a_start_lies_within_a_cell_of_the_truth(model, values):
    run = motion(model, values)
    problem = posed(model, [BLOCK], [run], FitSettings())
    starts = scan(problem, growing_horizons(run)[0])
    assert 1 <= len(starts) <= 3
    k, ratio = np.log(values[0]), np.log(values[1] / values[0])
    assert min(abs(start[0] - k) for start in starts) < np.log(1e9 / 3e5) / 15
    assert min(abs(start[1] - ratio) for start in starts) < np.log(100) / 7 * 1.1


def test_housners_r_is_found_by_the_scan_alone():
    run = motion("housner", [0.93])
    ((found,),) = scan(posed("housner", [BLOCK], [run], FitSettings()), np.inf)
    assert found == pytest.approx(0.93, abs=0.06 * (1 - 0.93))


@pytest.mark.parametrize("share", [0.8, 0.9, 0.97])
def test_worn_corners_are_found_by_the_scan_alone(share):
    worn = replace(BLOCK, contact_width_m=share * BLOCK.width_m)
    theta, _ = simulate_theta("housner", worn, {"r": 0.93}, TIME, theta0=0.17)
    noise = np.random.default_rng(1).normal(0.0, 1e-3, len(TIME))
    run = Motion(TIME, theta + noise, 1e-3, 0.17, fit_start_s=0.03)
    starts = scan(posed("housner_width", [BLOCK], [run], FitSettings()), growing_horizons(run)[0])
    assert all(width == pytest.approx(share, abs=2e-3) for _, width in starts)
    assert min(abs(r - 0.93) for r, _ in starts) < 7 * 0.06 * (1 - 0.93)


def test_a_law_with_two_dampings_starts_from_its_cases():
    run = motion("hunt_crossley", [6.88e6, 1.30e8])
    starts = scan(posed("general", [BLOCK], [run], FitSettings()), growing_horizons(run)[0])
    assert 2 <= len(starts) <= 4
    assert all(len(start) == 3 for start in starts)
    assert any(start[2] == np.log(1.0) for start in starts)  # Winkler's, with a trace of λ/k
    assert any(start[1] == np.log(1e-4) for start in starts)  # Hunt and Crossley's, with a trace of c/k


def test_horizons_double_from_the_first_swings_to_the_whole_run():
    run = motion("housner", [0.93])
    horizons = growing_horizons(run)
    first = TIME[np.flatnonzero(run.theta < 0)[0]]
    assert horizons[0] == pytest.approx(3 * first, rel=0.01)
    assert np.divide(horizons[1:], horizons[:-1]) == pytest.approx(2.0)
    assert horizons[-2] < TIME[-1] <= horizons[-1]
    late = Motion(**{**vars(run), "fit_start_s": 1.0})
    assert growing_horizons(late)[0] == pytest.approx(1.0 + first, rel=0.01)


def test_starts_that_come_to_the_same_end_are_followed_once(monkeypatch):
    run = motion("winkler", [4.5e6, 4.05e4])
    problem = posed("winkler", [BLOCK], [run], FitSettings())
    starts = scan(problem, growing_horizons(run)[0])[:1]
    near = [[k + step, ratio] for k, ratio in starts for step in (0.0, 0.02, -0.02)]
    followed = []
    monkeypatch.setattr(search, "scan", lambda *given: near)
    monkeypatch.setattr(search, "follow", lambda *given: followed.append(given[2]) or follow(*given))
    end = search.approach(problem)
    later = growing_horizons(run)[1:]
    assert followed[len(near) :] == [[horizon] for horizon in later]
    assert end.x[0] == pytest.approx(np.log(4.5e6), abs=1e-4)


def test_a_hardly_damped_foundation_under_a_squat_block_is_found():
    """c/k is 3.4e-4 s, the release 0.73 of the critical angle; k 36 % too low leaves several σ."""
    block, _, _ = CONFIGURATIONS["config3"]
    truth = Truth("winkler", block, {"k": 7.968e7, "c": 2.697e4}, -0.34465, math.radians(0.01))
    run = virtual_motion(truth, np.random.default_rng(1), still_s=(1.0, 1.0))
    fit = fit_run("winkler", block, run)
    assert fit.success and fit.diagnostics["residual_over_sigma"] < 1.1
    assert fit.value[0] == pytest.approx(7.968e7, rel=0.01)


def test_a_block_that_rattles_and_leaves_more_than_noise_has_no_standard_error():
    """Damping that no law has: the end of the fit may be any of many minima."""
    block, _, _ = CONFIGURATIONS["config3"]
    truth = Truth("winkler", block, {"k": 3e7, "c": 3e3}, 0.4, math.radians(0.01))
    run = virtual_motion(truth, np.random.default_rng(1), still_s=(1.0, 1.0))
    other = replace(run, theta=run.theta * (1 + 0.05 * np.sin(3 * run.time_s)))
    problem = posed("winkler", [block], [other], FitSettings())
    x = problem.start_at({"k": 3e7, "c": 3e3})
    end = Solution(x, float(np.mean(problem.residual(x, problem.samples()) ** 2)), 1, True, "")
    known = Uncertainty(np.eye(len(x)), *np.ones((3, len(x))), coloured=False, widened=1.0)
    assert failure(problem, end, known, 1e-3).endswith("possibly another minimum")
    assert failure(problem, replace(end, mean_square=other.sigma_theta**2), known, 1e-3) == ""
    beyond = replace(problem, fine=PURSUIT.finest)
    assert "beyond precision" in failure(beyond, replace(end, mean_square=other.sigma_theta**2), known, 1e-3)


@pytest.mark.slow
def test_a_minimum_that_longer_horizons_lose_is_found_where_the_first_swings_show_it():
    """λ/k is 1.15 s/m; a k 6 times too low, damped more than what counts as hardly damped, leaves 51 σ."""
    truth, run = drawn_run("hunt_crossley", ("white", "coloured"), (1, 2, 106, 1), demanding)
    fit = fit_run("hunt_crossley", truth.block, run)
    assert fit.success and abs(fit.value[0] - truth.parameters["k"]) < 4 * fit.stderr[0]


@pytest.mark.slow
def test_ends_of_two_pursuits_are_taken_to_their_minima_before_they_are_told_apart():
    """λ/k is 0.89 s/m; the first pursuit stops at 1.16 σ, its release 17 standard errors off."""
    truth, run = drawn_run("hunt_crossley", ("white", "coloured"), (1, 2, 605, 1), demanding)
    fit = fit_run("hunt_crossley", truth.block, run)
    assert fit.success and abs(fit.value[0] - truth.parameters["k"]) < 4 * fit.stderr[0]


def test_another_minimum_than_that_of_the_first_swings_is_not_believed():
    """λ/k is 0.58 s/m. The first swings say so, but k 38 times too low, damped more, leaves 28 σ of the run,
    and so less than the minimum that longer horizons lose: the motion multiplies errors."""
    truth, run = drawn_run("hunt_crossley", ("white", "coloured"), (1, 2, 151, 1), demanding)
    fit = fit_run("hunt_crossley", truth.block, run)
    assert (fit.success, fit.message) == (
        False,
        "not converged: the motion multiplies errors beyond precision",
    )
    assert np.all(np.isnan(fit.stderr))
