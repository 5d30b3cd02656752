"""Virtual runs of the Monte-Carlo studies: noise, imperfect blocks, truths."""

import numpy as np
import pytest

from freerock.models.simulate import Solver, simulate
from freerock.studies.model_error import imperfect_motion
from freerock.studies.virtual_run import Truth, draw_truth, noise
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS

pytestmark = pytest.mark.slow

BLOCK, THETA0, _ = CONFIGURATIONS["config3"]
TRUTH = Truth("hunt_crossley", BLOCK, FOUNDATIONS["marble"], THETA0, 1e-4)


@pytest.mark.parametrize("kind, slow", [("white", 0.0), ("coloured", 0.5), ("mains and drift", 0.2)])
def test_noise_has_the_stated_spread_and_colour(kind, slow):
    truth = Truth(**{**vars(TRUTH), "noise": kind})
    samples = noise(truth, 400_000, np.random.default_rng(1)) / truth.sigma_theta
    total = {"white": 1.0, "coloured": 1.0, "mains and drift": np.sqrt(1.5)}[kind]
    assert samples.std() == pytest.approx(total, rel=0.03)
    correlation = samples[1:] @ samples[:-1] / (samples @ samples)
    assert correlation > slow - 0.1 if slow else abs(correlation) < 0.01


def test_an_imperfect_block_without_imperfection_follows_the_law():
    time_s, theta = imperfect_motion(TRUTH, "none")
    exact = simulate("hunt_crossley", BLOCK, TRUTH.parameters, time_s, theta0=THETA0, solver=Solver(1e-9))
    assert np.max(np.abs(theta - exact.theta)) < 1e-4 * THETA0
    for imperfection in ("centre", "uneven", "amplitude"):
        _, other = imperfect_motion(TRUTH, imperfection)
        assert np.max(np.abs(other - theta)) > 1e-2 * THETA0


def test_truths_are_drawn_from_the_whole_range():
    generator = np.random.default_rng(1)
    drawn = [draw_truth("winkler", ("white",), generator) for _ in range(500)]
    k = np.array([truth.parameters["k"] for truth in drawn])
    ratio = np.array([truth.parameters["c"] for truth in drawn]) / k
    assert 1e6 <= k.min() < 1.1e6 and 9e7 < k.max() <= 1e8
    assert 1e-3 <= ratio.min() < 1.1e-3 and 1.8e-2 < ratio.max() <= 2e-2
    assert {truth.block for truth in drawn} == {block for block, *_ in CONFIGURATIONS.values()}
