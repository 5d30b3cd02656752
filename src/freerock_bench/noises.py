"""Are the numbers of a run as certain as stated, whatever the noise and the converter?

Ten noises and four converters are put to the volts of records of `scattered` whose inputs are exact and whose
impacts do not scatter; each is a case.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock_bench import campaigns, scattered
from freerock_bench.disturbances import correlated
from freerock_bench.scattered import NOISE_V, RATE_HZ, Truth, runs_of, volts_of

Kind = Callable[[int, Any], Floats]
SEED = 1
RECORDS = {"full": 6, "small": 1}  # of each noise; thirty make a round


def _pink(n: int, draw: Any) -> Floats:
    """Noise of variance 1 whose density falls as 1/f."""
    frequency = np.fft.rfftfreq(2 * n)
    frequency[0] = np.inf
    found = np.fft.irfft(np.fft.rfft(draw.standard_normal(2 * n)) / np.sqrt(frequency))[:n]
    return np.asarray(found / np.std(found))


def _hum(n: int, wanders: float, draw: Any) -> Floats:
    """Mains of half the variance 1/4, whose phase goes at random by so much in a second [rad]."""
    phase = draw.uniform(0, 2 * math.pi) + np.cumsum(draw.standard_normal(n)) * wanders / math.sqrt(RATE_HZ)
    return np.asarray(0.5 * math.sqrt(2) * np.sin(2 * math.pi * 50 * np.arange(n) / RATE_HZ + phase))


def _white(n: int, draw: Any) -> Floats:
    return np.asarray(draw.standard_normal(n))


NOISES: dict[str, Kind] = {  # of so many samples, in standard deviations
    "white": _white,
    "white, ¼ of 50 ms": lambda n, draw: _white(n, draw) + 0.25 * correlated(n, 0.05, RATE_HZ, draw),
    "2 ms": lambda n, draw: correlated(n, 2e-3, RATE_HZ, draw),
    "20 ms": lambda n, draw: correlated(n, 0.02, RATE_HZ, draw),
    "200 ms": lambda n, draw: correlated(n, 0.2, RATE_HZ, draw),
    "hum": lambda n, draw: _white(n, draw) + _hum(n, 0.0, draw),
    "wandering hum": lambda n, draw: _white(n, draw) + _hum(n, 1.0, draw),
    "1/f": _pink,
    "white, ½ of 1/f": lambda n, draw: _white(n, draw) + 0.5 * _pink(n, draw),
    "Student's t₃": lambda n, draw: draw.standard_t(3, n) / math.sqrt(3),
}
CONVERTERS = {f"12 bits, {mv} mV": (12, 1e-3 * mv) for mv in (1, 2, 3)} | {"14 bits, 2 mV": (14, 2e-3)}


def make(folder: Path, case: tuple[str, int]) -> Path:
    """Make the record of a noise or converter and a number, unless it is there."""
    name, i = case
    bits, sigma_v = CONVERTERS.get(name, (24, NOISE_V))
    number = [*NOISES, *CONVERTERS].index(name)
    path = folder / f"noise_{number:02d}_{i:03d}.npz"
    if not path.exists():
        draw = np.random.default_rng([SEED, 35, number, i])
        truth = Truth.drawn(i, 0.0, "exact", draw)
        runs = runs_of(truth, draw, moved=1)
        volts, begins = volts_of(truth, runs, draw, NOISES.get(name, _white), sigma_v, bits)
        known = runs[0].parameters | scattered.impacts_in_volts(runs[0].motion, begins[0], truth.clock)
        more: dict[str, Any] = {"noise": name} | {f"run0_{key}": value for key, value in known.items()}
        scattered.write(path, truth, volts, begins, RATE_HZ, more)
    return path


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table."""
    names = [*NOISES, *CONVERTERS] if size == "full" else ["12 bits, 2 mV"]
    cases = [(name, i) for i in range(RECORDS[size]) for name in names]
    return campaigns.study(folder, make, cases, lambda truth: str(truth["noise"]), cores)


markdown = campaigns.markdown
