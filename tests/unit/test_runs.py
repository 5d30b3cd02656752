"""Runs found in records of known make: rest, tilt by hand, hold, release, rocking to rest, pause."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.block_on_bed import State
from freerock.models.housner import housner_motion, housner_swings
from freerock.models.laws import Foundation
from freerock.models.simulate import simulate
from freerock.rotation.flags import Fault, SignalQuality, signal_quality
from freerock.runs.runs import find_runs

BLOCK = Block(0.28, 0.07, 5.84)
SIGMA = math.radians(0.005)
RATE_HZ = 1000.0
RAW = Path(__file__).parents[2] / "raw/palermo_virtual"


def one_run(
    theta0_deg=10.0, r=0.9, rate0=0.0, tilt_s=1.5, hold_s=1.5, pause_s=1.5, creep_deg=0.0, rest_deg=0.0
):
    """θ [rad] from the start of the tilt to the end of the pause, and the instant of release [s]."""
    theta0 = math.radians(theta0_deg)
    release = tilt_s + hold_s
    swings = housner_swings(BLOCK, r, theta0)
    t = np.arange(round((release + swings.rest_time + pause_s) * RATE_HZ)) / RATE_HZ
    theta = housner_motion(swings, t - release, theta0, rates=False)[0]
    if rate0:
        start = State(0.0, 0.0, theta0, rate0)
        theta = simulate("housner", BLOCK, {"r": r}, t - release, theta0=start).theta
    tilt, hold = t < tilt_s, (t >= tilt_s) & (t < release)
    theta[tilt] = theta0 * np.sin(np.pi / 2 * t[tilt] / tilt_s) ** 2
    theta[hold] += math.radians(creep_deg) * (t[hold] - release)
    theta[t > release] += math.radians(rest_deg) * np.minimum(1, t[t > release] - release)
    return theta, release


def record(*runs, rest_s=1.0, seed=1):
    """Arguments of find_runs and the releases [s]; one run by default."""
    parts, releases, clock = [np.zeros(round(rest_s * RATE_HZ))], [], rest_s
    for theta, release in runs or [one_run()]:
        releases.append(clock + release)
        parts.append(theta)
        clock += theta.size / RATE_HZ
    theta = np.concatenate(parts)
    theta += SIGMA * np.random.default_rng(seed).standard_normal(theta.size)
    return [np.arange(theta.size) / RATE_HZ, theta, SIGMA, np.zeros(theta.size, np.uint8), BLOCK], releases


def test_every_run_is_found_and_timed():
    angles = (10.0, -9.0, 11.0, 6.0)
    arguments, releases = record(
        *(one_run(angle, r) for angle, r in zip(angles, (0.95, 0.9, 0.8, 0.7), strict=True))
    )
    found = find_runs(*arguments)
    assert [run.number for run in found] == [1, 2, 3, 4]
    for run, release, angle in zip(found, releases, angles, strict=True):
        assert run.verdict.level == "ok" and run.verdict.texts == () and not run.excluded
        assert abs(run.release_s - release) < 1e-3
        assert 0 < run.release_stderr_s < 2e-3
        assert run.fit_start_s == run.release_s + 0.03
        assert run.hold_start_s == pytest.approx(release - 1.5, abs=0.3)
        assert math.degrees(run.theta0) == pytest.approx(angle, abs=5 * math.degrees(run.theta0_stderr))
        assert 0 < math.degrees(run.theta0_stderr) < 1e-3
        assert run.sigma_theta == pytest.approx(SIGMA, rel=0.1)
        assert run.n_impacts >= 5


def test_end_is_where_the_motion_is_lost_in_noise():
    arguments, (release,) = record(one_run(r=0.85))
    (run,) = find_runs(*arguments)
    swings = housner_swings(BLOCK, 0.85, math.radians(10))
    visible = swings.impact_time[swings.peak > 6 * SIGMA][-1]
    assert release + visible <= run.end_s <= release + swings.rest_time + 0.01


def test_a_tilt_in_steps_and_a_hand_in_the_beam():
    theta, release = one_run()
    paused = np.full(round(0.8 * RATE_HZ), math.radians(4))
    ramp = math.radians(4) * np.linspace(0, 1, 500)
    arguments, (release,) = record((np.concatenate([ramp, paused, theta]), release + 0.5 + 0.8))
    hand = (arguments[0] > 1.1) & (arguments[0] < 1.4)
    arguments[1][hand] = np.nan
    arguments[3][hand] = 1
    (run,) = find_runs(*arguments)
    assert abs(run.release_s - release) < 1e-3
    assert run.verdict.level == "ok"


@pytest.mark.parametrize(
    ("run", "expected", "reason"),
    [
        (one_run(rate0=-0.2), "warn", "pushed: it moves as if released from an angle +"),
        (one_run(theta0_deg=-10, rate0=0.2), "warn", "pushed: it moves as if released from an angle +"),
        (one_run(creep_deg=0.2), "warn", "the held angle wanders by 0.19"),
        (one_run(rest_deg=0.08), "warn", "the rest position has moved by +0.08"),
    ],
)
def test_faults_of_a_run(run, expected, reason):
    (found,) = find_runs(*record(run)[0])
    assert found.verdict.level == expected
    assert reason in found.verdict.texts[0]


def test_faults_of_the_signal_count_against_the_runs_they_meet():
    arguments, (first, second) = record(one_run(), one_run())
    faults = (
        Fault("rest_shift", second - 1, second + 1, "+0.01 V", math.radians(0.06)),
        Fault("rest_shift", second - 1, second + 1, "laser at 0.06 m: +0.01 V", math.radians(-0.07)),
        Fault("drift", second - 1, second + 1, "+0.001 V", math.radians(0.01)),
        Fault("drift", second - 1, second + 1, "laser at 0.06 m: -0.01 V", math.radians(0.08)),
        Fault("mains_interference", 0.0, 99.0, "50 Hz"),
    )
    one, two = find_runs(*arguments, SignalQuality(faults=faults))
    assert one.verdict.level == "ok"
    assert two.verdict.texts == (
        "the rest position has moved by +0.060°: the block may have slid or twisted",
        "the rest position has moved by -0.070° (by the laser at 0.06 m): the block may have slid or twisted",
        "the zero drifts by +0.080° (by the laser at 0.06 m)",
    )
    _, two = find_runs(*arguments, SignalQuality(faults=(Fault("aliasing", first + 3, 99.0, "120 Hz"),)))
    assert (two.verdict.level, two.verdict.texts) == ("warn", ("aliasing: 120 Hz",))


def invalid(arguments, at_s):
    """Flag the sample at an instant: no angle, no σ."""
    t, theta, sigma, flags = arguments[:4]
    at = np.searchsorted(t, at_s)
    theta[at], sigma[at], flags[at] = np.nan, np.nan, 1


def caught(after_s, stands_s, braked_to=0.0):
    """A run whose block is stopped, or slowed to a share of its rate, and then free again."""
    theta, release = one_run(r=0.95)
    at = round((release + after_s) * RATE_HZ)
    rate = (theta[at + 1] - theta[at - 1]) / 2 * RATE_HZ
    n = round(stands_s * RATE_HZ)
    if braked_to:
        again = one_run(math.degrees(theta[at]), r=0.95, rate0=braked_to * rate, tilt_s=0.0, hold_s=0.0)[0]
        return np.concatenate([theta[:at], again]), release
    slows = theta[at] + rate * 0.015 * (1 - (1 - np.arange(30) / 30) ** 2)
    again = one_run(math.degrees(slows[-1]), r=0.95, tilt_s=0.0, hold_s=0.0)[0]
    return np.concatenate([theta[:at], slows, np.full(n, slows[-1]), again]), release


@pytest.mark.parametrize("stands_s", [0.08, 0.2, 0.35])
@pytest.mark.parametrize("after_s", [0.1, 0.2])
def test_a_caught_block_is_released_where_it_is_let_go_again(after_s, stands_s):
    arguments, (release,) = record(caught(after_s, stands_s))
    (run,) = find_runs(*arguments)
    again = release + after_s + 0.03 + stands_s
    assert abs(run.release_s - again) < 4e-3
    assert run.theta0 == pytest.approx(arguments[1][round((again - 0.01) * RATE_HZ)], abs=4 * SIGMA)
    assert run.verdict.level == "ok"
    if stands_s > 0.3:
        return  # long enough for a hold like any other
    assert run.verdict.names == ("let_go_again",)
    stood_until = float(re.search(r"stood still until (.+) s:", run.verdict.texts[0])[1])
    assert abs(stood_until - again) < 0.025


@pytest.mark.parametrize("flagged_s", [None, 0.024, 0.05])
def test_a_braked_block_rocks_freely_from_its_first_peak_on(flagged_s):
    arguments, (release,) = record(caught(0.15, 0.0, braked_to=0.2))
    fell_deg = 10 - math.degrees(arguments[1][round((release + 0.15) * RATE_HZ)])
    if flagged_s:
        arguments[2] = np.full(arguments[0].size, SIGMA)
        invalid(arguments, release + flagged_s)
    (run,) = find_runs(*arguments)
    assert run.verdict.level == "warn" and run.verdict.names[0] == "braked"
    assert f"was braked at {release + 0.15:.2f} s" in run.verdict.texts[0]
    told = float(re.search(r"it fell by (.+)° and", run.verdict.texts[0])[1])
    assert told == pytest.approx(fell_deg, abs=0.2)
    near = np.abs(arguments[0] - run.release_s) < 5e-3
    assert run.theta0 < 0 and run.theta0 == pytest.approx(np.mean(arguments[1][near]), rel=2e-3)


@pytest.mark.slow
@given(st.integers(0, 10**6), st.floats(4, 12), st.floats(0.6, 0.98), st.floats(0, 0.05))
@settings(max_examples=40, deadline=None)
def test_a_free_block_never_stops(seed, theta0_deg, r, creep_deg):
    (run,) = find_runs(*record(one_run(theta0_deg, r, creep_deg=creep_deg), seed=seed)[0])
    assert not {"let_go_again", "braked"} & {*run.verdict.names}


def test_no_release():
    quiet = record()[0]
    quiet[1] = SIGMA * np.random.default_rng(0).standard_normal(quiet[1].size)
    swept = f"{math.degrees(np.ptp(quiet[1])):.2g}"
    with pytest.raises(
        FreerockError, match=rf"^record: nothing moves: the signal stays within {swept}°; chec"
    ):
        find_runs(*quiet)
    lifted = [*quiet]
    lifted[1] = quiet[1] + np.where(quiet[0] > 3, 0.1, 0)
    with pytest.raises(
        FreerockError, match=r"^record: no release found: nowhere is the block held, let go and left to rock"
    ):
        find_runs(*lifted)
    restless = [*quiet]
    restless[1] = np.cumsum(quiet[1] * 100)
    with pytest.raises(FreerockError, match=r"^record: no release found: the signal never stands still"):
        find_runs(*restless)


def test_held_beyond_the_critical_angle_and_overturned():
    arguments, (release,) = record()
    theta = arguments[1]
    theta[arguments[0] > release] = np.nan
    theta *= 1.5
    with pytest.raises(FreerockError, match=r"held at 15\.0.°, beyond the block's critical angle 14\.04°"):
        find_runs(*arguments)


@pytest.mark.parametrize("lost", [False, True])
def test_a_block_that_overturns_is_no_run(lost):
    """Pushed over after a good run; lying still, or out of the sensor's sight."""
    theta, release = one_run()
    n, start = round(RATE_HZ), round(release * RATE_HZ)
    falls = math.radians(10) - math.radians(75) * np.linspace(0, 1, n) ** 2
    over = np.concatenate([theta[:start], falls, np.full(2 * n, falls[-1])]), release
    arguments, (first, second) = record(one_run(), over)
    if lost:
        arguments[3][np.abs(arguments[1]) > math.radians(20)] = 1
    (run,) = find_runs(*arguments)
    assert run.verdict.level == "ok" and abs(run.release_s - first) < 1e-3 and run.end_s < second


@pytest.mark.parametrize(
    "parameters", [{"k": 7e6, "lambda": 3e7}, {"k": 7e6, "lambda": 2e7}, {"k": 3e7, "lambda": 1e8}]
)
def test_a_squat_block_that_bounces(parameters):
    block, theta0 = Block(0.10, 0.12, 3.0), math.radians(15)
    t = np.arange(0, 4, 1 / RATE_HZ)
    response = simulate("hunt_crossley", block, parameters, t, theta0=theta0)
    assert np.any(response.contact == 2)  # in flight
    hold = np.full(1500, theta0)
    tilt = theta0 * np.sin(np.linspace(0, np.pi / 2, 1500)) ** 2
    swing = np.concatenate([tilt, hold, response.theta])
    arguments, releases = record((swing, 3.0), (-swing, 3.0), (swing, 3.0))
    runs = find_runs(*arguments[:4], block)
    assert [abs(run.release_s - at) < 5e-3 for run, at in zip(runs, releases, strict=True)] == [True] * 3
    assert all(run.verdict.level != "fail" for run in runs), [run.verdict.texts for run in runs]
    assert all(run.n_impacts > 3 for run in runs)


@settings(deadline=None, derandomize=True, max_examples=25)
@given(
    levels=arrays(float, st.integers(1, 60), elements=st.floats(-1, 1)),
    lengths=st.lists(st.integers(1, 900), min_size=1, max_size=60),
    scale=st.floats(1e-6, 3),
    noise=st.sampled_from([0.0, 1e-4, 1e-2]),
    hole=st.integers(0, 4000),
    ring=st.booleans(),
)
def test_any_signal_is_answered_or_refused(levels, lengths, scale, noise, hole, ring):
    parts = []
    for level, length in zip(levels, lengths, strict=False):
        n = np.arange(length)
        parts.append(level * np.exp(-n / 80) * np.cos(n / 9) if ring else np.full(length, level))
        parts.append(np.full(length, level))
    theta = scale * np.concatenate(parts)
    theta += noise * np.random.default_rng(theta.size).standard_normal(theta.size)
    flags = np.zeros(theta.size, np.uint8)
    flags[hole : hole + 200] = 1
    try:
        runs = find_runs(np.arange(theta.size) / 500, theta, noise, flags, BLOCK)
    except FreerockError:
        return
    assert all(np.isfinite([run.release_s, run.theta0, run.sigma_theta]).all() for run in runs)


@pytest.mark.slow
@pytest.mark.parametrize("test", sorted(path.stem for path in RAW.glob("*.tdms")))
def test_virtual_campaign(test):
    from freerock.records.read import read_record
    from freerock.rotation.rotation import find_rotation
    from freerock.rotation.sensor import Laser
    from freerock.rotation.view import View

    truth = json.loads((RAW / "truth.json").read_text(encoding="utf-8"))[test]
    volts = read_record(RAW / f"{test}.tdms")
    (channel,) = volts.data_vars
    block = Block(**truth["block"])
    laser = Laser(**truth["laser"])
    view = View(block, laser)
    signal = find_rotation(volts["time"].values, volts[channel].values, laser, block)
    names = ("time", "theta", "sigma_theta", "flags")
    found = find_runs(*(signal[name].values for name in names), block, signal_quality(signal))
    assert len(found) == len(truth["runs"]) == 3
    for run, true in zip(found, truth["runs"], strict=True):
        assert run.verdict.level == "ok", run.verdict.texts
        begin, fade = true["release_s"], true["fade_s"]
        assert begin <= run.release_s <= begin + fade + 2 / truth["sampling_rate_hz"]
        assert run.release_s == pytest.approx(begin + fade / 2, abs=4 * run.release_stderr_s)
        assert run.fit_start_s > begin + fade
        soil, held = Foundation(true["k"]), true["theta0_rad"]
        assert view.released(run.theta0, block, soil) == pytest.approx(held, abs=4 * run.theta0_stderr)


def bounced_once(offset_deg=0.0, bounces=True):
    """A run whose block comes back over the same corner at its first impact, and the release [s]."""
    theta, release = one_run()
    after = np.flatnonzero(theta < 0)[0]
    theta[after:] *= -1.0 if bounces else 1.0
    theta[: round((release + 1.0) * RATE_HZ)] += math.radians(offset_deg)
    return theta, release


def test_a_block_that_comes_back_over_the_same_corner_bounced():
    arguments, _ = record(bounced_once())
    (run,) = find_runs(*arguments)
    assert ("bounced", run.verdict.level) == (run.verdict.names[0], "warn")


@pytest.mark.parametrize("offset_deg", [-0.3, 0.0, 0.3])
def test_a_zero_that_is_off_makes_no_bounce(offset_deg):
    arguments, _ = record(bounced_once(offset_deg, bounces=False))
    (run,) = find_runs(*arguments)
    assert "bounced" not in run.verdict.names
