"""Known numbers of the three models: closed forms, independent trajectories, figures computed elsewhere."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from freerock.identification.epsilon_theta import epsilon_theta
from freerock.models.block import Block
from freerock.models.block_on_bed import static_depth
from freerock.models.housner import housner_swings
from freerock.models.laws import Foundation, Rules
from freerock.models.simulate import Solver, simulate

BLOCKS = {1: Block(0.42, 0.07, 8.67), 2: Block(0.28, 0.07, 5.84), 3: Block(0.14, 0.07, 2.98)}
ALPHA = {1: math.radians(6), 2: math.radians(10), 3: math.radians(20)}
TABLE_2 = {
    ("winkler", "marble"): {"k": 6.77e6, "c": 2.17e4},
    ("winkler", "aerstop"): {"k": 4.50e6, "c": 4.05e4},
    ("hunt_crossley", "marble"): {"k": 6.88e6, "lambda": 1.30e8},
    ("hunt_crossley", "aerstop"): {"k": 2.86e6, "lambda": 8.16e7},
}
BOUND = {"hunt_crossley": 1e-10, "winkler": 1e-8}
SHARED = Path(__file__).parents[3] / "shared/data/trajectories"


@pytest.mark.parametrize(
    "number, radius, theta_cr_deg, p, restitution",
    [
        (1, 0.212897, 9.46232, 5.878692, 0.959459),
        (2, 0.144309, 14.03624, 7.140340, 0.911765),
        (3, 0.078262, 26.56505, 9.695911, 0.700000),
    ],
)
def test_constants_of_the_three_blocks(number, radius, theta_cr_deg, p, restitution):
    block = BLOCKS[number]
    assert pytest.approx(radius, abs=5e-7) == block.R
    assert math.degrees(block.theta_cr) == pytest.approx(theta_cr_deg, abs=5e-6)
    assert block.p == pytest.approx(p, abs=5e-7)
    assert block.restitution_housner == pytest.approx(restitution, abs=5e-7)


@pytest.mark.parametrize("number, quarter_s", [(1, 0.283081), (2, 0.268884), (3, 0.214670)])
def test_quarter_period_of_housner(number, quarter_s):
    swings = housner_swings(BLOCKS[number], 0.9, ALPHA[number], until=0.1)
    assert swings.impact_time[0] == pytest.approx(quarter_s, abs=5e-7)


@pytest.mark.parametrize("r, rest_s", [(0.958, 7.4225), (0.895, 2.8932)])
def test_housner_rests_at_the_zeno_time(r, rest_s):
    assert housner_swings(BLOCKS[2], r, ALPHA[2]).rest_time == pytest.approx(rest_s, abs=5e-5)
    response = simulate("housner", BLOCKS[2], {"r": r}, [0.0, rest_s - 0.01, rest_s + 1e-3], theta0=ALPHA[2])
    assert response.outcome == "at_rest"
    assert response.theta[1] != 0
    assert response.theta[2] == 0


@pytest.mark.parametrize("model", BOUND)
def test_trajectories_of_an_independent_program(model):
    reference = pd.read_csv(Path(__file__).parent / "data/trajectories.csv")
    time, theta = reference["time_s"].to_numpy(), reference[f"theta_{model}_rad"].to_numpy()
    found = simulate(model, BLOCKS[2], TABLE_2[model, "marble"], time, theta0=ALPHA[2], solver=Solver(1e-10))
    assert epsilon_theta(time, found.theta, theta) <= BOUND[model]
    assert np.abs(found.theta - theta).max() < 1e-6


@pytest.mark.skipif(not SHARED.is_dir(), reason="reference trajectories are not at hand")
@pytest.mark.parametrize("model", BOUND)
def test_reference_trajectories(model):
    reference = pd.read_csv(SHARED / f"config2_marble_{model}_geometric.csv")
    time = reference["time_s"].to_numpy()
    found = simulate(model, BLOCKS[2], TABLE_2[model, "marble"], time, theta0=ALPHA[2])
    assert epsilon_theta(time, found.theta, reference["theta_rad"]) <= BOUND[model]
    assert found.z_cb[0] == pytest.approx(reference["z_cb_m"][0], rel=1e-9)


def test_edge_penetration_at_the_release():
    depth = static_depth(BLOCKS[2], Foundation(6.88e6), ALPHA[2]) + BLOCKS[2].b * math.sin(ALPHA[2])
    assert depth == pytest.approx(1.70e-3, abs=5e-6)


@pytest.mark.parametrize(
    "number, model, foundation, percent",
    [
        (2, "hunt_crossley", "marble", 0.002),
        (2, "hunt_crossley", "aerstop", 0.083),
        (2, "winkler", "marble", 27.8),
        (2, "winkler", "aerstop", 16.4),
        (3, "hunt_crossley", "marble", 5.1),
        (3, "hunt_crossley", "aerstop", 12.3),
        (3, "winkler", "marble", 19),
        (3, "winkler", "aerstop", 25),
    ],
)
def test_debonding_rules_differ_by_the_known_amount(number, model, foundation, percent):
    time = np.arange(0, 8, 1e-3)
    geometric, tensionless = (
        simulate(
            model, BLOCKS[number], TABLE_2[model, foundation], time, theta0=ALPHA[number], rules=Rules(rule)
        ).theta
        for rule in ("geometric", "tensionless")
    )
    assert 100 * epsilon_theta(time, tensionless, geometric) == pytest.approx(percent, rel=0.03, abs=6e-4)


@pytest.mark.parametrize(
    "foundation, peaks_deg",
    [("marble", [7.9027, 6.5832, 5.5949, 4.8059]), ("aerstop", [5.547, 3.641, 2.479, 1.716])],
)
def test_first_peaks_of_hunt_crossley(foundation, peaks_deg):
    time = np.arange(0, 3, 1e-4)
    theta = simulate(
        "hunt_crossley", BLOCKS[2], TABLE_2["hunt_crossley", foundation], time, theta0=ALPHA[2]
    ).theta
    inner = np.abs(theta[1:-1])
    peaks = inner[(inner > np.abs(theta[:-2])) & (inner >= np.abs(theta[2:]))][: len(peaks_deg)]
    digits = len(str(peaks_deg[0]).split(".")[1])
    assert np.round(np.degrees(peaks), digits) == pytest.approx(peaks_deg, abs=1.01 * 10**-digits)
