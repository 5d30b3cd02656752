"""The mishaps of the virtual laboratory are what they are called."""

import math

import numpy as np
import pytest

from freerock.models.contact import Foundation, State, contact_force, energy, static_depth
from freerock.rotation.beam import rotation_from_displacement
from freerock.virtual_lab.noise import Noise
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock.virtual_lab.record import Recording, Release, Scene, free_rocking, simulate_record
from freerock_bench import moves as mishaps

BLOCK, ANGLE, LASER = CONFIGURATIONS["config2"]
MARBLE = FOUNDATIONS["marble"]
SCENE = Scene("hunt_crossley", BLOCK, MARBLE)
SOIL = Foundation.of(MARBLE)
START = State(static_depth(BLOCK, SOIL, ANGLE), 0.0, ANGLE, 0.0)
SINCE = np.arange(4000) / 2000
FREE = free_rocking(SCENE, SINCE, START)


def energies(motion):
    return energy(BLOCK, SOIL, motion.z_cb, motion.z_cb_rate, motion.theta, motion.theta_rate)


@pytest.mark.parametrize(
    "moves",
    [
        mishaps.off_level(0.0),
        mishaps.pushed(0.0),
        mishaps.hit(0.5, 0.0),
        mishaps.braked(0.1, 0.0),
        mishaps.rounded(1e-6),
    ],
)
def test_without_its_cause_the_block_rocks_freely(moves):
    motion = moves(SCENE, SINCE, START)
    assert motion.theta == pytest.approx(FREE.theta, abs=2e-6)
    assert motion.time is SINCE and motion.theta_rate.shape == SINCE.shape


def test_off_level_one_side_gains_what_the_other_loses_and_the_block_stands_at_zero():
    right, left = (mishaps.off_level(tilt)(SCENE, np.arange(0, 12, 1e-3), START) for tilt in (3e-3, -3e-3))
    assert right.theta.min() > FREE.theta.min() + 1e-3 > left.theta.min() + 2e-3
    assert np.abs(right.theta[-500:]).max() < 2e-5


def test_a_blow_and_a_brake_change_the_rate_there_and_nothing_before():
    at = 0.6
    hit, braked = mishaps.hit(at, 0.05)(SCENE, SINCE, START), mishaps.braked(at, 0.4)(SCENE, SINCE, START)
    first = np.searchsorted(SINCE, at)
    for motion in (hit, braked):
        assert np.array_equal(motion.theta[:first], FREE.theta[:first])
        assert motion.theta[first] == pytest.approx(FREE.theta[first], abs=1e-8)
    assert hit.theta_rate[first] == pytest.approx(FREE.theta_rate[first] + 0.05, abs=1e-6)
    assert braked.theta_rate[first] == pytest.approx(0.6 * FREE.theta_rate[first], abs=1e-6)
    assert energies(braked)[first] < energies(FREE)[first]


def test_a_block_caught_stands_and_is_let_go_again():
    motion = mishaps.caught(0.12, 0.5)(SCENE, SINCE, START)
    held = (SINCE > 0.12 + mishaps.STOP_S) & (SINCE < 0.12 + mishaps.STOP_S + 0.5)
    assert np.ptp(motion.theta[held]) == 0 and 0 < motion.theta[held][0] < ANGLE
    assert np.abs(np.diff(motion.theta)).max() < 1.01 * np.abs(FREE.theta_rate).max() / 2000
    assert motion.impacts[0] > 0.12 + mishaps.STOP_S + 0.5


def test_a_push_adds_energy_whichever_way_the_block_leans():
    for sign in (1, -1):
        start = START._replace(theta=sign * ANGLE)
        motion = mishaps.pushed(0.06)(SCENE, SINCE, start)
        assert motion.theta_rate[0] == pytest.approx(sign * 0.06)
        assert sign * motion.theta[:20].max(initial=-1) >= sign * ANGLE - 1e-12 or sign < 0


@pytest.mark.parametrize(
    "state", [State(1e-3, 0.1, 0.05, 0.3), State(5e-5, 0.01, -1e-4, 0.1), State(-4e-3, 0, -0.2, 1)]
)
def test_the_law_on_hardly_rounded_edges_is_the_law(state):
    found = mishaps._on_rounded(BLOCK, SOIL, state, 1e-7)
    assert found == pytest.approx(contact_force(BLOCK, SOIL, state), rel=1e-6, abs=1e-6)


def test_rounded_edges_turn_nearer_to_the_middle():
    """At rest on one edge of a rounded base the force stands nearer to the middle, ρ sinθ of a rigid one."""
    theta, radius, stiff = 0.1, 2e-3, Foundation(1e12)
    flat = BLOCK.b - radius
    u = flat + radius * math.sin(theta)
    touching = radius * (1 / math.cos(theta) - 1)  # z at which the edge would just touch, less its slope
    depths = -u * math.sin(theta) + radius - math.sqrt(radius**2 - (u - flat) ** 2)
    force, moment = mishaps._on_rounded(BLOCK, stiff, State(depths + 1e-7, 0.0, theta, 0.0), radius)
    assert touching > 0 and force > 0
    assert moment / force / math.cos(theta) == pytest.approx(u, abs=2e-5)


def test_a_sinking_corner_reads_as_a_higher_beam():
    silent = Noise(white_v=0.0, mains_v=0.0, drift_v=0.0, bits=32)
    records = [
        simulate_record(
            BLOCK,
            LASER,
            "hunt_crossley",
            [Release(ANGLE, MARBLE, fade_s=0.0)],
            seed=1,
            recording=Recording(noise=silent, corner_sinks=sinks),
        )
        for sinks in (False, True)
    ]
    seen = [
        float(rotation_from_displacement((each.volts[9000] - 5.0) / 100, BLOCK, LASER)) for each in records
    ]
    depth = static_depth(BLOCK, SOIL, ANGLE) + BLOCK.b * math.sin(ANGLE)
    assert seen[0] == pytest.approx(ANGLE, abs=2e-6)
    assert seen[1] / seen[0] - 1 == pytest.approx(depth / LASER.position, rel=0.1)
    assert records[0].volts[100] == records[1].volts[100]
