"""Signals of nonsense: each stage must answer or refuse with the project's error, in little time and memory.

python -m freerock_bench.fuzz_signals            # 10 000 signals per stage
python -m freerock_bench.fuzz_signals 500        # fewer
"""

import sys
from contextlib import suppress
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "unit"))

from nonsense import random_signal

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.impacts import find_impacts
from freerock.runs.segment import find_runs
from freerock_bench.fuzz import tried

BLOCK = Block(0.28, 0.07, 5.84)
KINDS = ("noise", "walk", "steps", "swing", "spoilt", "runs")
SCALES = (1e-12, 1e-3, 0.1, 1.0, 3.0, 1e3, 1e300)


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
    """Volts of one laser, or of two, to θ(t)."""
    time_s, values = signal(draw)
    lasers = [Laser("horizontal", y, 0.1, units=draw.choice(["V", "mA", "mm", "deg"])) for y in (0.2, 0.1)]
    if draw.integers(3) == 0:
        find_rotation(time_s, [values, values[::-1]], lasers, BLOCK)
    else:
        find_rotation(time_s, values + draw.choice([0.0, 5.0]), lasers[0], BLOCK)


def of_runs(draw):
    """θ(t) to runs."""
    time_s, values = signal(draw)
    flags = (draw.random(values.size) < draw.choice([0, 0.01, 0.5])).astype(np.uint8)
    find_runs(time_s, values, draw.choice([0.0, 1e-4, 1e-2]), flags, BLOCK)


def of_impacts(draw):
    """θ(t) of a run to impacts."""
    time_s, values = signal(draw)
    theta0 = draw.choice([None, 0.1, -2.0])
    find_impacts(time_s, values, draw.choice([0.0, 1e-4, 1e-2]), BLOCK, theta0=theta0)


def main(n: int) -> int:
    """Try so many signals of each stage; return how many were neither answered nor refused."""
    np.seterr(all="ignore")
    faults = 0
    for stage in (of_rotation, of_runs, of_impacts):
        kind = stage.__name__.removeprefix("of_")
        with suppress(FreerockError):
            stage(np.random.default_rng(0))  # loads what is compiled
        faults += tried(kind, iter(range(n)), n, lambda seed, go=stage: go(np.random.default_rng(seed)))
    return faults


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000) > 0)
