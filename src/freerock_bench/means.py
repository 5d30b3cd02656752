"""Means over records of one foundation: do they hold the truth and the next record?

Campaigns are drawn as their fits tell them: of each run a value, the standard error of its noise, and the
shift of the value by each input. The inputs are off by normal draws, and so are runs and records.
"""

import sys
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from freerock.populations.means import Mean, Shifts, over_records, over_runs
from freerock.rotation.u_total import OF_LAW
from freerock_bench.document import in_markdown

DRAWS = {"full": 60, "small": 4}  # campaigns of each kind
N_RECORDS = (2, 3, 6)
SCATTERS = (0.0, 0.01, 0.05)  # between records, of the logarithm
INPUTS = {"equal": (0.02,), "unequal": (0.01, 0.03, 0.09)}  # by the input of each block, of the logarithm
SHARING = ("blocks of their own", "one laser", "two records of a block", "misfit of one law")
LASER = 0.02
N_RUNS, BETWEEN_RUNS, NOISE = 3, 0.015, 0.002
COLUMNS = ["n_records", "scatter", "inputs", "sharing", "error", "u", "half95", "tau"]
SHARES = ["mean_inside", "next_inside", "tau_is_none"]


class Kind(NamedTuple):
    """How many records, their scatter, a key of `INPUTS`, and what they share."""

    n_records: int
    scatter: float
    inputs: str
    sharing: str


KINDS = [Kind(*each) for each in product(N_RECORDS, SCATTERS, INPUTS, SHARING)]


def cases(size: str) -> list[tuple[Kind, int]]:
    """Campaigns of every kind."""
    return [(kind, i) for kind in KINDS for i in range(DRAWS[size])]


def row_of(case: tuple[Kind, int]) -> dict[str, Any]:
    """The row of one campaign, whose truth is 0. All is of the logarithm.

    n_records, scatter, inputs, sharing; error of the mean, u, half95 (half its total 95 % interval), tau;
    mean_inside, next_inside (the intervals hold the truth and the mean of the next record), tau_is_none.
    """
    kind, number = case
    generator = np.random.default_rng([2017, 37, KINDS.index(kind), number])
    drawn: dict[tuple[str, str], float] = {}
    every = [_record(kind, i, drawn, generator) for i in range(kind.n_records + 1)]
    records, following = every[:-1], every[-1].found.mean
    whole = over_records(records)
    mean = whole.found
    row = {
        **kind._asdict(),
        "error": mean.mean,
        "u": mean.u,
        "half95": mean.total_high - mean.mean,
        "tau": mean.tau,
        "mean_inside": mean.total_low <= 0 <= mean.total_high,
        "next_inside": mean.next_low <= following <= mean.next_high,
        "tau_is_none": mean.tau == 0,
    }
    return row


def _record(
    kind: Kind, number: int, drawn: dict[tuple[str, str], float], generator: np.random.Generator
) -> Mean:
    """Runs of a record, off by its inputs, its scatter and their own; inputs are drawn when first met."""
    shifts = _shifts(kind, number)
    for key in shifts:
        drawn.setdefault(key, float(generator.standard_normal()))
    centre = sum(shift * drawn[key] for key, shift in shifts.items())
    centre += kind.scatter * generator.standard_normal()
    errors = NOISE * np.exp(0.5 * generator.standard_normal(N_RUNS))
    values = centre + np.hypot(BETWEEN_RUNS, errors) * generator.standard_normal(N_RUNS)
    return over_runs(values, errors, [shifts] * N_RUNS)


def _shifts(kind: Kind, number: int) -> Shifts:
    """What a record owes to its inputs; the next one is of another block, with a misfit of its own."""
    sizes = INPUTS[kind.inputs]
    size, is_next = sizes[number % len(sizes)], number == kind.n_records
    if is_next:  # of a size as the others'
        size = float(np.median([sizes[i % len(sizes)] for i in range(kind.n_records)]))
    if kind.sharing == "misfit of one law":
        return {("next" if is_next else "hunt_crossley", OF_LAW): size}
    of_a_block = 2 if kind.sharing == "two records of a block" else 1
    block = "next" if is_next else f"block {number // of_a_block}"
    if of_a_block == 2 and not is_next:
        size = sizes[number // 2 % len(sizes)]
    own = {(block, "width_m"): size}
    return own | {("laser", "scale_fraction"): LASER} if kind.sharing == "one laser" else own


def markdown(frame: pd.DataFrame) -> str:
    """A row per number of records, scatter and inputs, one per way of sharing, and one of all campaigns."""
    heads = ["campaigns", "drawn", "mean inside its 95 %", "next record inside", "no τ is seen"]

    def line(name: str, rows: pd.DataFrame) -> list[object]:
        shares = [f"{100 * rows[share].mean():.1f} %" for share in SHARES]
        return [name, len(rows), *shares]

    lines = [
        line(f"{n} records, scatter {100 * scatter:g} %, {inputs} u", rows)
        for (n, scatter, inputs), rows in frame.groupby(["n_records", "scatter", "inputs"], sort=False)
    ]
    lines += [line(str(sharing), rows) for sharing, rows in frame.groupby("sharing", sort=False)]
    return in_markdown(heads, [*lines, line("**all**", frame)])


def run(size: str = "full") -> pd.DataFrame:
    """The long table of all campaigns."""
    return pd.DataFrame([row_of(case) for case in cases(size)], columns=[*COLUMNS, *SHARES])


if __name__ == "__main__":
    print(markdown(run(*sys.argv[1:])))
