"""Runs of a block whose impacts scatter, for tests of the identification."""

import math

import numpy as np

from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, Rules
from freerock.models.simulate import Solver, simulate, simulate_fitted
from freerock.runs.motion import Motion

BLOCK = Block(0.28, 0.07, 5.84)
SIGMA = math.radians(0.006)
TRUTH = {"hunt_crossley": {"k": 2.9e6, "lambda": 8e7}, "winkler": {"k": 4.5e6, "c": 4e4}}
TRUTH |= {"housner": {"r": 0.93}, "hunt_crossley_pivoting": {"k": 2.9e6, "lambda": 8e7}}


def scattered_run(
    candidate, sigma_r, seed, theta0=0.17, block=BLOCK, duration_s=2.2, rate_hz=1000.0, law=None
):
    """A run from rest at t = 0 with white noise: the motion and the true δ, zero where nothing lifts."""
    generator = np.random.default_rng(seed)
    time_s, delta = np.arange(0, duration_s, 1 / rate_hz), sigma_r * generator.standard_normal(40)
    of, law = CANDIDATES[candidate], law or TRUTH[candidate]
    given = {"rules": Rules(kinematics=of.kinematics), "solver": Solver(1e-10)}
    moved = simulate(of.law, block, {**law, "impacts": delta}, time_s, theta0=theta0, **given)
    lifted_s = moved.time[moved.contact != 0][-1]
    delta[int(np.searchsorted(moved.impacts, lifted_s)) + 1 :] = 0.0  # a base that rings hits nothing
    values = {**law, "theta0": theta0, "t0": 0.0, "impacts": delta}
    theta = simulate_fitted(of.law, block, values, time_s, **given)
    noisy = theta + SIGMA * generator.standard_normal(time_s.size)
    measured = theta0 + SIGMA / 30 * generator.standard_normal()
    return Motion(time_s, noisy, SIGMA, measured, SIGMA / 30, 1e-4), delta
