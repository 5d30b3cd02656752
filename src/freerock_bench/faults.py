"""Faults matrix: how surely each fault of a signal is named, and how often one is invented.

Records of the virtual laboratory (`freerock.virtual_lab.virtual_record`), without mains interference or
drift, get the noise of a laser and one fault (`disturbances`) each; `find_rotation` must name it, at the time
it lasts. Clean records must be left without any name, and their runs without a warning.

    python -m freerock_bench.faults results/studies/faults.csv full docs/validation.md

measures and renews the table in the documentation, where it is named.
"""

import sys
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from ruamel.yaml import YAML

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.faults import listed_faults, signal_quality
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.segment import find_runs
from freerock.virtual_lab.added_noise import AddedNoise, Disturbance
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock.virtual_lab.virtual_record import Recording, VirtualRecord, VirtualRelease, simulate_record
from freerock_bench import disturbances as spoil
from freerock_bench.analysed import signal_of
from freerock_bench.document import in_markdown
from freerock_bench.harness import Study
from freerock_bench.virtual_run import Row

SIZES = {"full": (24, 200, 1000), "small": (2, 4, 12)}  # motions, records of each cell, clean records
NOISE_V, MAINS_V = 2e-3, 5e-3
SILENT = AddedNoise(white_v=0.0, mains_v=0.0, drift_v=0.0, bits=32)
RATES_HZ = (1000.0, 2000.0, 5000.0)
BITS = (16, 24)
SEVERITIES = ("light", "medium", "heavy")
STATED = YAML(typ="safe", pure=True).load(Path(__file__).with_suffix(".yaml"))
COLUMNS = ["fault", "severity", "record", "value", "named", "others"]
Case = tuple[int, str, int, int]  # motions, fault, severity, record


def cases(size: str) -> list[Case]:
    """Records with every fault at every severity, then clean records."""
    n, n_records, n_clean = SIZES[size]
    every = product(STATED, range(len(SEVERITIES)), range(n_records))
    return [*((n, *each) for each in every), *((n, "none", 0, i) for i in range(n_clean))]


def rows_of(case: Case) -> list[Row]:
    """The row of a record.

    fault, severity, record; value of what is varied; named, whether the fault was at its time; others,
    whether another fault was named besides. Of a clean record, whose fault is "none": named, whether any
    fault was; others, whether a run was missed or invented, or its verdict is not ok.
    """
    n_motions, fault, severity, i = case
    row: Row = {"fault": fault, "record": i}
    if fault == "none":
        return [row | _clean(i, *_motion(i % n_motions))]
    (record, block, laser), stated = _motion(i % n_motions), STATED[fault]
    value, draw = stated["values"][severity], np.random.RandomState([list(STATED).index(fault), severity, i])
    injected, start, end = _injected(fault, value, record, draw)
    found = _named(record, _measured(record, injected, draw), block, laser)
    named = any(name == fault and first <= end and last >= start for name, first, last in found)
    others = any(name not in (fault, stated.get("brings")) for name, _, _ in found)
    return [row | {"severity": SEVERITIES[severity], "value": value, "named": named, "others": others}]


@cache
def _motion(seed: int) -> tuple[VirtualRecord, Block, Laser]:
    """A record without noise, of one to three releases of a block of Table 1; the block, the laser."""
    draw = np.random.RandomState(seed)
    block, angle, laser = list(CONFIGURATIONS.values())[seed % 3]
    releases = [
        VirtualRelease(
            angle * draw.uniform(0.6, 1.0),
            list(FOUNDATIONS.values())[seed % 2],
            tilt_s=draw.uniform(1.0, 2.0),
            held_s=draw.uniform(1.5, 2.5),
            fade_s=draw.uniform(0.005, 0.02),
            pause_s=draw.uniform(2.0, 3.0),
        )
        for _ in range(1 + seed % 3)
    ]
    rate = RATES_HZ[seed // 3 % 3]
    recording = Recording(rate_hz=rate, rest_s=2.5, noise=SILENT)
    record = simulate_record(block, laser, "hunt_crossley", releases, seed=seed, recording=recording)
    return record, block, laser


def _measured(record: VirtualRecord, fault: Disturbance | None, draw: Any) -> Floats:
    """Volts of a motion with noise and a fault, through a converter."""
    volts = record.volts + NOISE_V * draw.standard_normal(record.time_s.size)
    if fault:
        volts = fault(record.time_s, volts, draw)
    count = 21 / 2 ** BITS[draw.randint(len(BITS))]
    converted: Floats = np.rint(volts / count) * count
    return converted


def _injected(fault: str, value: float, record: VirtualRecord, draw: Any) -> tuple[Disturbance, float, float]:
    """A fault, and from when to when it must be named; a fault of the whole record, any time."""
    end = float(record.time_s[-1])
    run = record.truth["runs"][draw.randint(len(record.truth["runs"]))]
    at = draw.uniform(0.5, end - 0.5)
    always = (0.0, end)
    rate = record.truth["sampling_rate_hz"]
    if fault in ("error_level", "dropout"):
        broken = {"error_level": (spoil.error_level,), "dropout": (spoil.frozen, spoil.disconnected)}[fault]
        return broken[draw.randint(len(broken))](at, value), at, at + value
    if fault == "spike":
        return spoil.spike(at, value * draw.choice([-1, 1])), at - 1 / rate, at + 2 / rate
    if fault in ("saturated", "target_lost"):
        held = max(record.truth["runs"], key=lambda each: abs(each["theta0_rad"]))
        return getattr(spoil, fault)(value), held["hold_start_s"] - 1.0, held["release_s"] + 0.5
    if fault == "ac_coupling":
        return spoil.ac_coupled(value), *always
    if fault == "drift":
        return spoil.drift(value * draw.choice([-1, 1])), *always
    if fault == "rest_shift":
        at = run["release_s"] + 0.5 * (run["impacts_s"][0] - run["free_s"])
        return spoil.slid(at, value * draw.choice([-1, 1])), run["hold_start_s"], run["rest_s"]
    if fault == "mains_interference":
        return spoil.tone(draw.uniform(49.95, 50.05), value), *always
    if fault == "sampling_rate":
        return spoil.tone(50 * (1 + value * draw.choice([-1, 1])), MAINS_V), *always
    folded = draw.uniform(60.0, rate / 2 - 10.0)
    return spoil.tone(draw.randint(1, 5) * rate + folded, value), *always


def _named(
    record: VirtualRecord, volts: Floats, block: Block, laser: Laser
) -> list[tuple[str, float, float]]:
    """Name, start and end [s] of the faults found; a refusal counts for the fault that it names."""
    end = float(record.time_s[-1])
    try:
        found = find_rotation(record.time_s, volts, laser, block)
    except FreerockError as error:
        return [("ac_coupling" if "AC-coupled" in error.what else "refused", 0.0, end)]
    return [(fault.name, fault.start_s, fault.end_s) for fault in listed_faults(found)]


def _clean(i: int, record: VirtualRecord, block: Block, laser: Laser) -> Row:
    """Of a clean record any fault is a false alarm, any run that is not ok too."""
    draw = np.random.RandomState([len(STATED), i])
    try:
        found = find_rotation(record.time_s, _measured(record, None, draw), laser, block)
        time_s, theta, sigma, flags = signal_of(found)
        runs = find_runs(time_s, theta, sigma, flags, block, signal_quality(found))
    except FreerockError:
        return {"named": True, "others": True}
    wrong = len(runs) != len(record.truth["runs"]) or any(run.verdict.level != "ok" for run in runs)
    return {"named": bool(listed_faults(found)), "others": wrong}


def markdown(frame: pd.DataFrame) -> str:
    """The matrix as a table: a row per fault, a column per severity."""
    lines = []
    clean = frame["fault"] == "none"
    for fault, own in frame[~clean].groupby("fault", sort=False):
        rates = own.groupby("value", sort=False)["named"].mean()
        cells = [f"{value:g}: {rate:.1%}" for value, rate in rates.items()]
        name = str(fault)
        lines.append([name.replace("_", " "), STATED[name]["varied"], *cells, f"{own['others'].mean():.1%}"])
    for column, text in (("named", "any fault named"), ("others", "a run missed, invented or not ok")):
        share = f"{frame.loc[clean, column].mean():.1%} of {clean.sum()}"
        lines.append(["none", text, share, "", "", ""])
    heads = ["fault", "varied", "light", "medium", "heavy", "another named besides"]
    return in_markdown(heads, lines)


STUDY = Study(cases, rows_of, COLUMNS, "faults", markdown)
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
