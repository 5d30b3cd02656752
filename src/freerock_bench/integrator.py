"""Correct digits of freerock's motions at five tolerances, against the golden solutions: a case each."""

from pathlib import Path

import numpy as np
import pandas as pd

from freerock_bench.campaigns import COLUMNS
from freerock_bench.document import in_markdown
from freerock_bench.golden import ours
from freerock_bench.golden.files import read_golden
from freerock_bench.golden.scenes import scenes
from freerock_bench.golden.score import HEADS, line, score

SEED = 0
RTOLS = {"full": (1e-6, 1e-8, 1e-10, 1e-12, 1e-13), "small": (1e-6,)}


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table: of each scene the digits of θ."""
    golden, found = read_golden(), []
    for rtol in RTOLS[size]:
        motions = {
            name: ours.solve(each, rtol, float(golden[name].time_s[-1])) for name, each in scenes().items()
        }
        graded = score(motions, golden, "freerock")
        digits = {"scene": graded["scene"], "value": np.floor(10 * graded["digits"]) / 10}
        found.append(pd.DataFrame(digits).assign(case=f"freerock, rtol {rtol:g}", parameter="digits"))
    return pd.concat(found).reindex(columns=COLUMNS)


def markdown(frame: pd.DataFrame) -> str:
    """A row per tolerance."""
    cases = frame.rename(columns={"value": "digits"}).groupby("case", sort=False)
    return in_markdown(HEADS, [line(rows, str(case), len(rows)) for case, rows in cases])
