"""How far a law that does not explain its run may be off: from the parts of the run."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import t

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import fit_run
from freerock.identification.model_discrepancy import (
    PARTS_OF_RUN,
    Part,
    fitted_parts,
    model_discrepancy,
    parts_of,
)
from freerock.identification.start import posed
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.springs import Motion, Scene
from freerock_bench.virtual_run import RATE_HZ, Truth, virtual_motion

BLOCK, THETA0, _ = CONFIGURATIONS["config2"]
SOIL = FOUNDATIONS["aerstop"]
SIGMA = math.radians(0.006)
TIME_S = np.arange(0.0, 4.0, 1 / RATE_HZ)


def on_springs(soil, **besides):
    """θ(t) by an integration of its own."""
    scene = Scene(BLOCK, soil, False, 0.8 * THETA0, 1e-7, besides=besides)
    theta = Motion(scene, RATE_HZ, TIME_S[-1]).theta
    return np.pad(theta, (0, len(TIME_S) - len(theta)))


def measured(sigma=SIGMA, seed=1, **differs):
    theta = on_springs(SOIL, **differs)
    truth = Truth("hunt_crossley", BLOCK, SOIL, 0.8 * THETA0, sigma)
    return virtual_motion(truth, np.random.default_rng(seed), (TIME_S, theta), (1.5, 1.5))


def parts_fitted(motion):
    fit = fit_run("hunt_crossley", BLOCK, motion)
    problem = posed("hunt_crossley", (BLOCK,), (motion,), FitSettings())
    x = problem.start_at(fit.values)
    samples = problem.samples()
    residual, jacobian = problem.residual(x, samples), problem.jacobian(x, samples, central=True)
    return fit, fitted_parts(problem, x, residual, jacobian)


def test_parts_have_as_many_swings_and_the_last_one_what_is_lost_in_noise():
    time = np.linspace(0, 1, 12001)
    theta = np.where(time < 0.75, 1.0, 1e-3) * np.cos(24 * np.pi * time)  # 18 swings, then 6 low ones
    parts = parts_of(theta, 0.01)
    assert len(parts) == PARTS_OF_RUN and parts[0].start == 0 and parts[-1].stop == len(theta)
    assert all(one.stop == other.start for one, other in pairwise(parts))
    passes = [int(np.sum(theta[part][1:] * theta[part][:-1] < 0)) for part in parts]
    assert set(passes[:-1]) <= {2, 3} and passes[-1] > 5
    assert len(parts_of(np.cos(np.linspace(0, 4, 100)), 0.01)) == 1  # one passage: nothing to compare


def test_parts_of_the_law_itself_agree_to_within_their_noise():
    fit, parts = parts_fitted(measured())
    off = np.array([(part.value - fit.value)[:2] / part.stderr[:2] for part in parts])
    assert np.abs(off).max() < 4
    assert np.all(fit.discrepancy == 0)


def test_the_uncertainty_is_students_of_the_weighed_parts():
    value = np.array([10.0, 1.0, 5.0])
    steps, errors = np.array([0.3, -0.1, 0.2]), np.array([0.1, 0.4, 0.2])
    stderrs = [np.array([error, math.nan if i else 1.0, 0.0]) for i, error in enumerate(errors)]
    parts = [
        Part(i, i + 1.0, value + step * np.array([1, 1, 0]), stderr, np.diag(stderr**2))
        for i, (step, stderr) in enumerate(zip(steps, stderrs, strict=True))
    ]
    found = model_discrepancy(value, parts)
    rms = math.sqrt(np.sum(steps**2 / errors) / np.sum(1 / errors))
    assert found[0] == pytest.approx(rms * t.ppf(0.975, 2) / 1.959964, rel=1e-6)
    assert np.isnan(found[1:]).all()  # known by one part, and by none


def test_numbers_that_follow_are_as_uncertain_as_the_parts_make_them():
    """One of the parameters has its own discrepancy; in a sum what goes together counts so."""
    value, step = np.array([10.0, 4.0]), np.array([[0.3, -0.3], [-0.2, 0.2], [0.1, -0.1]])
    covariance = np.array([[0.04, -0.038], [-0.038, 0.04]])
    stderr = np.sqrt(np.diag(covariance))
    parts = [Part(i, i + 1.0, value + each, stderr, covariance) for i, each in enumerate(step)]
    gradient = np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]])
    followed = [part.following(value, gradient) for part in parts]
    assert followed[0].value == pytest.approx([0.3, -0.6, 0.0], abs=1e-12)
    assert followed[0].stderr == pytest.approx([0.2, 0.4, math.sqrt(0.004)])
    own = model_discrepancy(value, parts)
    found = model_discrepancy(np.zeros(3), followed)
    assert found == pytest.approx([own[0], 2 * own[1], 0.0], abs=1e-12)


@pytest.mark.parametrize("differs", [{"thickness_m": 0.02}, {"rub_nm": 4e-3}])
def test_a_law_that_does_not_explain_its_run_is_uncertain_by_more_than_the_noise(differs):
    fit = fit_run("hunt_crossley", BLOCK, measured(**differs))
    assert fit.diagnostics["noise"] == 0.0
    assert fit.discrepancy[1] > fit.stderr[1]
    assert np.all((fit.discrepancy[:2] > 0) & (fit.discrepancy[:2] < fit.value[:2]))


def test_a_law_that_lacks_a_number_is_uncertain_though_only_noise_is_left():
    truth = Truth("general", BLOCK, {**SOIL, "c": 100.0}, 0.8 * THETA0, SIGMA)
    motion = virtual_motion(truth, np.random.default_rng(1), still_s=(1.5, 1.5))
    fit = fit_run("hunt_crossley", BLOCK, motion)
    assert fit.diagnostics["noise"] == 1.0 and fit.diagnostics["added_damping"] > 3
    off = abs(fit.value[1] - truth.parameters["lambda"])
    assert off > 10 * fit.stderr[1] and off < 1.96 * fit.discrepancy[1]
