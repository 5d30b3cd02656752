"""Measured shake-table tests of two granite rocks: does an equivalent rigid block say which of them fall?

    python -m freerock_bench.granite FOLDER results/studies/granite.csv

FOLDER (or the environment's FREEROCK_GRANITE) holds `granite_even.npz`; the data are not a part of this
project. Each rock is a Housner block of unknown slenderness, size and restitution. On half of the tests every
block of a grid is weighed by how many of the falls it has right; the weighted blocks foretell the other half,
and the two halves change places.
"""

import math
import os
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.special import expit

from freerock.arrays import Floats, Mask
from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.response.ensemble import respond
from freerock.response.motions import Accelerogram
from freerock.tables.csvfile import write_csv

ALPHA, SIZE_M, RESTITUTION = np.linspace(0.04, 0.28, 13), np.geomspace(0.06, 1.0, 6), (0.65, 0.85)
TOGETHER = 2  # samples of the table, averaged into one
ROCKS = ("rock 1", "rock 2")


def run(folder: str = "") -> pd.DataFrame:
    """How often each way of foretelling is right on the half on which nothing was chosen.

    Returns
    -------
    pandas.DataFrame
        Columns rock, way (equivalent block, logistic regression, always stands), n, right (share), alpha,
        size_m, restitution (of the best block, first half).

    Raises
    ------
    FreerockError
        The data are not at hand.
    """
    motions, fell, logs = _read(folder)
    blocks = [*product(ALPHA.tolist(), SIZE_M.tolist(), RESTITUTION)]
    falls = np.array([_falls(block, motions) for block in blocks])
    half = np.arange(len(motions)) % 2 == 0
    rows: list[dict[str, object]] = []
    for name, truth in zip(ROCKS, fell.T, strict=True):
        chance, regressed, stands = np.empty((3, len(motions)))
        for known in (half, ~half):
            chance[~known] = (
                _weighted(falls[:, known], truth[known]) @ _softened(falls, known, truth)[:, ~known]
            )
            regressed[~known] = _regressed(logs[known], truth[known], logs[~known])
            stands[~known] = 0.0
        best = blocks[int(np.argmax((falls[:, half] == truth[half]).mean(axis=1)))]
        shape = dict(zip(("alpha", "size_m", "restitution"), best, strict=True))
        ways = {"equivalent block": chance, "logistic regression": regressed, "always stands": stands}
        for way, found in ways.items():
            row = {"rock": name, "way": way, "n": truth.size, "right": np.mean((found > 0.5) == truth)}
            rows.append(row | (shape if way == "equivalent block" else {}))
    return pd.DataFrame(rows)


def _read(folder: str) -> tuple[list[Accelerogram], Mask, Floats]:
    """Motions of the table, which rock fell, and ln PGA and ln PGV/PGA of each test."""
    path = Path(folder or os.environ.get("FREEROCK_GRANITE", "")) / "granite_even.npz"
    if not path.is_file():
        raise FreerockError(
            path, "the granite tests are not at hand", "give their folder as FREEROCK_GRANITE"
        )
    data = np.load(path)
    step, ends = float(data["dt_s"]), np.cumsum(data["length"])
    counts = np.split(data["acceleration"], ends[:-1])
    motions = []
    for i, each in enumerate(counts):
        means = each[: each.size // TOGETHER * TOGETHER].reshape(-1, TOGETHER).mean(axis=1)
        acceleration = (means - np.median(means)) * float(data["scale_g"]) * GRAVITY
        motions.append(Accelerogram(f"{i:03d}", step * TOGETHER * np.arange(means.size), acceleration))
    table = data["table"]
    return motions, table[:, 1:3] > 0, np.log(table[:, [4, 3]])


def _falls(block: tuple[float, float, float], motions: list[Accelerogram]) -> Mask:
    """Under which motions a block overturns."""
    alpha, size, restitution = block
    shape = Block(2 * size * math.cos(alpha), 2 * size * math.sin(alpha), 1.0)
    table = respond("housner", shape, [{"r": restitution}], motions, rtol=1e-4)
    return np.asarray(table["overturned"] > 0)


def _error(falls: Mask, truth: Mask) -> float:
    """Share of the tests that the best block has wrong, with one more of each kind (Laplace)."""
    wrong = (falls != truth).sum(axis=1).min()
    return float(wrong + 1) / (truth.size + 2)


def _weighted(falls: Mask, truth: Mask) -> Floats:
    """Weights of the blocks: each test is told wrong with one and the same probability."""
    error = _error(falls, truth)
    log_odds = (falls == truth).sum(axis=1) * math.log((1 - error) / error)
    weight = np.exp(log_odds - log_odds.max())
    return np.asarray(weight / weight.sum())


def _softened(falls: Mask, known: Mask, truth: Mask) -> Floats:
    """Probability of a fall by each block."""
    error = _error(falls[:, known], truth[known])
    return np.asarray(np.where(falls, 1 - error, error))


def _regressed(known: Floats, truth: Mask, asked: Floats) -> Floats:
    """Probability by logistic regression on the logarithms."""
    design = np.column_stack([np.ones(len(known)), known])

    def loss(x: Floats) -> float:
        z = design @ x
        return float(np.sum(np.logaddexp(0.0, z) - truth * z))

    found = minimize(loss, np.zeros(design.shape[1])).x
    return np.asarray(expit(np.column_stack([np.ones(len(asked)), asked]) @ found))


if __name__ == "__main__":
    table = run(sys.argv[1])
    write_csv(table, Path(sys.argv[2]))
    print(table.to_string())
