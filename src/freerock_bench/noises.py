"""Are the numbers of a run as certain as stated, whatever the noise?

`clean_records`, which share nothing with the laws that are fitted, with seventeen kinds of noise, as
volts through the public way to runs, impacts, the fit of the law that is true, and restitution by energy.

    python -m freerock_bench.noises results/studies/noises.csv full docs/evidence.md

measures (`small`: three records of each noise; `full`: 168, in a quarter of an hour of processor time) and
renews the table in the documentation, where it is named.
"""

import math
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.identification.fit import fit_run
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.block import Block
from freerock.populations.impact_energy import impact_energy
from freerock_bench.analysed import Measured
from freerock_bench.clean_records import RATE_HZ, CleanRecord, truth_of
from freerock_bench.document import in_markdown
from freerock_bench.harness import Study
from freerock_bench.virtual_run import SEED, Row, converted, correlated

SIZES = {"small": 3, "full": 168}  # records of each noise; twenty-four make a round of scenes
SIGMA_V = 2e-3
ALIKE_S = 0.02  # between an impact found and that of the truth
NUMBERS = {
    "release": "release",
    "theta0": "release angle",
    "restitution": "r of an impact",
    "block": "r of the block",
    "by energy": "by energy",
    "k": "k",
    "c": "c",
    "lambda": "λ",
    "r": "r",
    "width": "width",
}
COLUMNS = ["noise", "record", "scene", "level", "names", "number", "impact", "error", "stderr", "inside"]
Number = tuple[str, int, float, float]
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
    "10 ms in motion": lambda theta, draw, moving: (
        _white(theta, draw) + moving * correlated(len(theta), 0.01, RATE_HZ, draw)
    ),
}
STEPS = {name: float(name.split()[1]) for name in NOISES if name.startswith("step")}


def record_of(noise: str, i: int) -> tuple[CleanRecord, Floats]:
    """A record without noise, and its volts with noise."""
    truth = truth_of(i)
    draw = np.random.default_rng([SEED, list(NOISES).index(noise), i])
    volts = truth.volts + SIGMA_V * NOISES[noise](truth.theta, draw, truth.moving)
    step = STEPS.get(noise, 0.0) * SIGMA_V or 20.0 / 2**24
    return truth, converted(volts, step, draw)


def cases(size: str) -> list[tuple[str, int]]:
    """Every noise on every scene in turn."""
    return [(noise, i) for i in range(SIZES[size]) for noise in NOISES]


def rows_of(case: tuple[str, int]) -> list[Row]:
    """Rows of one record, one per number.

    noise; record; scene (block, foundation, kind); level and names of the verdict; number (see `NUMBERS`),
    impact (from 1; 0 of the others), error and stderr [SI], and inside: the 95 % interval holds the truth.
    Inputs are exact, so that stderr is that of the noise. A record without a run, or whose fit is not to be
    used, has a row of the number "none".
    """
    noise, i = case
    truth, volts = record_of(noise, i)
    judged, found = truth.first_run(volts)
    of_record = {"noise": noise, "record": i, "scene": " ".join(truth.names), **judged}
    if found is None:
        return [of_record | {"number": "none"}]
    return [
        of_record
        | {"number": number, "impact": impact, "error": error, "stderr": stderr}
        | {"inside": bool(abs(error) <= NORMAL_95 * stderr)}
        for number, impact, error, stderr in [*_of_run(truth, found), *_of_fit(truth, found)]
    ]


def _of_run(truth: CleanRecord, found: Measured) -> Iterator[Number]:
    """What the run itself shows."""
    run, impacts = found[:2]
    yield "release", 0, run.release_s - truth.release_s, run.release_stderr_s
    yield "theta0", 0, run.theta0 - truth.theta0, run.theta0_stderr
    energies = _rigid_energies(truth.peaks, truth.scene.block)
    restitution = impacts.restitution, impacts.restitution_stderr
    yield from _against("restitution", truth, energies, impacts.time_s, *restitution)


def _of_fit(truth: CleanRecord, found: Measured) -> Iterator[Number]:
    """What the fit of the law that is true shows."""
    run, impacts, motion, _ = found
    if motion is None:
        return
    block, true = truth.scene.block, truth.parameters
    fit = fit_run(truth.candidate, block, motion)
    if not fit.success:
        yield "none", 0, math.nan, math.nan
        return
    yield "noise", 0, float(not fit.diagnostics["noise"]), 0.0
    for name, value, stderr in zip(fit.parameters, fit.value, fit.stderr, strict=True):
        if name in true:
            yield name, 0, value - true[name], stderr
    if "r" not in true:
        whole = impact_energy(fit, block, impacts.time_s - run.release_s, view=motion.view)
        time_s = whole.time_s + run.release_s
        yield from _against("by energy", truth, truth.energies, time_s, whole.restitution, whole.stderr)


def _against(
    name: str, truth: CleanRecord, energies: Floats, time_s: Floats, restitution: Floats, stderr: Floats
) -> Iterator[Number]:
    """Restitutions found at some instants, against those of the true energies at the same impacts."""
    for j, each in enumerate(time_s):
        at = int(np.argmin(np.abs(truth.impacts_s - each)))
        if abs(truth.impacts_s[at] - each) < ALIKE_S:
            yield name, at + 1, restitution[j] - math.sqrt(energies[at + 1] / energies[at]), stderr[j]


def _rigid_energies(peaks: Floats, block: Block) -> Floats:
    """cos φ - cos θ_cr, φ = θ_cr - |θ|."""
    critical = math.atan(block.width_m / block.height_m)
    return np.cos(critical - np.abs(peaks)) - math.cos(critical)


def markdown(frame: pd.DataFrame) -> str:
    """A row per noise: how many records and verdicts, and how often each interval holds the truth."""
    rows = []
    for noise, own in frame.groupby("noise", sort=False):
        levels = own.drop_duplicates("record")["level"]
        by = {number: each for number, each in own[own["level"] != "fail"].groupby("number")}
        doubted = int(by["noise"]["error"].sum()) if "noise" in by else 0
        cells = [str(noise), len(levels), (levels == "fail").sum(), (levels == "warn").sum()]
        cells.append(doubted + len(by.get("none", ())))
        cells += [
            f"{100 * by[key]['inside'].astype(float).mean():.0f} %" if key in by else "" for key in NUMBERS
        ]
        rows.append(cells)
    heads = ["noise", "records", "failed", "warned", "fits in doubt", *NUMBERS.values()]
    return in_markdown(heads, rows)


STUDY = Study(cases, rows_of, COLUMNS, "noises", markdown)

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
