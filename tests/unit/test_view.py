"""What a sensor makes of a motion: closed forms, a corner that sinks, derivatives of what is seen."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from freerock.identification.fit import fit_run
from freerock.identification.run_model import Point, RunModel
from freerock.identification.samples import Samples
from freerock.models.block import GRAVITY, Block
from freerock.models.block_on_bed import static_depth
from freerock.models.laws import Foundation
from freerock.rotation.beam import displaced, rotation_from_displacement
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View, as_measured, view_of
from freerock.runs.motion import Motion

BLOCK = Block(0.28, 0.07, 5.84)
SOIL = Foundation(6.88e6, 0.0, 1.3e8)
PARAMETERS = {"k": SOIL.k, "lambda": SOIL.lam}
LEFT = Laser("horizontal", 0.2, 0.1)
BEAMS = {
    "left": LEFT,
    "right": replace(LEFT, face="right"),
    "low": Laser("horizontal", 0.09, 0.1),
    "top": Laser("vertical", 0.02, 0.1),
    "outrigger": Laser("vertical", -0.15, 0.1),
}


def largest(name: str) -> float:
    """An angle [rad] at which the beam is on its target, on either side."""
    return 0.17 if BEAMS[name].beam == "horizontal" else 0.05


def read_by(laser: Laser, theta: float, z_cb: float) -> float:
    """Displacement of the target of a block turned and sunk, by its corners in the plane."""
    right = theta > 0
    turn = np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
    corner = np.array([BLOCK.b if right else -BLOCK.b, -z_cb - BLOCK.b * abs(math.sin(theta))])

    def place(x: float, y: float) -> np.ndarray:
        return corner + turn @ (np.array([x, y]) - [BLOCK.b if right else -BLOCK.b, 0.0])

    if laser.beam == "vertical":
        far = 1.0 if laser.position > 0 else -1.0
        (x0, y0), (x1, y1) = place(-far, BLOCK.height_m), place(far, BLOCK.height_m)
        met = y0 + (y1 - y0) * (laser.position - x0) / (x1 - x0)
        return BLOCK.height_m - met - BLOCK.mass_kg * GRAVITY / (2 * BLOCK.b * SOIL.k)
    side = -BLOCK.b if laser.face == "left" else BLOCK.b
    (x0, y0), (x1, y1) = place(side, 0.0), place(side, BLOCK.height_m)
    met = x0 + (x1 - x0) * (laser.position - y0) / (y1 - y0)
    return (met - side) * (1 if laser.face == "left" else -1)


@pytest.mark.parametrize("name", BEAMS)
@pytest.mark.parametrize("share", [1.0, 0.2, -0.2, -1.0])
def test_a_block_that_sinks_is_seen_where_the_beam_meets_it(name, share):
    laser, theta = BEAMS[name], share * largest(name)
    z_cb = static_depth(BLOCK, SOIL, theta)
    view = View(BLOCK, laser)
    side = math.copysign(1, theta)
    expected = rotation_from_displacement(read_by(laser, theta, z_cb), BLOCK, laser, side)
    seen = view.seen(np.array([[theta]]), np.array([[z_cb]]), BLOCK, SOIL)
    assert_allclose(seen, expected, rtol=1e-11)
    assert abs(seen[0] - theta) > 1e-5  # and it matters


@pytest.mark.parametrize("name", BEAMS)
def test_worn_corners_are_seen_by_the_corners_expected(name):
    worn = replace(BLOCK, contact_width_m=0.06)
    theta = np.linspace(0.01, 0.2, 7)
    side = np.ones(7)
    expected = rotation_from_displacement(displaced(theta, worn, BEAMS[name]), BLOCK, BEAMS[name], side)
    assert_allclose(View(BLOCK, BEAMS[name]).seen(theta[None], theta[None], worn, None), expected, rtol=1e-11)


@pytest.mark.parametrize("name", BEAMS)
@pytest.mark.parametrize("sign", [1, -1])
def test_the_held_angle_is_the_one_that_is_seen(name, sign):
    view, theta0 = View(BLOCK, BEAMS[name]), sign * largest(name)
    true = view.released(theta0, BLOCK, SOIL)
    z_cb = static_depth(BLOCK, SOIL, true)
    assert_allclose(view.seen(np.array([[true]]), np.array([[z_cb]]), BLOCK, SOIL), theta0, rtol=1e-13)


def test_theta0_of_a_fit_is_the_angle_seen_and_its_u_leaves_out_the_laser():
    """The law tells the rotation; what a fit says of θ₀ is the reading, however badly the lever is known."""
    time_s, view, sigma = np.arange(5e-4, 1.5, 5e-4), view_of(LEFT, BLOCK), 1e-4
    seen_at = {**PARAMETERS, "theta0": 0.1715, "t0": 0.0}
    held = view.released(seen_at["theta0"], BLOCK, SOIL)
    theta = as_measured("hunt_crossley", BLOCK, seen_at, time_s, view)
    theta += sigma * np.random.default_rng(1).standard_normal(time_s.size)
    motion = Motion(time_s, theta, sigma, seen_at["theta0"], 1e-4, 1e-4, view=view)
    fits = []
    for u_m in (1e-5, 3e-3):
        laboratory = Laboratory(BLOCK, {"left": LEFT}, (Input("left", "position_m", u_m, True),))
        fits.append(fit_run("hunt_crossley", BLOCK, replace(motion, laboratory=laboratory)).params)
    for params in fits:
        value, u = params["theta0"].value, params["theta0"].stderr
        assert abs(value - seen_at["theta0"]) < 4 * u < (value - held) / 4
        bed = Foundation(params["k"].value, 0.0, params["lambda_"].value)
        assert view.released(value, BLOCK, bed) == pytest.approx(held, abs=4 * u + 1e-4)
    exact, rough = (params["theta0"].stderr for params in fits)
    assert rough < 1.5 * exact < 0.1 * held * 3e-3 / LEFT.position_m  # what the lever does to the rotation


def test_an_averaged_sine_is_smaller():
    rate, time_s, response_s = 2 * math.pi * 40.0, np.linspace(0, 0.1, 50), 4e-3
    beside, weights = View(BLOCK, Laser(units="rad", response_ms=1e3 * response_s)).moments
    found = weights @ np.sin(rate * (time_s + beside[:, None]))
    exact = np.sin(rate * time_s) * np.sinc(rate * response_s / 2 / math.pi)
    assert_allclose(found, exact, rtol=0, atol=2e-6)


@pytest.mark.parametrize("laser", [LEFT, replace(LEFT, response_ms=4.0), Laser(units="deg", response_ms=4.0)])
@pytest.mark.parametrize("law", ["hunt_crossley", "housner"])
def test_derivatives_are_those_of_what_is_seen(laser, law):
    values = (PARAMETERS if law == "hunt_crossley" else {"r": 0.94, "width": 0.068}) | {
        "theta0": 0.17,
        "t0": 0.0,
    }
    time_s, view = np.linspace(0.01, 2, 1500), view_of([laser], BLOCK)
    motion = Motion(time_s, np.zeros(1500), 1e-4, 0.17, view=view)
    model = RunModel("housner_width" if law == "housner" else law, BLOCK, motion)
    own, samples = {name: values[name] for name in model.names}, Samples(time_s, np.zeros(1500))
    at = model.held(Point(own, np.zeros(0), np.array([0.01, -0.02])), samples)
    columns = model.derivatives(at, samples)[: time_s.size]
    for j, name in enumerate([*model.names, "impact"]):
        step = 1e-6 * max(abs(own.get(name, 1.0)), 0.1)
        up, down = (
            model.curve(
                replace(at, rates=at.rates * (1 + np.array([by, 0])))
                if name == "impact"
                else replace(at, values={**own, name: own[name] + by}),
                time_s,
                1e-11,
            )
            for by in (step, -step)
        )
        quotient = (up - down) / (2 * step)
        off = np.abs(columns[:, j] - quotient)  # but beside the impacts of a rigid block
        assert np.quantile(off, 0.9) < 1e-3 * np.abs(quotient).max(), name
