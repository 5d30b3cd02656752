"""Faults matrix: how surely each fault of a signal is named, and how often one is invented.

Records of the virtual laboratory (`freerock.virtual_lab.virtual_record`), without mains interference or
drift, get the noise of a laser and one fault (`disturbances`) each; `find_rotation` must name it, at the time
it lasts. Clean records must be left without any name, and their runs without a warning.

    python -m freerock_bench.faults results/studies/faults.csv docs/validation.md

renews the table in the documentation from the product of `snakemake studies`.
"""

import math
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.faults import listed_faults, signal_quality
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.segment import Run, find_runs
from freerock.virtual_lab.added_noise import AddedNoise, Disturbance
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock.virtual_lab.virtual_record import Recording, VirtualRecord, VirtualRelease, simulate_record
from freerock_bench import disturbances as spoil
from freerock_bench.document import in_markdown, renew
from freerock_bench.harness import Study
from freerock_bench.virtual_run import Row

SIZES = {"full": (24, 200, 1000), "small": (2, 4, 12)}  # motions, records of each cell, clean records
NOISE_V, MAINS_V = 2e-3, 5e-3
SILENT = AddedNoise(white_v=0.0, mains_v=0.0, drift_v=0.0, bits=32)
RATES_HZ = (1000.0, 2000.0, 5000.0)
BITS = (16, 24)
SEVERITIES = ("light", "medium", "heavy")
SETTINGS = {  # fault: what is varied, its values from light to heavy
    "error_level": ("duration [s]", (0.004, 0.02, 0.2)),
    "saturated": ("share of the held reading", (0.95, 0.8, 0.5)),
    "dropout": ("duration [s]", (0.006, 0.02, 0.1)),
    "spike": ("height [V]", (0.05, 0.2, 2.0)),
    "ac_coupling": ("cut-off [Hz]", (0.02, 0.1, 0.5)),
    "drift": ("range [V]", (0.02, 0.05, 0.2)),
    "rest_shift": ("shift [V]", (0.01, 0.03, 0.1)),
    "mains_interference": ("amplitude [V]", (0.001, 0.005, 0.05)),
    "aliasing": ("amplitude [V]", (0.001, 0.005, 0.05)),
    "sampling_rate": ("error of the rate", (0.01, 0.03, 0.1)),
    "target_lost": ("share of the held reading", (0.95, 0.8, 0.5)),
}
COLUMNS = ["fault", "severity", "quantity", "value", "records", "named", "rate", "others"]
Case = tuple[int, int, str, int]  # motions, records, fault, severity
Original = tuple[VirtualRecord, Block, Laser]  # a record without faults, its block and its laser
Cells = tuple[str, str, str, float | str, int, int, float, int]
MARK = ("<!-- faults matrix -->\n", "<!-- end of the faults matrix -->\n")


def cases(size: str) -> list[Case]:
    """Every fault at every severity, then clean records."""
    n_motions, n_records, n_clean = SIZES[size]
    found = [(n_motions, n_records, fault, at) for fault in SETTINGS for at in range(len(SEVERITIES))]
    return [*found, (n_motions, n_clean, "none", 0)]


def rows_of(case: Case) -> list[Row]:
    """The row of a fault and severity, or two of clean records.

    quantity and value of what is varied, number of records, in how many the fault was named at its time, that
    share, and in how many another fault was named besides. The row "none" counts the clean records in which
    any fault was named, the row "none, runs" those with a run whose verdict is not ok.
    """
    n_motions, n_records, fault, severity = case
    motions = [_motion(seed) for seed in range(n_motions)]
    clean = fault == "none"
    found = _clean(motions, n_records) if clean else [_cell(motions, n_records, fault, severity)]
    return [dict(zip(COLUMNS, each, strict=True)) for each in found]


@cache
def _motion(seed: int) -> Original:
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


def _cell(motions: Sequence[Original], n_records: int, fault: str, severity: int) -> Cells:
    """One fault at one severity."""
    (quantity, values), named, others = SETTINGS[fault], 0, 0
    value = values[severity]
    for trial in range(n_records):
        draw = np.random.RandomState([list(SETTINGS).index(fault), severity, trial])
        record, block, laser = motions[trial % len(motions)]
        injected, start, end = _injected(fault, value, record, draw)
        found = _named(record, _measured(record, injected, draw), block, laser)
        named += any(name == fault and first <= end and last >= start for name, first, last in found)
        others += any(name not in (fault, *_COMPANIONS.get(fault, ())) for name, _, _ in found)
    return fault, SEVERITIES[severity], quantity, value, n_records, named, named / n_records, others


_COMPANIONS = {  # what a fault brings along, rightly
    "target_lost": ("error_level",),
    "dropout": ("spike",),
    "drift": ("rest_shift",),
    "rest_shift": ("drift",),
    "sampling_rate": ("aliasing",),
}


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


def _clean(motions: Sequence[Original], n_records: int) -> Iterator[Cells]:
    """Clean records: any fault is a false alarm, any run that is not ok too."""
    alarms = doubted = 0
    for trial in range(n_records):
        draw = np.random.RandomState([len(SETTINGS), trial])
        record, block, laser = motions[trial % len(motions)]
        alarm, runs = True, list[Run]()  # of a record that is refused
        with suppress(FreerockError):
            found = find_rotation(record.time_s, _measured(record, None, draw), laser, block)
            alarm = bool(listed_faults(found))
            time_s, theta = found["time"].values, found["theta"].values
            sigma, flags = found["sigma_theta"].values, found["flags"].values
            runs = find_runs(time_s, theta, sigma, flags, block, signal_quality(found))
        alarms += alarm
        missed = len(runs) != len(record.truth["runs"])
        doubted += missed or any(run.verdict.level != "ok" for run in runs)
    for name, count in (("none", alarms), ("none, runs", doubted)):
        yield name, "", "", math.nan, n_records, count, count / n_records, 0


def markdown(frame: pd.DataFrame) -> str:
    """The matrix as a table: a row per fault, a column per severity."""
    lines = []
    graded = frame[frame["severity"].notna() & (frame["severity"] != "")]
    for fault, rows in graded.groupby("fault", sort=False):
        cells = [f"{row.value:g}: {row.rate:.1%}" for row in rows.itertuples()]
        others = rows["others"].sum() / rows["records"].sum()
        quantity = rows["quantity"].iloc[0]
        lines.append([fault.replace("_", " "), quantity, *cells, f"{others:.1%}"])
    for row in frame[frame["fault"].str.startswith("none")].to_dict("records"):
        fault = row["fault"]
        text = "a run missed, invented or not ok" if fault.endswith("runs") else "any fault named"
        found = f"{row['rate']:.1%} of {row['records']}"
        lines.append([fault.removesuffix(", runs"), text, found, "", "", ""])
    heads = ["fault", "varied", "light", "medium", "heavy", "another named besides"]
    return in_markdown(heads, lines) + "\n"


STUDY = Study(cases, rows_of, COLUMNS)
run = STUDY.run

if __name__ == "__main__":
    product, document = map(Path, sys.argv[1:])
    renew(document, MARK, markdown(pd.read_csv(product)))
