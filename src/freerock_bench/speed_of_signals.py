"""The way from a recorded channel to impacts: speed and memory, of 10 min at 10 kHz on 4 channels.

python -m freerock_bench.speed_of_signals
"""

import math
import resource
import time

import numpy as np

from freerock.models.block import Block
from freerock.models.housner import housner_motion, housner_swings
from freerock.rotation.beam import displacement_from_rotation
from freerock.rotation.faults import signal_quality
from freerock.rotation.reading import pieces
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.impacts import find_impacts
from freerock.runs.segment import find_runs
from freerock_bench.analysed import signal_of

BLOCK = Block(0.28, 0.07, 5.84)
LASERS = Laser("horizontal", 0.2, 0.1), Laser("horizontal", 0.1, 0.1)
NOISE_V, COUNT_V = 2e-3, 21 / 2**16


def motion(draw, rate_hz, n_runs):
    """θ [rad] of a record: rest, then tilt, hold, rigid rocking, pause."""
    parts = [np.zeros(round(2 * rate_hz))]
    for _ in range(n_runs):
        theta0 = math.radians(draw.uniform(4, 11)) * draw.choice([-1, 1])
        tilt, hold, pause = draw.uniform(0.8, 2), draw.uniform(1, 3), draw.uniform(1, 3)
        swings = housner_swings(BLOCK, draw.uniform(0.75, 0.95), theta0)
        n = round((tilt + hold + swings.rest_time + pause) * rate_hz)
        t = np.arange(n) / rate_hz
        theta = housner_motion(swings, t - tilt - hold, theta0, rates=False)[0]
        share = np.clip(t / tilt, 0, 1)
        theta[t < tilt + hold] = (theta0 * share**2 * (3 - 2 * share))[t < tilt + hold]
        parts.append(theta)
    return np.concatenate(parts)


def volts_of(theta, draw, laser=LASERS[0]):
    volts = np.empty(theta.size)
    for part in pieces(theta.size):  # lest what makes a long record holds more than what is measured
        exact = 5 + displacement_from_rotation(theta[part], BLOCK, laser) / laser.metres_per()
        volts[part] = np.rint((exact + NOISE_V * draw.standard_normal(exact.size)) / COUNT_V) * COUNT_V
    return volts


def runs_of(time_s, volts, lasers=LASERS[:1]):
    """Runs of one laser or two, and the time, θ and σ_θ they were found in."""
    found = find_rotation(time_s, volts, lasers, BLOCK)
    t, theta, sigma, flags = signal_of(found)
    runs = find_runs(t, theta, sigma, flags, BLOCK, signal_quality(found))
    return runs, (t, theta, sigma)


def impacts_of(runs, series):
    """The number of impacts in all runs."""
    number = 0
    for run in runs:
        during = slice(*np.searchsorted(series[0], (run.release_s, run.end_s)))
        held = {"theta0": run.theta0, "theta0_stderr": run.theta0_stderr}
        number += find_impacts(*(each[during] for each in series), block=BLOCK, **held).time_s.size
    return number


def speed(rate_hz=10_000.0, minutes=10, channels=4):
    draw = np.random.RandomState(1)
    theta = motion(draw, rate_hz, 60)
    n = round(60 * minutes * rate_hz)
    theta = np.concatenate([theta, np.zeros(max(0, n - theta.size))])[:n]
    time_s = np.arange(n) / rate_hz
    runs_of(time_s[: n // 50], volts_of(theta[: n // 50], draw))  # imports, caches
    for kind, lasers in (("single lasers", LASERS[:1]), ("pairs of lasers", LASERS)):
        wall = busy = 0.0
        for _ in range(channels // len(lasers)):
            volts = [volts_of(theta, draw, laser) for laser in lasers]
            started, busy_before = time.perf_counter(), time.process_time()
            runs, series = runs_of(time_s, volts, lasers)
            number = impacts_of(runs, series)
            wall += time.perf_counter() - started
            busy += time.process_time() - busy_before
            n_runs = len(runs)
            del volts, runs, series
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(
            f"{channels} channels of {n} samples, {kind}: each {n_runs} runs, {number} impacts; in all "
            f"{wall:.2f} s, {busy:.2f} s of processor (aim 4 s), memory {peak:.2f} GB (aim 0.7 GB)",
            flush=True,
        )


if __name__ == "__main__":
    speed()
