"""Impacts that scatter: law, numbers, σ_r, restitution, means and runs left out, from volts, against truth.

Records of `scattered`, three runs each; a case is a σ_r.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from freerock.models.block import Block
from freerock.populations.band import MOST_PEAKS, predicted
from freerock.products.estimates import estimates_in
from freerock.products.runs import motions_in
from freerock.tables.results import open_results
from freerock.tables.swings import measured_swings
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
    frame = campaigns.study(folder, make, cases, _case, cores)
    return pd.concat([frame, held_out(folder, frame)], ignore_index=True)


def held_out(folder: Path, frame: pd.DataFrame) -> pd.DataFrame:
    """Root mean square error of the peaks of a run over their own size, for each candidate that was fitted.

    Its numbers are the means over the other runs of the record; release and inputs are the run's own, and
    no impact scatters.
    """
    results, rows = open_results(folder / "results/bench"), []
    swings = measured_swings(results.tables["restitution"])
    for test, record in results.records.items():
        block = Block(**{name: record.attrs[f"block_{name}"] for name in ("height_m", "width_m", "mass_kg")})
        motions = motions_in(record, record.dataset[["theta"]])
        for own in (known := [*estimates_in([results.fits[test]])]):
            others = [each for each in known if each.model == own.model and each.run != own.run]
            seen = np.stack(swings.get((test, own.run), (np.empty(0), np.empty(0))))[:, :MOST_PEAKS]
            if others and seen.size:
                logs = [np.log([*each.parameters.values()]) for each in others]
                numbers = dict(zip(own.parameters, np.exp(np.mean(logs, axis=0)).tolist(), strict=True))
                told = own, [(numbers, 0.0)], motions[own.run], block, "geometric", seen
                error = np.linalg.norm(predicted(*told)[1][0] - seen[0]) / np.linalg.norm(seen[0])
                rows.append((campaigns.HELD_OUT, test, own.run, own.model, error))
    found = pd.DataFrame(rows, columns=["parameter", "test", "run", "note", "value"])
    return found.merge(frame[["case", "test", "scene"]].drop_duplicates())


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
