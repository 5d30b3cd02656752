"""The least-squares problem of a run whose block is a little other than stated; its impacts scatter."""

from dataclasses import replace

import numpy as np
from scattered import BLOCK, SIGMA, scattered_run

from freerock.identification.posed import Posed
from freerock.identification.run_model import Point, RunModel
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
    _, rows = posed.derived(at)
    for i, column in enumerate(rows.T):
        step = 0.1 / np.linalg.norm(column)
        ends = [posed.residual(moved(posed, at, i, by)) for by in (step, -step)]
        off = np.linalg.norm((ends[0] - ends[1]) / (2 * step) - column)
        assert off < 2e-4 * np.linalg.norm(column), i
