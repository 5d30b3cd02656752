"""Signals of nonsense: each stage must answer or refuse with the project's error, in little time and memory.

python -m freerock_bench.fuzz_signals            # 10 000 signals per stage
python -m freerock_bench.fuzz_signals 500        # fewer
"""

import resource
import sys
import time
from collections import Counter
from pathlib import Path
from signal import ITIMER_PROF, setitimer

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "unit"))

from nonsense import random_signal

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.impacts import find_impacts
from freerock.runs.segment import find_runs

BLOCK = Block(0.28, 0.07, 5.84)
KINDS = ("noise", "walk", "steps", "swing", "spoilt", "runs")
SCALES = (1e-12, 1e-3, 0.1, 1.0, 3.0, 1e3, 1e300)
MEMORY_BYTES = 1 << 30
SECONDS = 10  # of processor time for one signal; a longer one ends the process


def signal(draw):
    """Time [s] and a signal: nonsense, or rests, holds and swings strung together at random."""
    kind, n = KINDS[draw.integers(len(KINDS))], int(draw.integers(2, 8000))
    if kind == "runs":
        parts = [np.zeros(200)]
        while sum(map(len, parts)) < n:
            k, level = np.arange(draw.integers(50, 1500)), draw.standard_normal()
            held = np.full(draw.integers(1, 900), level)
            parts += [held, level * np.exp(-k / draw.uniform(20, 400)) * np.cos(k / draw.uniform(5, 60))]
        base = np.concatenate(parts)[:n] + draw.choice([0, 1e-4, 1e-2]) * draw.standard_normal(n)
    else:
        base = random_signal(kind, n, draw)
    return np.arange(n) / draw.choice([50.0, 500.0, 5000.0]), SCALES[draw.integers(len(SCALES))] * base


def of_rotation(draw):
    time_s, values = signal(draw)
    lasers = [Laser("horizontal", y, 0.1, units=draw.choice(["V", "mA", "mm", "deg"])) for y in (0.2, 0.1)]
    if draw.integers(3) == 0:
        find_rotation(time_s, [values, values[::-1]], lasers, BLOCK)
    else:
        find_rotation(time_s, values + draw.choice([0.0, 5.0]), lasers[0], BLOCK)


def of_runs(draw):
    time_s, values = signal(draw)
    flags = (draw.random(values.size) < draw.choice([0, 0.01, 0.5])).astype(np.uint8)
    find_runs(time_s, values, draw.choice([0.0, 1e-4, 1e-2]), flags, BLOCK)


def of_impacts(draw):
    time_s, values = signal(draw)
    theta0 = draw.choice([None, 0.1, -2.0])
    find_impacts(time_s, values, draw.choice([0.0, 1e-4, 1e-2]), BLOCK, theta0=theta0)


def main(n: int) -> int:
    """Print what the stages did; return how often they did something else than answer or refuse."""
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))
    faults = 0
    for stage in (of_rotation, of_runs, of_impacts):
        outcomes, slowest = Counter(), 0.0
        for seed in range(n):
            draw, started = np.random.default_rng(seed), time.process_time()
            setitimer(ITIMER_PROF, SECONDS)
            try:
                with np.errstate(all="ignore"):
                    stage(draw)
                outcomes["answered"] += 1
            except FreerockError as error:
                outcomes["refused" if "\n" not in str(error) else "of several lines"] += 1
            except Exception as error:
                outcomes[type(error).__name__] += 1
                print(f"  {stage.__name__}, seed {seed}: {error!r}", flush=True)
            slowest = max(slowest, time.process_time() - started)
        faults += sum(count for what, count in outcomes.items() if what not in ("answered", "refused"))
        counts = ", ".join(f"{count} {what}" for what, count in sorted(outcomes.items()))
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(f"{stage.__name__[3:]}: {counts}; slowest {slowest:.2f} s, memory {peak:.2f} GB", flush=True)
    return faults


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000) > 0)
