"""Overturning of Housner's block by a pulse, against an independent integration."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from freerock.models.block import GRAVITY, Block
from freerock.models.ground import pulse
from freerock.models.simulate import Solver, simulate

pytestmark = pytest.mark.slow

BLOCK = Block(0.28, 0.07, 5.84)
LIFT_OFF = GRAVITY * BLOCK.b / BLOCK.h


def overturns(block, r, amplitude, period_s, rtol=1e-10):
    """Whether a horizontal pulse ẍ_g = A sin(2π t/T), 0 < t < T, overturns Housner's block at rest.

    `solve_ivp` (DOP853) with terminal events at impacts, up to the end of the pulse; then by energy. The
    block lifts off where |ẍ_g| passes g b/h (Housner 1963).

    """
    omega, lift_off = 2 * math.pi / period_s, GRAVITY * math.tan(block.theta_cr)

    def ground(t):
        return amplitude * math.sin(omega * t)

    t, theta, rate = 0.0, 0.0, 0.0
    while True:
        if theta == 0 and abs(rate) < 1e-9:
            # at rest until the ground's acceleration passes the threshold again
            turn = math.asin(min(1.0, lift_off / amplitude))
            if not abs(ground(t)) > lift_off:
                starts = [(turn + n * math.pi) / omega for n in (0, 1)]
                t = next((start for start in starts if start > t), math.inf)
            if amplitude <= lift_off or t >= period_s:
                return False
            sign, rate = math.copysign(1.0, math.sin(omega * t)), 0.0
        else:
            sign = math.copysign(1.0, theta or rate)
        result = to_the_next_impact(block, ground, sign, (t, theta, rate), period_s, rtol)
        if len(result.t_events[1]):
            return True
        if not len(result.t_events[0]):
            return passes_the_top(block, r, *result.y[:, -1])
        t, theta, rate = result.t_events[0][0], 0.0, r * result.y_events[0][0][1]


def to_the_next_impact(block, ground, sign, state, until_s, rtol):
    """Motion on one corner from t, θ, θ̇ until an impact, until the block has fallen, or until an instant."""
    begun, theta, rate = state
    p2, theta_cr = block.p**2, block.theta_cr

    def rates(t, y):
        phi = theta_cr - sign * y[0]
        return y[1], p2 * (math.cos(phi) * ground(t) / GRAVITY - sign * math.sin(phi))

    def impact(t, y):
        return sign * y[0] if t > begun else 1.0

    def fallen(t, y):
        return abs(y[0]) - math.pi / 2

    impact.terminal, impact.direction, fallen.terminal, fallen.direction = True, -1, True, 1
    atol = rtol * np.array([theta_cr, block.p * theta_cr])
    span, events = (begun, until_s), (impact, fallen)
    return solve_ivp(rates, span, (theta, rate), "DOP853", rtol=rtol, atol=atol, events=events)


def passes_the_top(block, r, theta, rate):
    """Whether a block left alone turns over: θ̇²/2 + p² cos φ stays between impacts, and is p² at the top."""
    p2, theta_cr = block.p**2, block.theta_cr
    sign = math.copysign(1.0, theta or rate)
    phi = theta_cr - sign * theta
    outward, passes = sign * rate >= 0, 0.5 * rate**2 > p2 * (1 - math.cos(phi))
    if passes and not outward:
        at_impact = 0.5 * rate**2 + p2 * (math.cos(phi) - math.cos(theta_cr))
        return bool(r * r * at_impact > p2 * (1 - math.cos(theta_cr)))
    return bool(passes or phi < 0)


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
    independent = [[overturns(BLOCK, BLOCK.restitution_housner, a, t) for t in periods] for a in amplitudes]
    assert found == independent
    assert 0.3 < np.mean(found) < 0.8


@pytest.mark.parametrize("amplitude", [0.5, 0.999])
def test_a_pulse_below_the_threshold_moves_nothing(amplitude):
    assert outcome(amplitude * LIFT_OFF, 0.5) != "overturned"
    assert not overturns(BLOCK, 0.9, amplitude * LIFT_OFF, 0.5)
