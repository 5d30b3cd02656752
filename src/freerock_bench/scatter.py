"""Impacts that scatter: law, numbers, σ_r, restitution, means and the next run, from volts, against truth.

Records of `scattered`, three runs each; a case is a σ_r.
"""

from pathlib import Path

import pandas as pd

from freerock_bench import campaigns, scattered
from freerock_bench.document import in_markdown

SEED = 11
SIGMAS = (0.0, 0.003, 0.01, 0.03)
RECORDS = {"full": 34, "small": 1}  # of each σ_r, a hundred runs; thirty make a round


def make(folder: Path, case: tuple[float, int]) -> Path:
    """Make a record, unless it is there."""
    return scattered.make(folder, *case, SEED)


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table."""
    sigmas = SIGMAS if size == "full" else SIGMAS[::2]
    cases = [(sigma, i) for sigma in sigmas for i in range(RECORDS[size])]
    return campaigns.study(folder, make, cases, _case, cores)


def _case(truth: dict[str, float]) -> str:
    return f"σ_r {100 * float(truth['true_sigma_r']):g} %"


def markdown(frame: pd.DataFrame) -> str:
    """A column for each σ_r; k on each foundation; then which law was named for which."""
    of_k = "k, " + frame["scene"].str.split().str[-1]
    numbers = frame.assign(parameter=frame["parameter"].mask(frame["parameter"] == "k", of_k))
    first = frame[frame["parameter"] == "true law first"]
    named = pd.crosstab(first["scene"].str.rsplit(n=2).str[0], first["note"].fillna("none"))
    confused = in_markdown(["true law", *named], [[name, *row] for name, *row in named.itertuples()])
    return f"{campaigns.markdown(numbers)}\n\n{confused}"
