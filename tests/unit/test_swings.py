"""The tilt of the base as the heights of the swings have it."""

import math

import numpy as np
import pytest

from freerock.identification.swings import tilt_of_swings
from freerock.models.contact import Foundation, State, static_depth
from freerock.runs.motion import Motion
from freerock.virtual_lab import mishaps
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock.virtual_lab.record import Scene

SIGMA = math.radians(0.006)
SINCE = np.arange(0, 6, 1e-3)


def run(configuration, foundation, tilt_deg):
    block, angle, _ = CONFIGURATIONS[configuration]
    parameters = FOUNDATIONS[foundation]
    start = State(static_depth(block, Foundation.of(parameters), angle), 0.0, angle, 0.0)
    moves = mishaps.off_level(math.radians(tilt_deg))
    theta = moves(Scene("hunt_crossley", block, parameters), SINCE, start).theta
    noise = SIGMA * np.random.default_rng(7).standard_normal(SINCE.size)
    return block, Motion(SINCE, theta + noise, SIGMA, angle, 1e-5, 2e-4)


@pytest.mark.parametrize("foundation", FOUNDATIONS)
@pytest.mark.parametrize("configuration", CONFIGURATIONS)
@pytest.mark.parametrize("tilt_deg", [0.3, -0.3])
def test_the_heights_of_the_swings_tell_side_and_size_of_a_tilt(configuration, foundation, tilt_deg):
    seen = math.degrees(tilt_of_swings(*run(configuration, foundation, tilt_deg)))
    assert seen == pytest.approx(tilt_deg, abs=0.2)  # a start for fits


def test_a_level_base_shows_hardly_any_and_too_few_swings_none():
    block, motion = run("config2", "marble", 0.0)
    assert abs(math.degrees(tilt_of_swings(block, motion))) < 0.02
    short = Motion(motion.time_s[:400], motion.theta[:400], SIGMA, motion.theta0)
    assert tilt_of_swings(block, short) == 0.0
