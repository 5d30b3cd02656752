"""Releases by a hand: it trembles by 0.01° while it holds, and leaves over 20 to 50 ms. Simulated."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import butter, sosfiltfilt

from freerock.models.housner import housner_motion, housner_swings
from freerock.runs.runs import find_runs
from freerock.virtual_lab.published import BLOCKS

RATE_HZ, TILT_S, SIGMA = 2000.0, 1.5, math.radians(0.005)
TREMOR = butter(2, (4, 12), "bandpass", fs=RATE_HZ, output="sos")


def one_run(draw, block):
    """θ [rad] from tilt to rest, when the hand begins to leave, and the top of the free motion [s, rad]."""
    theta_cr, p = block.theta_cr, block.p
    theta0, fade_s = theta_cr * draw.uniform(0.35, 0.7), draw.uniform(0.02, 0.05)
    n = round(RATE_HZ * draw.uniform(1.5, 2.5))
    tremor = sosfiltfilt(TREMOR, draw.standard_normal(n + 2000))[1000 : 1000 + n]
    tremor *= math.radians(0.01) / tremor.std()

    def rates(t, y):
        holds = 0.5 * (1 + math.cos(math.pi * t / fade_s)) * p**2 * math.sin(theta_cr - theta0)
        return [y[1], holds - p**2 * math.sin(theta_cr - y[0])]

    begins = [theta0 + tremor[-1], (tremor[-1] - tremor[-2]) * RATE_HZ]
    leaving = solve_ivp(rates, (0, fade_s), begins, rtol=1e-9, atol=1e-12, dense_output=True)
    leaves = leaving.sol(np.arange(math.ceil(fade_s * RATE_HZ)) / RATE_HZ)[0]
    theta, rate = leaving.y[:, -1]
    # the top from which the block falls as it does then lies before

    def stands(_, y):
        return y[1]

    def falls(_, y):
        return [y[1], -(p**2) * math.sin(theta_cr - y[0])]

    stands.terminal = True
    back = solve_ivp(falls, (0, -1), [theta, rate], rtol=1e-10, atol=1e-13, events=stands)
    top_s, top = back.t_events[0][0], back.y_events[0][0, 0]
    swings = housner_swings(block, 0.92, top)
    t = np.arange(leaves.size, round((fade_s + swings.rest_time + 1.5) * RATE_HZ)) / RATE_HZ
    free = housner_motion(swings, t - fade_s - top_s, top, rates=False)[0]
    share = np.linspace(0, 1, round(TILT_S * RATE_HZ))
    tilt = theta0 * np.sin(np.pi / 2 * share) ** 2 + share**2 * tremor[0]
    parts = np.concatenate([tilt, theta0 + tremor, leaves, free])
    return parts, TILT_S + n / RATE_HZ, fade_s + top_s, top


@pytest.mark.slow
def test_no_run_of_a_hand_is_lost_and_its_release_is_known_as_well_as_it_says():
    blocks, off = list(BLOCKS.values()), []
    for seed in range(16):
        draw, block = np.random.default_rng(seed), blocks[seed % 3]
        parts, truths, clock = [np.zeros(round(RATE_HZ))], [], 1.0
        for _ in range(3):
            theta, leaves_s, top_s, top = one_run(draw, block)
            truths.append((clock + leaves_s + top_s, top))
            parts.append(theta)
            clock += theta.size / RATE_HZ
        theta = np.concatenate(parts)
        theta += SIGMA * draw.standard_normal(theta.size)
        runs = find_runs(np.arange(theta.size) / RATE_HZ, theta, SIGMA, np.zeros(theta.size, int), block)
        assert len(runs) == 3 and {name for run in runs for name in run.verdict.names} <= {"hold_wanders"}
        off += [
            ((run.release_s - at_s) / run.release_stderr_s, (run.theta0 - top) / run.theta0_stderr)
            for run, (at_s, top) in zip(runs, truths, strict=True)
        ]
    of_release, of_angle = np.abs(off).T
    assert np.mean(of_release < 1.96) > 0.85 and of_release.max() < 4
    assert np.mean(of_angle < 1.96) > 0.9 and of_angle.max() < 3
