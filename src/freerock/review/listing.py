"""The list of all runs of a campaign, from the tables of the last `snakemake`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from freerock.config.record import Record
from freerock.config.review_log import CELLS_BY_HAND
from freerock.errors import FreerockError
from freerock.files import read_json
from freerock.models.laws import MODEL_LABELS
from freerock.tables.csvfile import read_csv

Json = dict[str, Any]


def listed_rows(results: Path) -> dict[str, list[Json]]:
    """The lines of each test by the tables of a campaign; none without tables that can be read."""
    try:
        names = ("runs", "choice", "epsilon")
        return lines_of_runs(*(read_csv(results / f"tables/{name}.csv") for name in names))
    except (FreerockError, OSError, AttributeError, KeyError, ValueError):
        return {}


def lines_of_runs(runs: pd.DataFrame, choice: pd.DataFrame, epsilon: pd.DataFrame) -> dict[str, list[Json]]:
    """The lines of each test in the list of runs, from the tidy tables runs, choice and epsilon.

    Parameters
    ----------
    runs, choice, epsilon : pandas.DataFrame
        Tidy tables; a record without runs has one line.
    """
    selected, fitted = choice[choice["status"] == "selected"], epsilon[epsilon["selected"].astype(bool)]
    chosen = {(row.test, str(row.run)): row for row in selected.itertuples()}
    far = {(row.test, str(row.run)): row.epsilon_theta for row in fitted.itertuples()}
    found: dict[str, list[Json]] = {}
    for row in runs.itertuples():
        own = chosen.get((row.test, str(row.run)))
        found.setdefault(row.test, []).append(
            {key: getattr(row, key) for key in ("test", "block", "foundation", "verdict", "reasons")}
            | {"run": None if pd.isna(row.run) else int(row.run)}
            | {key: _number(getattr(row, key)) for key in ("release_s", "duration_s", "theta0_deg")}
            | {
                "excluded": bool(row.excluded),
                "model": MODEL_LABELS.get(own.model, "") if own else "",
                "explained": own is not None and bool(own.explains),
                "epsilon": _number(far.get((row.test, str(row.run)))),
            }
        )
    return found


def analysed_lines(results: Path) -> dict[str, Mapping[str, Any]]:
    """The records as the campaign's CSV had them at the last report, by test."""
    try:
        config = read_json(results / "provenance.json", "run snakemake")["config"]
        return {str(line["test"]): line for line in config["records"]}
    except (FreerockError, KeyError, TypeError):
        return {}


def is_behind(line: Record, then: Mapping[str, Any] | None) -> bool:
    """Whether a record's cells were changed since it was analysed; not known to be without an analysis."""
    return then is not None and any(then.get(key, "") != getattr(line, key) for key in CELLS_BY_HAND)


def _number(value: Any) -> float | None:
    return None if pd.isna(value) else float(value)
