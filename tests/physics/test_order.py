"""Order of convergence across impacts: located changes of contact keep it, steps over them lose it.

The series of free rocking have order 9, the pair that takes over where corners may pull has 5.
"""

import math

import numpy as np
import pytest

from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock.virtual_lab.published import TABLE_2
from freerock_bench.methods.by_name import METHODS
from freerock_bench.methods.problem import Problem

BLOCK, _, _ = CONFIGURATIONS["config2"]
LAWS = {law: TABLE_2["marble"][law] for law in ("hunt_crossley", "winkler")}
ANGLES = [math.radians(angle) for angle in (4, 5, 6, 7, 8, 9, 10, 11, 12)]
TIME = np.linspace(0, 1.5, 301)  # three to six impacts


def motion(law, angle, debonding, rtol):
    response = simulate(
        law, BLOCK, LAWS[law], TIME, theta0=angle, rules=Rules(debonding), solver=Solver(rtol)
    )
    assert len(response.impacts) >= 3
    return response.theta, response.statistics["steps"]


def observed_order(run, settings, law, debonding):
    """Slope of the logarithms of error over work, their means over the angles of release."""
    work, error = np.empty((2, len(ANGLES), len(settings)))
    for i, angle in enumerate(ANGLES):
        true, _ = motion(law, angle, debonding, 3e-14)
        for j, setting in enumerate(settings):
            theta, work[i, j] = run(angle, setting)
            error[i, j] = math.sqrt(np.mean((theta - true) ** 2))
    return -np.polyfit(np.log(work).mean(axis=0), np.log(error).mean(axis=0), 1)[0]


@pytest.mark.parametrize(("debonding", "least"), [("geometric", 9 - 0.7), ("tensionless", 5 - 0.3)])
@pytest.mark.parametrize("law", LAWS)
def test_order_across_impacts(law, debonding, least):
    def run(angle, rtol):
        return motion(law, angle, debonding, rtol)

    assert observed_order(run, 10.0 ** np.arange(-8, -10.1, -0.5), law, debonding) > least


@pytest.mark.parametrize("law", LAWS)
def test_fourth_order_is_lost_where_steps_run_over_impacts(law):
    def run(angle, step):
        solution = METHODS["RK4"](Problem(law, BLOCK, LAWS[law], angle), TIME, step)
        return solution.theta, solution.evaluations

    assert observed_order(run, [2e-4, 1e-4, 5e-5, 2e-5], law, "geometric") < 4 - 0.5
