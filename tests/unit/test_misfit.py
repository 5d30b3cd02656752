"""The misfit map: ε_θ around the identified parameters."""

import math

import numpy as np
import pytest

from freerock.identification.epsilon_theta import epsilon_theta
from freerock.models.block import Block
from freerock.models.simulate import simulate_theta
from freerock.populations.misfit import GRID, between_cells, misfit_map

BLOCK = Block(0.28, 0.07, 5.84)
VALUES = {"k": 6.88e6, "lambda": 1.30e8, "theta0": math.radians(10), "t0": 0.0}
TIME = np.arange(0, 2, 2e-3)


def measured(block=BLOCK):
    law = {name: VALUES[name] for name in ("k", "lambda")}
    return simulate_theta("hunt_crossley", block, law, TIME, theta0=VALUES["theta0"])[0]


def test_the_map_is_lowest_at_the_truth_and_rises_around_it():
    found = misfit_map("hunt_crossley", BLOCK, VALUES, TIME, measured())
    assert found["epsilon_theta"].dims == ("lambda", "k")
    assert found["k"].values[GRID.cells // 2] == pytest.approx(VALUES["k"])
    assert found["lambda"].values[[0, -1]] / VALUES["lambda"] == pytest.approx(np.exp([-0.3, 0.3]))
    assert np.unravel_index(found["epsilon_theta"].values.argmin(), (GRID.cells, GRID.cells)) == (
        GRID.cells // 2,
        GRID.cells // 2,
    )
    assert found["epsilon_theta"].min() < 1e-6
    assert found["epsilon_theta"].values[GRID.cells // 2, 0] > 0.1  # k is 26 % too low


def test_rows_are_values_of_the_second_parameter():
    found = misfit_map("hunt_crossley", BLOCK, VALUES, TIME, measured())
    at = {"k": found["k"].values[3], "lambda": found["lambda"].values[20]}
    theta, _ = simulate_theta("hunt_crossley", BLOCK, at, TIME, theta0=VALUES["theta0"])
    exact = epsilon_theta(TIME, theta, measured())
    assert found["epsilon_theta"].values[20, 3] == pytest.approx(exact, rel=1e-3)


def test_contours_between_the_cells_of_a_narrow_trough():
    """θ(t) interpolated: the discrepancy between two cells is known far better than from the cells' own."""
    time_s = np.linspace(0, 4, 801)

    def swing(stiffness, damping):
        return np.exp(-0.4 * (1 + damping) * time_s) * np.cos(9 * (1 + stiffness - damping) * time_s)

    cells, finer = np.linspace(-0.1, 0.1, GRID.cells), np.linspace(-0.1, 0.1, GRID.finer)
    modelled = np.array([[swing(k, damping) for k in cells] for damping in cells])
    found = between_cells(time_s, modelled, swing(0, 0))
    exact = [[epsilon_theta(time_s, swing(k, damping), swing(0, 0)) for k in finer] for damping in finer]
    np.testing.assert_allclose(found, exact, rtol=0.02, atol=1e-5)
    assert np.max(exact) > 0.5
