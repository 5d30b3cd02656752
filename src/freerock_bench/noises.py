"""Are release, release angle and restitution of each impact as certain as stated, whatever the noise?

Records of `studies.integrated`, which share nothing with the laws that are fitted, with sixteen kinds of
noise, as volts through the public way to runs and impacts.

    python -m freerock_bench.noises results/studies/noises.csv full docs/validation.md

measures (`small`: three records of each noise; `full`: 162, in two minutes of processor time) and renews the
table in the documentation, where it is named.
"""

import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.faults import signal_quality
from freerock.rotation.lattice import converter_step
from freerock.rotation.rotation import find_rotation
from freerock.runs.impacts import Impacts
from freerock.runs.judged import judged_runs
from freerock.runs.segment import Run
from freerock_bench.document import publish
from freerock_bench.integrated import RATE_HZ, Truth, laser_of, names_of, truth_of
from freerock_bench.virtual_run import SEED, Row, correlated, rows_of_all

SIZES = {"small": 3, "full": 162}  # records of each noise; eighteen make a round of scenes
SIGMA_V = 2e-3
ALIKE_S = 0.02  # between an impact found and that of the truth
NORMAL_95 = 1.96
COLUMNS = ["noise", "record", "scene", "level", "names", "number", "impact", "error", "stderr", "inside"]
MARK = ("<!-- noises -->\n", "<!-- end of the noises -->\n")
Kind = Callable[[Floats, Any, Floats], Floats]


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


def _rate(theta: Floats) -> Floats:
    rate = np.abs(np.gradient(theta))
    return np.asarray(rate / rate.max())


def _white(theta: Floats, draw: Any) -> Floats:
    return np.asarray(draw.standard_normal(len(theta)))


NOISES: dict[str, Kind] = {  # in standard deviations of the noise, of the rotation and a generator
    "white": lambda theta, draw, moving: _white(theta, draw),
    "white, ¼ of 50 ms": lambda theta, draw, moving: (
        _white(theta, draw) + 0.25 * correlated(len(theta), 0.05, RATE_HZ, draw)
    ),
    "2 ms": lambda theta, draw, moving: correlated(len(theta), 2e-3, RATE_HZ, draw),
    "20 ms": lambda theta, draw, moving: correlated(len(theta), 0.02, RATE_HZ, draw),
    "200 ms": lambda theta, draw, moving: correlated(len(theta), 0.2, RATE_HZ, draw),
    "hum": lambda theta, draw, moving: _white(theta, draw) + _hum(len(theta), 0.0, draw),
    "wandering hum": lambda theta, draw, moving: _white(theta, draw) + _hum(len(theta), 1.0, draw),
    "1/f": lambda theta, draw, moving: _pink(len(theta), draw),
    "white, ½ of 1/f": lambda theta, draw, moving: _white(theta, draw) + 0.5 * _pink(len(theta), draw),
    **{f"step {step:g} σ": lambda theta, draw, moving: _white(theta, draw) for step in (0.5, 2.0, 5.0, 10.0)},
    "Student's t₃": lambda theta, draw, moving: draw.standard_t(3, len(theta)) / math.sqrt(3),
    "speckle by rate": lambda theta, draw, moving: _white(theta, draw) * (1 + 1.2 * _rate(theta)),
    "speckle by angle": lambda theta, draw, moving: (
        _white(theta, draw) * (1 + 1.2 * np.abs(theta) / np.abs(theta).max())
    ),
    "10 ms in motion": lambda theta, draw, moving: (
        _white(theta, draw) + moving * correlated(len(theta), 0.01, RATE_HZ, draw)
    ),
}
STEPS = {name: float(name.split()[1]) for name in NOISES if name.startswith("step")}


def record_of(noise: str, i: int) -> tuple[Truth, Floats]:
    """A record without noise, and its volts with noise."""
    truth = truth_of(i)
    draw = np.random.default_rng([SEED, list(NOISES).index(noise), i])
    volts = truth.volts + SIGMA_V * NOISES[noise](truth.theta, draw, truth.moving)
    step = STEPS.get(noise, 0.0) * SIGMA_V or 20.0 / 2**24
    offset = draw.uniform()
    return truth, step * (np.rint(volts / step + offset) - offset)


def measured_of(truth: Truth, volts: Floats, i: int) -> tuple[Run, Impacts]:
    """The first run of the i-th record, on the public way."""
    block, laser = truth.scene.block, laser_of(i)
    time_s = np.arange(len(volts)) / RATE_HZ
    found = find_rotation(time_s, volts, laser, block, "V")
    signal = [found[name].values for name in ("time", "theta", "sigma_theta", "flags")]
    step = converter_step(volts, signal[1])
    return judged_runs(signal, block, signal_quality(found), step=step)[0]


def run(size: str = "full") -> pd.DataFrame:
    """Every noise on every scene in turn.

    Returns
    -------
    pandas.DataFrame
        A row per number: noise; record; scene (block, foundation, kind); level and names of the verdict;
        number ("release" [s], "theta0" [rad] or "restitution"), impact (from 1; 0 of the others), error and
        stderr, and inside: the 95 % interval holds the truth.
    """
    cases = [(noise, i) for i in range(SIZES[size]) for noise in NOISES]
    return pd.DataFrame(rows_of_all(rows_of, cases), columns=COLUMNS)


def rows_of(case: tuple[str, int]) -> list[Row]:
    """Rows of one record."""
    noise, i = case
    of_record = {"noise": noise, "record": i, "scene": " ".join(names_of(i))}
    try:
        truth, volts = record_of(noise, i)
        run, impacts = measured_of(truth, volts, i)
    except FreerockError as error:
        return [of_record | {"level": "fail", "names": str(error.what), "number": "none"}]
    of_record |= {"level": run.verdict.level, "names": " ".join(run.verdict.names)}
    numbers = [
        ("release", 0, run.release_s - truth.release_s, run.release_stderr_s),
        ("theta0", 0, run.theta0 - truth.theta0, run.theta0_stderr),
    ]
    nearest = [int(np.argmin(np.abs(truth.impacts_s - each))) for each in impacts.time_s]
    for j, at in enumerate(nearest):
        if abs(truth.impacts_s[at] - impacts.time_s[j]) < ALIKE_S:
            before, after = (_rigid_energy(truth.peaks[at + by], truth.scene.block) for by in (0, 1))
            off = impacts.restitution[j] - math.sqrt(after / before)
            numbers.append(("restitution", at + 1, off, impacts.restitution_stderr[j]))
    return [
        of_record
        | {"number": number, "impact": impact, "error": error, "stderr": stderr}
        | {"inside": bool(abs(error) <= NORMAL_95 * stderr)}
        for number, impact, error, stderr in numbers
    ]


def _rigid_energy(peak: float, block: Block) -> float:
    """cos φ - cos θ_cr, φ = θ_cr - |θ|."""
    critical = math.atan(block.width_m / block.height_m)
    return math.cos(critical - abs(peak)) - math.cos(critical)


def markdown(frame: pd.DataFrame) -> str:
    """A row per noise: how many records and verdicts, and how often each interval holds the truth."""
    lines = [
        "| noise | records | not ok | release | median error [ms] | release angle | r of an impact |",
        "|---|---|---|---|---|---|---|",
    ]
    for noise, own in frame.groupby("noise", sort=False):
        records = own.drop_duplicates("record")
        usable = own[own["level"] != "fail"]
        by = {number: rows for number, rows in usable.groupby("number")}
        inside = {number: f"{100 * rows['inside'].astype(float).mean():.0f} %" for number, rows in by.items()}
        cells = [
            str(noise),
            str(len(records)),
            str(int((records["level"] != "ok").sum())),
            inside.get("release", ""),
            f"{1e3 * by['release']['error'].abs().median():.2f}" if "release" in by else "",
            inside.get("theta0", ""),
            inside.get("restitution", ""),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main(product: str, size: str, document: str = "") -> None:
    """Measure, write the product, and renew the table of a document."""
    publish(run(size), product, document, MARK, markdown)


if __name__ == "__main__":
    main(*sys.argv[1:])
