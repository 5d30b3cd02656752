"""Runs that begin in motion, and blocks that bounce."""

import math

import numpy as np
import pytest

from freerock.config.keys_of_processing import RunLimits
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.bouncing import RIGHT, bounce, standing_on
from freerock.models.housner import housner_motion, housner_swings
from freerock.runs.begun_in_motion import LocalFit, Position, let_go
from freerock.runs.segment import find_runs

SLENDER = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
SQUARE = Block(height_m=0.06, width_m=0.06, mass_kg=0.05)
SIGMA = 1e-4
MOVING = RunLimits(start="motion")
SHORT = RunLimits(start="motion", window_s=0.04, min_impacts=0)


def cut(at_s, theta0_deg=10.0, r=0.9, rate_hz=500.0):
    """A record of Housner's block that begins so long after its release and ends at rest."""
    time = np.arange(0, 4, 1 / rate_hz)
    swings = housner_swings(SLENDER, r, math.radians(theta0_deg))
    theta = np.nan_to_num(housner_motion(swings, time + at_s, math.radians(theta0_deg), 0.0)[0])
    return time, theta + np.random.default_rng(3).normal(0, SIGMA, time.size)


def runs(time, theta, block=SLENDER, limits=MOVING, position=None):
    return find_runs(time, theta, SIGMA, np.zeros(time.size), block, limits=limits, position=position)


@pytest.mark.parametrize("at_s", [0.0, 0.1, 0.25])
def test_the_release_is_that_of_the_motion_before(at_s):
    theta0 = math.radians(10)
    swings = housner_swings(SLENDER, 0.9, theta0)
    theta, rate = housner_motion(swings, np.array([at_s]), theta0, 0.0)
    height, before_s = let_go(LocalFit(float(theta[0]), float(rate[0]), 0.0), SLENDER)
    assert height == pytest.approx(theta0, rel=1e-9)
    assert before_s == pytest.approx(at_s, abs=1e-6)


def test_what_is_thrown_in_was_not_let_go():
    assert let_go(LocalFit(0.2, -10.0, 0.0), SLENDER) is None


@pytest.mark.parametrize("at_s", [0.08, 0.2, 0.33, 0.55, 0.8])
def test_a_record_that_is_cut_in_mid_swing_is_a_run_as_if_let_go(at_s):
    """Of a swing that rises, the run begins at its top."""
    (run,) = runs(*cut(at_s))
    swings = housner_swings(SLENDER, 0.9, math.radians(10))
    which = int(np.searchsorted(swings.impact_time, at_s))
    assert run.theta0 == pytest.approx(swings.sign[which] * swings.peak[which], rel=0.03)
    assert run.release_s + at_s == pytest.approx(swings.peak_time[which], abs=0.012)
    assert run.fit_start_s >= max(0.0, run.release_s - 0.01)
    assert run.verdict.level == "ok"
    assert "in_motion" in run.verdict.names


def test_such_a_record_has_no_run_that_begins_with_a_hold():
    with pytest.raises(FreerockError, match="no release found"):
        runs(*cut(0.2), limits=RunLimits())


def test_a_square_that_turns_back_over_its_corner_bounced_and_a_slender_block_did_not():
    time = np.arange(0, 1.2, 1 / 500)
    start = standing_on(SQUARE, RIGHT, math.radians(30), -2.0)
    theta = bounce(SQUARE, 0.4, 0.05, start, time).theta
    theta = theta + np.random.default_rng(2).normal(0, SIGMA, time.size)
    (run,) = runs(time, theta, SQUARE, SHORT)
    assert "bounced" in run.verdict.names
    assert run.verdict.level == "warn"
    (run,) = runs(*cut(0.2))
    assert "bounced" not in run.verdict.names


@pytest.mark.parametrize("offset_deg", [-0.3, 0.3])
def test_a_zero_that_is_off_makes_no_bounce(offset_deg):
    time, theta = cut(0.2)
    (run,) = runs(time, theta + math.radians(offset_deg) * (time < 1.5))
    assert "bounced" not in run.verdict.names


def test_a_run_begins_when_the_block_has_come_down_and_says_that_it_slides():
    time = np.arange(0, 1.4, 1 / 500)
    x, z, *others = standing_on(SQUARE, RIGHT, math.radians(25), -1.0)
    found = bounce(SQUARE, 0.1, 0.02, (x, z + 0.03, others[0], 0.6, 0.0, others[3]), time)
    position = Position(found.state[:, 0], found.state[:, 1])
    (run,) = runs(time, found.theta, SQUARE, SHORT, position)
    landed = found.impact_time_s[0]
    assert run.fit_start_s > 0.5 * landed
    assert "slid" in run.verdict.names
    (run,) = runs(time, found.theta, SQUARE, SHORT)
    assert run.fit_start_s < 0.5 * landed


def test_the_shape_of_the_block_is_asked_for():
    time, theta = cut(0.2)
    with pytest.raises(FreerockError, match="give the block"):
        find_runs(
            time, theta, SIGMA, np.zeros(time.size), limits=MOVING.model_copy(update={"min_impacts": 1})
        )
