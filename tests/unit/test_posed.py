"""The least-squares problem of a run whose block is a little other than stated; its impacts scatter."""

from dataclasses import replace

import numpy as np
import pytest
from scattered import BLOCK, SIGMA, scattered_run

from freerock.identification.fit import fit_run
from freerock.identification.posed import Ended, Posed, minimised
from freerock.identification.posterior import Posterior
from freerock.identification.run_model import Point, RunModel
from freerock.identification.start import n_lifting
from freerock.noise.spectrum import averaged
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser

LAW, MARBLE, U_M = (
    "hunt_crossley",
    {"k": 6.9e6, "lambda": 1.3e8},
    3e-4,
)  # that of a size that is measured by a rule
INPUTS = tuple(Input("block", name, U_M, True) for name in ("height_m", "width_m"))
LABORATORY = Laboratory(BLOCK, {"laser": Laser(units="rad")}, INPUTS)
OFF = np.array([1.2, -1.5])  # u


def motion_of(seed, sigma_r):
    """A run of a block that is not quite as stated, and its truth."""
    true = replace(BLOCK, height_m=BLOCK.height_m + OFF[0] * U_M, width_m=BLOCK.width_m + OFF[1] * U_M)
    motion, delta = scattered_run(LAW, sigma_r, seed, block=true, duration_s=6.0, rate_hz=2000.0, law=MARBLE)
    values = {**MARBLE, "theta0": motion.theta0, "t0": 0.0}
    return replace(motion, laboratory=LABORATORY), Point(values, OFF, delta)


def posed_of(motion, sigma_r):
    model = RunModel(LAW, BLOCK, motion)
    return Posed(model, replace(model.until(6.0, 10**9), m=4), sigma_r, SIGMA)


def moved(posed, at, i, by):
    """A point beside, by the i-th of names, inputs and impacts."""
    x = np.concatenate([[*at.values.values()], at.inputs, at.impacts])
    x[i] += by
    n = len(at.values)
    return Point(dict(zip(at.values, x[:n].tolist(), strict=True)), x[n : n + 2], x[n + 2 :])


def test_derivatives_are_quotients_to_a_part_in_ten_thousand():
    """What the run tells is the difference of columns that are thousands of times as long."""
    motion, at = motion_of(1, 0.02)
    at, posed = replace(at, impacts=at.impacts[:8]), posed_of(motion, 0.02)
    rows = posed.jacobian(at, posed.model.by_inputs(at, posed.samples, posed.rtol))
    for i, column in enumerate(rows.T):
        step = 0.1 / np.linalg.norm(column)
        ends = [posed.residual(moved(posed, at, i, by)) for by in (step, -step)]
        off = np.linalg.norm((ends[0] - ends[1]) / (2 * step) - column)
        assert off < 2e-4 * np.linalg.norm(column), i


def test_an_input_counts_whatever_others_are_off():
    """A height moves the centre of mass of a block whose centre of mass has its own uncertainty."""
    motion, at = motion_of(1, 0.02)
    names = ("height_m", "com_height_m", "inertia_kg_m2", "position_m", "scale_fraction")
    us = (U_M, U_M, 1e-3 * BLOCK.inertia_cm, 1e-3, 1e-3)
    owners = ("block", "block", "block", "laser", "laser")
    inputs = tuple(map(Input, owners, names, us, [True] * len(names)))
    laser = Laser(beam="horizontal", position_m=0.2, range_m=0.1)
    motion = replace(motion, laboratory=Laboratory(BLOCK, {"laser": laser}, inputs))
    posed, off = posed_of(motion, 0.02), np.array([1.2, -0.7, 0.4, 1.1, -0.9])
    at = posed.model.held(replace(at, inputs=off, impacts=at.impacts[:8]), posed.samples, posed.rtol)
    columns = posed.model.by_inputs(at, posed.samples, posed.rtol)[: posed.samples.measured.size]
    for i, step in enumerate(1e-2 * np.eye(len(names))):
        ends = [posed.model.means(replace(at, inputs=off + by), posed.samples) for by in (step, -step)]
        quotient = (ends[0] - ends[1]) / 2e-2
        assert np.linalg.norm(columns[:, i] - quotient) < 1e-3 * np.linalg.norm(quotient), names[i]


def test_the_time_of_a_sensor_counts_on_below_none():
    """Where none is stated least squares meet no kink: a motion is blurred, or sharper."""
    motion, at = motion_of(1, 0.0)
    inputs = (Input("laser", "response_ms", 2.9, True),)
    posed = posed_of(replace(motion, laboratory=replace(LABORATORY, inputs=inputs)), 0.0)
    blurred, plain, sharper = (
        posed.model.means(replace(at, inputs=np.array([by]), impacts=np.zeros(0)), posed.samples)
        for by in (1.0, 0.0, -1.0)
    )
    assert np.linalg.norm(blurred - plain) > SIGMA
    np.testing.assert_allclose(blurred - plain, plain - sharper, atol=1e-12)
    each = posed.model.curve(replace(at, inputs=np.array([-1.0])), posed.samples.time_s)
    assert np.linalg.norm(averaged(each, posed.samples.m) - sharper) < 0.05 * np.linalg.norm(sharper - plain)


def test_a_search_has_ended_where_nothing_more_is_predicted():
    """One standard uncertainty off the end, the objective is predicted to fall by one."""
    motion, _ = motion_of(1, 0.02)
    fit = fit_run(LAW, BLOCK, motion)
    posed, at = fit.posterior.posed, fit.posterior.at
    assert fit.posterior.ahead < 0.03
    i = list(at.values).index("theta0")
    alone = 1 / np.linalg.norm(fit.posterior.rows[:, i])
    off = Posterior.of(Ended(posed, moved(posed, at, i, alone), fit.result, fit.minimizer))
    assert off.ahead == pytest.approx(1.0, rel=0.3)


def test_a_curve_has_no_jump_where_a_swing_ceases_to_lift():
    """Impacts keep their δ, however small the swing before is."""
    motion, at = motion_of(1, 0.0)
    posed = posed_of(motion, 0.02)
    curves = [
        posed.residual(replace(at, impacts=np.append(np.full(24, delta), np.full(8, 0.1))))
        for delta in np.linspace(-0.01, 0.0, 201)
    ]
    steps = np.linalg.norm(np.diff(curves, axis=0), axis=1)
    assert np.abs(np.diff(np.log(steps))).max() < 5e-3


@pytest.mark.parametrize("seed", [2, 11])
def test_a_fit_ends_in_the_minimum_that_the_truth_lies_in(seed):
    motion, truth = motion_of(seed, 0.03)
    fit = fit_run(LAW, BLOCK, motion)
    posterior, n = fit.posterior, fit.posterior.at.impacts.size
    assert abs(n - np.count_nonzero(truth.impacts)) <= 1  # no δ of a base that rings
    best = minimised(posterior.posed, replace(truth, impacts=truth.impacts[:n]), 100, 1e-10)
    assert fit.result.chisqr < best.result.chisqr + 0.5
    off = fit.values["k"] / best.at.values["k"] - 1
    assert abs(off) < 0.3 * np.sqrt(posterior.covariance[0, 0]) / best.at.values["k"]


def test_a_search_finds_the_rate_after_an_impact_where_its_start_is_half():
    motion, truth = motion_of(1, 0.02)
    posed = posed_of(motion, 0.02)
    truth = replace(truth, impacts=truth.impacts[: n_lifting(posed.model, truth)])
    far = truth.impacts.copy()
    far[-3] = -0.5
    best, found = (minimised(posed, replace(truth, impacts=each), 25, 1e-3) for each in (truth.impacts, far))
    assert found.result.chisqr < best.result.chisqr + 0.5
