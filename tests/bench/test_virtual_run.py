"""Virtual runs of the Monte-Carlo studies: noise, truths."""

import numpy as np
import pytest

from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.truths import place, published, table_2
from freerock_bench.virtual_run import CORRELATED_S, RATE_HZ, Truth, noise

pytestmark = pytest.mark.slow

BLOCK, THETA0, _ = CONFIGURATIONS["config3"]
TRUTH = Truth("hunt_crossley", BLOCK, FOUNDATIONS["marble"], THETA0, 1e-4)


@pytest.mark.parametrize(
    "kind, slow",
    [
        ("white", 0.0),
        ("coloured", 0.5),
        ("2 ms", 0.8),
        ("20 ms", 0.9),
        ("mains", 0.1),
    ],
)
def test_noise_has_the_stated_spread_and_colour(kind, slow):
    truth = Truth(**{**vars(TRUTH), "noise": kind})
    samples = noise(truth, 400_000, np.random.default_rng(1)) / truth.sigma_theta
    total = {"mains": 1.25}.get(kind, 1.0)
    assert samples.std() == pytest.approx(np.sqrt(total), rel=0.03)
    correlation = samples[1:] @ samples[:-1] / (samples @ samples)
    assert correlation > slow - 0.1 if slow else abs(correlation) < 0.01


@pytest.mark.parametrize("kind", CORRELATED_S)
def test_correlated_noise_has_the_stated_correlation_time(kind):
    truth = Truth(**{**vars(TRUTH), "noise": kind})
    samples = noise(truth, 2_000_000, np.random.default_rng(2))
    lag = int(CORRELATED_S[kind] * RATE_HZ)
    correlation = samples[lag:] @ samples[:-lag] / (samples @ samples)
    assert correlation == pytest.approx(np.exp(-1), abs=0.05)


def test_a_truth_moves_as_its_candidate_does():
    time_s = np.linspace(0.0, 1.0, 500)
    pivoting = Truth("hunt_crossley_pivoting", BLOCK, FOUNDATIONS["marble"], THETA0, 1e-4)
    theta, outcome = pivoting.motion(time_s)
    exact = simulate(
        "hunt_crossley",
        BLOCK,
        pivoting.parameters,
        time_s,
        theta0=THETA0,
        rules=Rules(kinematics="pivoting"),
        solver=Solver(1e-10),
    )
    assert outcome == "completed" and np.array_equal(theta, exact.theta)
    assert not np.allclose(theta, TRUTH.motion(time_s)[0], atol=1e-3 * THETA0)


def test_published_truths_stand_in_six_scenes_on_the_width_they_are_given():
    scenes = {place(i) for i in range(6)}
    assert len(scenes) == 6 and place(6) == place(0)
    truth = published("winkler", "pivoting", 4, np.random.default_rng(1), width_fraction=0.9)
    block, foundation = place(4)
    assert truth.model == "winkler_pivoting" and truth.parameters == table_2("winkler", foundation)
    assert truth.nominal == CONFIGURATIONS[block][0]
    assert 2 * truth.block.b == pytest.approx(0.9 * truth.nominal.width_m)
    both = table_2("general", foundation)
    assert both["c"] == table_2("winkler", foundation)["c"] / 2
    assert both["lambda"] == table_2("hunt_crossley", foundation)["lambda"] / 2
