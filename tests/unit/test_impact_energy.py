"""Restitution by energy under a fitted law: against true energies of motions whose impacts scatter."""

from itertools import pairwise

import numpy as np
import pytest

from freerock.identification.fit import fit_record
from freerock.models.block import Block
from freerock.models.block_on_bed import energy
from freerock.models.laws import GEOMETRIC, Foundation
from freerock.models.simulate import Solver, simulate, simulate_fitted
from freerock.noise.spectrum import white_noise
from freerock.populations.impact_energy import impact_energy, of_measured
from freerock.runs.motion import Motion

BLOCK, LAW, THETA0 = Block(0.28, 0.07, 5.84), {"k": 2.86e6, "lambda": 8.16e7}, 0.1745
TIME, SIGMA, N = np.arange(0, 4, 5e-4), 1e-4, 8


def measured(theta, draw):
    known = TIME >= 0.03
    noisy = theta + SIGMA * draw.standard_normal(TIME.size)
    noise = white_noise(SIGMA, 2000.0)
    return Motion(TIME[known], noisy[known], SIGMA, THETA0, SIGMA / 30, 1e-4, noise=noise)


def true_restitutions(motion):
    """√ of the ratio of energies at the samples nearest to the tops; their kinetic energy is left out."""
    ends = np.searchsorted(TIME, np.append(0.0, motion.impacts[: N + 1]))
    tops = [first + int(np.argmax(np.abs(motion.theta[first:last]))) for first, last in pairwise(ends)]
    still = np.zeros(len(tops))
    at = np.array(tops)
    found = energy(
        BLOCK, Foundation.of(LAW), motion.z_cb[at], motion.z_cb_rate[at], motion.theta[at], still, GEOMETRIC
    )
    return np.sqrt(found[1:] / found[:-1])


@pytest.mark.parametrize("sigma_r", [0.0, 0.01])
def test_true_energies_lie_within_the_uncertainty(sigma_r):
    draw, scores = np.random.default_rng(2), []
    motions, truth = {}, {}
    for run in (1, 2, 3):
        law = {**LAW, "impacts": sigma_r * draw.standard_normal(30)[:N]}
        motion = simulate("hunt_crossley", BLOCK, law, TIME, theta0=THETA0, solver=Solver(1e-9))
        motions[run], truth[run] = measured(motion.theta, draw), motion
    for run, fit in fit_record("hunt_crossley", BLOCK, motions).items():
        found = impact_energy(fit, BLOCK, truth[run].impacts[:N])
        assert found.time_s == pytest.approx(truth[run].impacts[:N], abs=2e-4)
        u = np.hypot(found.u_total, 2e-5)  # tops between samples
        scores.append((found.restitution - true_restitutions(truth[run])) / u)
        assert (found.u_total[:4] < 2e-3).all()
    assert np.sqrt(np.mean(np.square(scores))) < 1.5 and np.abs(scores).max() < 4


def test_a_rigid_blocks_impacts_scatter_about_its_r():
    draw, r = np.random.default_rng(4), 0.92
    delta = 0.01 * draw.standard_normal(30)
    theta = simulate_fitted("housner", BLOCK, {"r": r, "impacts": delta, "theta0": THETA0}, TIME)
    fit = fit_record("housner", BLOCK, {1: measured(theta, draw)})[1]
    found = impact_energy(fit, BLOCK, np.linspace(0.2, 2.0, N))
    off = (found.restitution - r * (1 + delta[:N])) / found.u_total
    assert np.abs(off).max() < 4 and (found.u_total < 5e-3).all()
    beyond = impact_energy(fit, BLOCK, np.linspace(0.2, 3.9, 60))  # later ones than the fit knows
    assert beyond.u_total[-1] == pytest.approx(r * fit.scatter.of_record.sigma_r, rel=0.05)


def test_measured_impacts_belong_to_the_nearest_of_the_law():
    """An impact that the law lacks belongs to none, nor does one that another is nearer to."""
    law_s = np.array([0.3, 0.7, 1.0])
    assert of_measured(np.array([0.301, 0.69, 0.99, 1.4]), law_s).tolist() == [0, 1, 2, -1]
    assert of_measured(np.array([0.3, 0.45]), law_s).tolist() == [0, -1]
    assert of_measured(np.array([0.3]), np.empty(0)).tolist() == [-1]
