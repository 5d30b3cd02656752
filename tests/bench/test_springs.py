"""The second simulator against the models where these know the case, and in its limits."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from freerock.models.ground import tilted
from freerock.models.laws import GEOMETRIC, Rules
from freerock.models.simulate import Solver, simulate
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock.virtual_lab.published import TABLE_2
from freerock_bench.springs import Motion, Scene, energy

pytestmark = pytest.mark.usefixtures("springs")

BLOCK, ANGLE, LASER = CONFIGURATIONS["config2"]
SOIL = TABLE_2["aerstop"]["hunt_crossley"]
RATE_HZ, N = 1000.0, 1500
CLOSE = math.radians(0.006) / 20  # of the noise
AT_ONCE_S = 1e-7  # the finger


def theta(block=BLOCK, soil=SOIL, pivoting=False, **how):
    scene = Scene(block, dict(soil), pivoting, 0.8 * ANGLE, AT_ONCE_S, **how)
    found = Motion(scene, RATE_HZ, N / RATE_HZ).theta[:N]
    return np.pad(found, (0, N - len(found)))


@cache
def as_paper():
    """By the law alone, of what is besides nothing."""
    return known()


def known(law="hunt_crossley", block=BLOCK, soil=SOIL, rules=GEOMETRIC, **how):
    time_s, solver = np.arange(N) / RATE_HZ, Solver(1e-10)
    return simulate(law, block, soil, time_s, theta0=0.8 * ANGLE, rules=rules, solver=solver, **how).theta


@pytest.mark.parametrize("kinematics", ["guided", "pivoting"])
@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
def test_with_nothing_besides_it_is_the_law(law, kinematics):
    soil = TABLE_2["aerstop"][law]
    expected = known(law, soil=soil, rules=Rules("geometric", kinematics))
    assert np.abs(theta(soil=soil, pivoting=kinematics == "pivoting") - expected).max() < CLOSE


def test_a_rigid_block_is_housners():
    soil = {"r": 0.93}
    for block in (BLOCK, replace(BLOCK, com_offset_m=1e-3, com_height_m=0.13)):
        assert np.abs(theta(block, soil, True) - known("housner", block, soil)).max() < CLOSE


@pytest.mark.parametrize(
    "block",
    [
        replace(BLOCK, com_height_m=0.135, com_offset_m=1.5e-3, inertia_kg_m2=0.045),
        replace(BLOCK, edge_radius_m=2e-3),
        replace(BLOCK, contact_width_m=0.066),
    ],
)
def test_blocks_as_they_are(block):
    base = {"radius_m": block.edge_radius_m, "left_m": 0.035 - block.b, "right_m": 0.035 - block.b}
    found = theta(replace(block, edge_radius_m=0.0, contact_width_m=None), base=base)
    assert np.abs(found - known(block=block)).max() < (20 if block.edge_radius_m else 1) * CLOSE


def test_a_base_off_level_and_a_bed_that_cannot_pull():
    tilt = 3e-3
    found = theta(besides={"tilt": tilt})
    assert np.abs(found - known(base_excitation=tilted(tilt, 2.0))).max() < CLOSE
    soil = TABLE_2["aerstop"]["winkler"]
    found = theta(soil=soil, besides={"tensionless": 1.0})
    assert np.abs(found - known("winkler", soil=soil, rules=Rules("tensionless"))).max() < 4 * CLOSE


def test_a_base_slips_where_friction_does_not_hold_it():
    slips = [theta(pivoting=True, besides={"grip": grip}) for grip in (0.1, 10.0, 100.0)]
    assert np.abs(slips[1] - slips[2]).max() < CLOSE < np.abs(slips[0] - slips[2]).max() / 100
    assert np.abs(slips[2] - known(rules=Rules("geometric", "pivoting"))).max() < 400 * CLOSE


@pytest.mark.parametrize(
    "besides",
    [
        {"two_beds": 0.2},
        {"top": 0.2, "top_hz": 40.0},
        {"table_kg": 60.0, "table_x_hz": 20.0},
        {"table_kg": 60.0, "table_y_hz": 30.0},
        {"air_nms2": 0.01},
        {"rub_nm": 0.01},
        {"varies": 0.2},
        {"hysteresis": 0.05},
    ],
    ids=str,
)
def test_what_is_besides_is_seen(besides):
    assert np.abs(theta(besides=besides) - as_paper()).max() > 20 * CLOSE


def test_a_blow_changes_what_follows_alone():
    hit = theta(blow=(0.6, 1.0, 0.05))
    np.testing.assert_allclose(hit[:600], theta()[:600], atol=1e-7)
    rate = np.gradient(hit - theta(), 1 / RATE_HZ)[602:606]
    np.testing.assert_allclose(rate, 0.05, rtol=0.02)
    braked = theta(blow=(0.6, 0.5, 0.0))
    assert np.abs(np.diff(braked)[601]) == pytest.approx(0.5 * np.abs(np.diff(hit)[598]), rel=0.1)


@pytest.mark.parametrize("pivoting", [False, True])
def test_a_bed_without_damping_keeps_the_energy(pivoting):
    base = {"left_m": 1e-3, "right_m": 1e-3}
    scene = Scene(BLOCK, {"k": SOIL["k"]}, pivoting, 0.8 * ANGLE, AT_ONCE_S, base)
    kept = energy(Motion(scene, RATE_HZ, N / RATE_HZ).states, scene)
    lifted = kept[0] - energy(Motion(replace(scene, theta0=0.01), RATE_HZ, 0.1).states, scene)[0]
    assert np.ptp(kept) < 1e-4 * lifted
