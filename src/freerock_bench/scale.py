"""What many records take: a campaign of records of three runs, by the workflow of `benchmarks/scale.py`.

A case is a step of the workflow, or the whole with Snakemake. Processor time is that of a record [s], memory
that of the largest job [MB].
"""

import sys
from importlib import import_module
from pathlib import Path

import pandas as pd

from freerock_bench.campaigns import COLUMNS, ROOT
from freerock_bench.document import in_markdown

SEED, RECORDS = 1, {"full": 12, "small": 2}


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table."""
    sys.path.append(str(ROOT / "benchmarks"))
    return pd.DataFrame(import_module("scale").measured(RECORDS[size], cores), columns=COLUMNS)


def markdown(frame: pd.DataFrame) -> str:
    """A row per step."""
    cells = frame.pivot(index="case", columns="parameter", values="value")
    cells = cells.map("{:.1f}".format).replace("nan", "")
    return in_markdown(["step", *cells], ([name, *row] for name, *row in cells.itertuples()))
