"""Means over records of one foundation: do they hold the truth and the next record?

Campaigns are drawn as their fits tell them: of each run a value, the standard error of its noise, and the
shift of the value by each input. The inputs are off by normal draws, and so are runs and records.
"""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.populations.means import Mean, Shifts, over_records, over_runs
from freerock.runs.u_of_measured import OF_LAW
from freerock_bench.campaigns import COLUMNS, Row
from freerock_bench.document import in_markdown

SEED, DRAWS = 37, {"full": 20, "small": 1}  # campaigns of each kind
N_RECORDS = (2, 3, 6)
SCATTERS = (0.0, 0.01, 0.05)  # between records, of the logarithm
INPUTS = {"equal": (0.02,), "unequal": (0.01, 0.03, 0.09)}  # by the input of each block, of the logarithm
SHARING = ("blocks of their own", "one laser", "two records of a block", "misfit of one law")
LASER = 0.02
N_RUNS, BETWEEN_RUNS, NOISE = 3, 0.015, 0.002


Kind = tuple[int, float, str, str]  # how many records, their scatter, a key of `INPUTS`, what they share
KINDS = [*product(N_RECORDS, SCATTERS, INPUTS, SHARING)]


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table of campaigns, of the logarithm: the mean's truth is 0, the next record's its mean."""
    every = [(kind, i) for kind in KINDS for i in range(DRAWS[size])]
    return pd.DataFrame([row for each in every for row in _rows(*each)], columns=COLUMNS)


def _rows(kind: Kind, number: int) -> list[Row]:
    """The rows of one campaign."""
    n, scatter, inputs, sharing = kind
    generator = np.random.default_rng([2017, SEED, KINDS.index(kind), number])
    drawn: dict[tuple[str, str], float] = {}
    every = [_record(kind, i, drawn, generator) for i in range(n + 1)]
    mean, following = over_records(every[:-1]).found, every[-1].found.mean
    case = f"{n} records, scatter {100 * scatter:g} %, {inputs} u"
    of = {"case": case, "scene": sharing, "test": number, "value": mean.mean}
    holds = mean.total_low <= 0 <= mean.total_high, mean.next_low <= following <= mean.next_high
    return [
        of | {"parameter": "mean", "truth": 0.0, "u": mean.u, "inside": holds[0]},
        of | {"parameter": "next record", "truth": following, "inside": holds[1]},
    ]


def _record(kind: Kind, number: int, drawn: dict[tuple[str, str], float], generator: Any) -> Mean:
    """Runs of a record, off by its inputs, its scatter and their own; inputs are drawn when first met."""
    shifts = _shifts(kind, number)
    for key in shifts:
        drawn.setdefault(key, float(generator.standard_normal()))
    centre = sum(shift * drawn[key] for key, shift in shifts.items()) + kind[1] * generator.standard_normal()
    errors = NOISE * np.exp(0.5 * generator.standard_normal(N_RUNS))
    values = centre + np.hypot(BETWEEN_RUNS, errors) * generator.standard_normal(N_RUNS)
    return over_runs(values, errors, [shifts] * N_RUNS)


def _shifts(kind: Kind, number: int) -> Shifts:
    """What a record owes to its inputs; the next one is of another block, with a misfit of its own."""
    n, _, inputs, sharing = kind
    sizes = INPUTS[inputs]
    size, is_next = sizes[number % len(sizes)], number == n
    if is_next:  # of a size as the others'
        size = float(np.median([sizes[i % len(sizes)] for i in range(n)]))
    if sharing == "misfit of one law":
        return {("next" if is_next else "hunt_crossley", OF_LAW): size}
    of_a_block = 2 if sharing == "two records of a block" else 1
    block = "next" if is_next else f"block {number // of_a_block}"
    size = sizes[number // 2 % len(sizes)] if of_a_block == 2 and not is_next else size
    own = {(block, "width_m"): size}
    return own | {("laser", "scale_fraction"): LASER} if sharing == "one laser" else own


def markdown(frame: pd.DataFrame) -> str:
    """A row per number of records, scatter and inputs, one per way of sharing, and one of all campaigns."""
    of_all, lines = frame.assign(all="**all**"), []
    for by in ("case", "scene", "all"):
        for name, rows in of_all.groupby(by, sort=False):
            shares = rows.groupby("parameter")["inside"].mean()
            percent = [f"{100 * shares[each]:.1f} %" for each in ("mean", "next record")]
            lines.append([name, len(rows) // 2, *percent])
    return in_markdown(["campaigns", "drawn", "mean inside its 95 %", "next record inside"], lines)
