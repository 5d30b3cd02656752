"""Changes between two analyses of a campaign: parameters, verdicts, laws, inputs, settings and software.

example:
  freerock compare results/palermo_virtual results/palermo_again --csv changes.csv

A parameter has changed if its values differ by more than one standard error, the larger of the two: both
fits see the same noise, so that their errors are not combined.
"""

from argparse import Namespace
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.cli.inspect_command import aligned
from freerock.config.mistakes import leaves
from freerock.errors import FreerockError, printable
from freerock.files import read_json
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.number_text import quantity

KEY = ["test", "run", "model", "parameter"]
COLUMNS = [*KEY, "unit", "value_a", "stderr_a", "value_b", "stderr_b", "ratio", "verdict"]
Difference = tuple[str, str, str]
NAME_RESULTS = "name the results of a campaign, as results/NAME"


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("a", metavar="A", help="results of a campaign, as results/palermo_virtual")
    add("b", metavar="B", help="results to compare with them")
    add("--csv", metavar="FILE", help="write all parameters of both to a table")


def run(chosen: Namespace) -> None:
    """Print what changed."""
    parameters, others = compare_results(chosen.a, chosen.b)
    print(printable(comparison_text(parameters, others)))
    if chosen.csv:
        write_csv(parameters, chosen.csv)


def compare_results(a: str | Path, b: str | Path) -> tuple[pd.DataFrame, list[Difference]]:
    """Compare the products of two analyses, as `results/palermo_virtual`.

    Returns
    -------
    parameters : pandas.DataFrame
        A row for each parameter of a or b, columns `COLUMNS`: ratio is b minus a over the larger standard
        error; verdict is "identical", "within", "changed", "only a" or "only b".
    others : list of (str, str, str)
        What else differs, in a, in b: verdict and law of a run, and what made the results.

    Raises
    ------
    FreerockError
        A folder holds no results of a campaign.
    """
    folders = Path(a), Path(b)
    made_by = [_made_by(folder) for folder in folders]
    verdicts = [_of_runs(_table(folder, "runs"), "verdict") for folder in folders]
    laws = [_of_runs(_table(folder, "choice").query("status == 'selected'"), "model") for folder in folders]
    others = [*_differing(*verdicts), *_differing(*laws), *_differing(*made_by)]
    return _parameters(*(_table(folder, "parameters") for folder in folders)), others


def comparison_text(parameters: pd.DataFrame, others: Sequence[Difference]) -> str:
    """What a comparison prints: only what differs."""
    counts = parameters["verdict"].value_counts(sort=False)
    parts = ["parameters: " + ", ".join(f"{n} {verdict}" for verdict, n in counts.items())]
    shown = parameters[~parameters["verdict"].isin(["identical", "within"])]
    rows = [("record", "run", "model", "parameter", "a", "b", "(b − a)/stderr", "")]
    for row in shown.itertuples():
        values = quantity(row.value_a, row.stderr_a), quantity(row.value_b, row.stderr_b)
        rows.append((*map(str, row[1:5]), *values, quantity(row.ratio), row.verdict))
    parts += ["\n".join(aligned(rows))] * (len(rows) > 1)
    parts += ["\n".join(aligned([("what differs", "a", "b"), *others]))] * bool(others)
    return "\n\n".join(parts)


def _parameters(a: pd.DataFrame, b: pd.DataFrame) -> pd.DataFrame:
    kept = [frame[[*KEY, "unit", "value", "stderr"]] for frame in (a, b)]
    frame = kept[0].merge(kept[1], on=[*KEY, "unit"], how="outer", suffixes=("_a", "_b"), sort=False)
    one, other = frame["value_a"], frame["value_b"]
    ratio = (other - one) / frame[["stderr_a", "stderr_b"]].max(axis=1)
    same = (one == other) & (frame["stderr_a"].fillna(0) == frame["stderr_b"].fillna(0))
    cases = [one.isna(), other.isna(), same, ratio.abs() <= 1]
    verdict = np.select(cases, ["only b", "only a", "identical", "within"], "changed")
    return frame.assign(ratio=ratio, verdict=verdict)[COLUMNS]


def _of_runs(frame: pd.DataFrame, column: str) -> dict[str, str]:
    rows = frame[["test", "run", column]].astype(str).itertuples(index=False, name=None)
    return {f"{test}, run {run}: {column}": value for test, run, value in rows}


def _made_by(folder: Path) -> dict[str, str]:
    """All that made the results by its dotted key, a record by its test."""
    found: dict[str, Any] = read_json(folder / "provenance.json", NAME_RESULTS)
    found.pop("products", None)
    records: Iterable[dict[str, Any]] = found.get("config", {}).pop("records", ())
    by_test = {"records": {each["test"]: each for each in records}}
    return {".".join(key): str(value) for key, value in leaves(found | by_test)}


def _differing(a: dict[str, str], b: dict[str, str]) -> Sequence[Difference]:
    pairs = ((name, a.get(name) or "–", b.get(name) or "–") for name in dict.fromkeys([*a, *b]))
    return [pair for pair in pairs if pair[1] != pair[2]]


def _table(folder: Path, name: str) -> pd.DataFrame:
    path = folder / f"tables/{name}.csv"
    if not path.is_file():
        raise FreerockError(path, "there is no such table", NAME_RESULTS)
    return read_csv(path)
