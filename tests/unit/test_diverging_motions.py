"""Fits of motions that multiply errors."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification.diverging_motions import PURSUIT, pursue, resolved
from freerock.identification.fit import fit_run
from freerock.identification.problem import RTOL_DERIVATIVES
from freerock.identification.search import as_exact, follow
from freerock.identification.start import posed
from freerock.models.laws import MODELS
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.virtual_run import Truth, virtual_motion

BLOCK, _, _ = CONFIGURATIONS["config3"]
CALM = Truth("winkler", BLOCK, {"k": 3e7, "c": 3e5}, 0.3, math.radians(0.01))
RATTLING = Truth(
    "winkler", BLOCK, {"k": 7.28e7, "c": 1.223e4}, 0.75 * math.atan(0.5), math.radians(0.008), rtol=1e-14
)


def posed_at(truth):
    """The problem of a run of a truth, and its numbers there."""
    run = virtual_motion(truth, np.random.default_rng(5), still_s=(1.0, 1.0))
    problem = replace(posed("winkler", [BLOCK], [run], FitSettings()), rtol=RTOL_DERIVATIVES)
    return problem, problem.start_at({**truth.parameters, "theta0": truth.theta0, "t0": run.time_s[0]})


def test_a_motion_that_forgets_errors_keeps_its_steps():
    problem, x = posed_at(CALM)
    assert resolved(problem, x, problem.samples(most=1000)) is problem


def test_a_motion_that_multiplies_errors_gets_steps_that_move_it_by_part_of_the_noise():
    problem, x = posed_at(RATTLING)
    samples = problem.samples(most=1000)
    finer = resolved(problem, x, samples)
    assert finer.rtol == finer.fine < RTOL_DERIVATIVES and finer.stride < 1
    before = finer.curve(x, samples)
    moved = [
        np.sqrt(np.mean((finer.curve(x + step, samples) - before) ** 2)) / problem.motions[0].sigma_theta
        for step in finer.directions.T
    ]
    assert max(moved) < 1.5 * PURSUIT.within * PURSUIT.moved


def test_derivatives_along_directions_are_those_by_each_number():
    problem, x = posed_at(CALM)
    samples = problem.samples(most=1000)
    problem = replace(problem, rtol=1e-11, fine=1e-11)
    mixed = np.linalg.qr(np.random.default_rng(1).standard_normal((len(x), len(x))))[0]
    along = replace(problem, directions=1e-6 * mixed).jacobian(x, samples)
    by_number = problem.jacobian(x, samples, central=True)
    scale = np.sqrt(np.mean(by_number**2, axis=0))
    np.testing.assert_allclose(along / scale, by_number / scale, atol=3e-3)


def test_a_minimum_at_a_coarse_tolerance_is_none_of_the_motion_itself():
    problem, x = posed_at(RATTLING)
    noise = RATTLING.sigma_theta**2
    coarse = follow(replace(problem, rtol=1e-3).rough(), x, [problem.motions[0].time_s[-1]])
    assert coarse.mean_square < 1.2 * noise
    assert as_exact(problem, coarse).mean_square > 100 * noise


def test_it_gives_up_a_motion_that_no_law_has():
    problem, x = posed_at(RATTLING)
    (run,) = problem.motions
    other = replace(run, theta=run.theta * (1 + 0.05 * np.sin(3 * run.time_s)))
    assert pursue(replace(problem, motions=(other,)), x, 0.5) is None


@pytest.mark.slow
def test_a_block_that_rattles_is_found_and_its_standard_errors_are_right():
    """c/k is 1.7e-4 s, the release 0.75 of the critical angle: the motion multiplies errors by 1e8."""
    problem, _ = posed_at(RATTLING)
    fit = fit_run("winkler", BLOCK, problem.motions[0])
    assert fit.success, fit.message
    assert fit.diagnostics["residual_over_sigma"] == pytest.approx(1, abs=0.05)
    truth = np.array([RATTLING.parameters[name] for name in MODELS["winkler"]])
    assert np.all(np.abs(fit.value[:2] - truth) < 4 * fit.stderr[:2])
    assert np.all(fit.stderr[:2] < 1e-3 * truth)
