"""Overturning of Housner's block by a pulse, against an independent integration."""

import math

import numpy as np
import pytest

from freerock.models.block import GRAVITY, Block
from freerock.models.ground import pulse
from freerock.models.simulate import Solver, simulate
from freerock_bench.methods.housner import housner_overturns

pytestmark = pytest.mark.slow

BLOCK = Block(0.28, 0.07, 5.84)
LIFT_OFF = GRAVITY * BLOCK.b / BLOCK.h


def outcome(amplitude, period):
    time = np.array([0.0, period + 20.0])
    motion = pulse("sine", period, x=amplitude)
    parameters = {"r": BLOCK.restitution_housner}
    return simulate("housner", BLOCK, parameters, time, base_excitation=motion, solver=Solver(1e-9)).outcome


def test_map_of_a_sine_pulse_agrees_to_the_cell():
    """Amplitude in units of g tan θ_cr, circular frequency in units of p: a coarse map."""
    periods = 2 * math.pi / (BLOCK.p * np.linspace(0.5, 10, 12))
    amplitudes = LIFT_OFF * np.linspace(1.01, 12, 12)
    found = [[outcome(a, t) == "overturned" for t in periods] for a in amplitudes]
    independent = [
        [housner_overturns(BLOCK, BLOCK.restitution_housner, a, t) for t in periods] for a in amplitudes
    ]
    assert found == independent
    assert 0.3 < np.mean(found) < 0.8


@pytest.mark.parametrize("amplitude", [0.5, 0.999])
def test_a_pulse_below_the_threshold_moves_nothing(amplitude):
    assert outcome(amplitude * LIFT_OFF, 0.5) != "overturned"
    assert not housner_overturns(BLOCK, 0.9, amplitude * LIFT_OFF, 0.5)
