"""Speed and memory of the way from a recorded channel to impacts, and how well runs are found.

python benchmarks/signals.py                 # both parts
python benchmarks/signals.py speed           # 10 min at 10 kHz, 4 channels: aim 5 s, 1 GB
python benchmarks/signals.py segmentation    # 1000 records of 1 to 12 runs: every run, none invented
"""

import math
import resource
import sys
import time

import numpy as np

from freerock.beam import displacement_from_rotation
from freerock.faults import listed_faults
from freerock.impacts import find_impacts
from freerock.laser import Laser
from freerock.models.block import Block
from freerock.models.housner import housner_lobes, housner_motion
from freerock.rotation import rotation
from freerock.runs import find_runs

BLOCK = Block(0.28, 0.07, 5.84)
LASERS = Laser("horizontal", 0.2, 0.1), Laser("horizontal", 0.1, 0.1)
NOISE_V, COUNT_V = 2e-3, 21 / 2**16


def motion(draw, rate_hz, n_runs):
    """θ [rad] of a record, and its releases [s]: rest, then tilt, hold, finger, rigid rocking, pause."""
    parts, releases, clock = [np.zeros(round(2 * rate_hz))], [], 2.0
    for _ in range(n_runs):
        theta0 = math.radians(draw.uniform(4, 11)) * draw.choice([-1, 1])
        tilt, hold, pause = draw.uniform(0.8, 2), draw.uniform(1, 3), draw.uniform(1, 3)
        lobes = housner_lobes(BLOCK, draw.uniform(0.75, 0.95), theta0)
        n = round((tilt + hold + lobes.rest_time + pause) * rate_hz)
        t = np.arange(n) / rate_hz
        theta = housner_motion(lobes, t - tilt - hold, theta0, rates=False)[0]
        share = np.clip(t / tilt, 0, 1)
        theta[t < tilt + hold] = (theta0 * share**2 * (3 - 2 * share))[t < tilt + hold]
        parts.append(theta)
        releases.append(clock + tilt + hold)
        clock += n / rate_hz
    return np.concatenate(parts), releases


def volts_of(theta, draw, laser=LASERS[0]):
    volts = 5 + displacement_from_rotation(theta, BLOCK, laser) / laser.metres_per()
    return np.rint((volts + NOISE_V * draw.standard_normal(theta.size)) / COUNT_V) * COUNT_V


def analyse(time_s, volts, lasers=LASERS[:1]):
    """Runs of one laser or two, and the number of impacts."""
    found = rotation(time_s, volts, lasers, BLOCK)
    t, theta, sigma, flags = (found[name].values for name in ("time", "theta", "sigma_theta", "flags"))
    runs = find_runs(t, theta, sigma, flags, BLOCK, found.attrs["zero_stderr_rad"], listed_faults(found))
    number = 0
    for run in runs:
        during = slice(*np.searchsorted(t, (run.release_s, run.end_s)))
        number += find_impacts(
            t[during], theta[during], sigma[during], BLOCK, theta0=run.theta0, theta0_stderr=run.theta0_stderr
        ).time_s.size
    return runs, number


def speed(rate_hz=10_000.0, minutes=10, channels=4):
    draw = np.random.RandomState(1)
    theta, _ = motion(draw, rate_hz, 60)
    n = round(60 * minutes * rate_hz)
    theta = np.concatenate([theta, np.zeros(max(0, n - theta.size))])[:n]
    time_s = np.arange(n) / rate_hz
    analyse(time_s[: n // 50], volts_of(theta[: n // 50], draw))  # imports, caches
    for kind, lasers in (("single lasers", LASERS[:1]), ("pairs of lasers", LASERS)):
        wall = busy = 0.0
        for _ in range(channels // len(lasers)):
            volts = [volts_of(theta, draw, laser) for laser in lasers]
            started, busy_before = time.perf_counter(), time.process_time()
            runs, number = analyse(time_s, volts, lasers)
            wall += time.perf_counter() - started
            busy += time.process_time() - busy_before
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(
            f"{channels} channels of {n} samples, {kind}: each {len(runs)} runs, {number} impacts; in all "
            f"{wall:.2f} s, {busy:.2f} s of processor (aim 5 s), memory {peak:.2f} GB (aim 1 GB)",
            flush=True,
        )


def segmentation(records=1000, rate_hz=1000.0):
    missed = invented = late = runs_in_all = 0
    worst = 0.0
    for seed in range(records):
        draw = np.random.RandomState(seed)
        theta, releases = motion(draw, rate_hz, draw.randint(1, 13))
        runs, _ = analyse(np.arange(theta.size) / rate_hz, volts_of(theta, draw))
        runs_in_all += len(releases)
        near = [min((abs(run.release_s - at) for run in runs), default=math.inf) for at in releases]
        missed += sum(distance > 0.5 for distance in near)
        invented += max(0, len(runs) - len(releases))
        late += sum(2 / rate_hz < distance <= 0.5 for distance in near)
        worst = max([worst, *(distance for distance in near if distance <= 0.5)])
    print(f"{records} records, {runs_in_all} runs: {missed} missed, {invented} invented")
    print(f"{late} released more than two samples off, the worst {worst * 1e3:.2f} ms")


if __name__ == "__main__":
    parts = {"speed": speed, "segmentation": segmentation}
    for part in sys.argv[1:] or parts:
        parts[part]()
