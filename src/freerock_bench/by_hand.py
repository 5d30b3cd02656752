"""A fit as a laboratory would write it beside freerock's, on the same θ(t), with and without scatter.

`benchmarks/by_hand.py` is lmfit around SciPy's solve_ivp with the paper's objective. Both fit the true law to
the first run of records whose inputs are exact. A case is a σ_r and a tool.
"""

import math
import sys
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.fit import fit_run
from freerock.models.laws import Candidate
from freerock.runs.motion import Motion
from freerock.virtual_lab.published import BLOCKS
from freerock_bench import scattered
from freerock_bench.campaigns import COLUMNS, ROOT, SCENE, Row, number_row
from freerock_bench.document import in_markdown

SEED, SIGMAS = 5, (0.0, 0.01)
RECORDS = {"full": 15, "small": 1}  # of each σ_r, of which a fifth is Housner's and left out
HAND, OURS = "lmfit and solve_ivp", "freerock"


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table: numbers of the law, ε_θ and processor time of each fit."""
    sys.path.append(str(ROOT / "benchmarks"))  # by its own name, under which numba keeps what it compiled
    by_hand = import_module("by_hand").fitted
    rows = list[Row]()
    for sigma in SIGMAS if size == "full" else SIGMAS[1:]:
        for i in range(RECORDS[size]):
            path = scattered.make(folder / "records", sigma, i, SEED, "exact", at_once=True)
            record = np.load(path)
            law = str(record["true_law"])
            if law == "housner":
                continue
            of = {"test": path.stem, "scene": " ".join(str(record[f"true_{name}"]) for name in SCENE)}
            for tool, fit in ((HAND, by_hand), (OURS, _ours)):
                case = f"σ_r {100 * sigma:g} %, {tool}"
                rows += [of | row for row in _rows(case, record, fit(record, law))]
    return pd.DataFrame(rows, columns=COLUMNS)


def _ours(record: Any, law: str) -> tuple[dict[str, float], float, float, dict[str, float]]:
    """Values, ε_θ, seconds and u of freerock's fit."""
    block = BLOCKS[str(record["true_block_name"])]
    sigma, theta0 = float(record["sigma_theta"]), float(record["run0_theta0_measured"])
    measured = record["run0_time"], record["run0_theta"]
    motion = Motion(*measured, sigma, theta0, sigma / math.sqrt(50), float(record["t0_stderr"]))
    begin = time.process_time()
    fit = fit_run(Candidate(law, str(record["true_kinematics"])).name, block, motion)
    spent = time.process_time() - begin
    return dict(fit.values), fit.epsilon_theta, spent, dict(zip(fit.values, fit.u_total, strict=True))


def _rows(case: str, record: Any, fit: tuple[Any, ...]) -> Iterator[Row]:
    """Rows of a fit: values, ε_θ, seconds, and u where it has any."""
    values, epsilon, seconds, *known = fit
    for name in ("k", "c", "lambda"):
        if name in values:
            u = known[0][name] if known else math.nan
            yield {"case": case} | number_row(name, float(record[f"run0_{name}"]), values[name], u, u)
    yield {"case": case, "parameter": "ε_θ", "value": epsilon}
    yield {"case": case, "parameter": "processor time", "value": seconds}


def markdown(frame: pd.DataFrame) -> str:
    """A row per case: medians."""
    rows = []
    for case, own in frame.groupby("case", sort=False):
        k, epsilon, spent = (own[own["parameter"] == name] for name in ("k", "ε_θ", "processor time"))
        error = 100 * (k["value"] / k["truth"] - 1).abs()
        cells = f"{error.median():.2g} %", f"{error.max():.2g} %"
        more = f"{100 * epsilon['value'].median():.2g} %", f"{spent['value'].median():.1f} s"
        rows.append([case, len(k), *cells, *more])
    return in_markdown(["fit", "runs", "k off, median", "largest", "ε_θ", "processor time"], rows)
