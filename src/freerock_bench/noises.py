"""Are the numbers of a run as certain as stated, whatever the noise and the converter?

    python -m freerock_bench.noises --per-noise 6 --seed 1

takes records of `scattered` whose inputs are exact and whose impacts do not scatter, puts ten noises and
four converters to their volts, analyses them by the workflow and prints a column for each.
"""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock_bench import campaigns, scattered
from freerock_bench.disturbances import correlated
from freerock_bench.scattered import NOISE_V, RATE_HZ, Truth, runs_of, volts_of

Kind = Callable[[int, Any], Floats]


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


def make(folder: Path, name: str, i: int, seed: int) -> Path:
    """Make the i-th record of a noise or converter, unless it is there."""
    bits, sigma_v = CONVERTERS.get(name, (24, NOISE_V))
    number = [*NOISES, *CONVERTERS].index(name)
    path = folder / f"noise_{number:02d}_{i:03d}.npz"
    if not path.exists():
        draw = np.random.default_rng([seed, 35, number, i])
        truth = Truth.drawn(i, 0.0, "exact", draw)
        runs = runs_of(truth, draw)[:1]
        volts, begins = volts_of(truth, runs, draw, NOISES.get(name, _white), sigma_v, bits)
        more: dict[str, Any] = {"noise": name} | {
            f"run0_{key}": value for key, value in runs[0].parameters.items()
        }
        more |= {"run0_volts_impacts_s": begins[0] + runs[0].held.passages_s}
        more |= {"run0_volts_r_energy": runs[0].held.restitution}
        scattered.write(path, truth, volts, begins, RATE_HZ, more)
    return path


def main(arguments: list[str] | None = None) -> None:
    """Make, analyse, grade, print."""
    parser = argparse.ArgumentParser(prog="python -m freerock_bench.noises")
    parser.add_argument("--per-noise", type=int, default=6, help="records of each; thirty make a round")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cores", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("results/studies/noises"))
    parser.add_argument("--document", default="")
    given = parser.parse_args(arguments)
    cases = [(name, i) for i in range(given.per_noise) for name in (*NOISES, *CONVERTERS)]
    records = campaigns.made(lambda case: make(given.folder / "records", case[0], case[1], given.seed), cases)
    tables = campaigns.analysed(given.folder.resolve(), records, given.cores)
    frame = campaigns.graded(tables, records, lambda truth: str(truth["noise"]))
    campaigns.finish(frame, "noises", given.document)
    print(campaigns.worst(frame))


if __name__ == "__main__":
    main()
