"""Changes between two analyses: parameters with their uncertainties, choices, products, provenance.

example:
  freerock compare results/palermo_virtual results/palermo_again --csv changes.csv
"""

from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from freerock.cli.inspect_command import aligned
from freerock.config.mistakes import leaves
from freerock.errors import FreerockError, printable
from freerock.files import read_json
from freerock.models.free_parameters import symbol_of
from freerock.models.laws import MODEL_LABELS
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.number_text import quantity, with_unit

KEY = ["test", "run", "model", "parameter"]
COLUMNS = [*KEY, "unit", "value_a", "stderr_a", "value_b", "stderr_b", "difference", "difference_percent"]
COLUMNS += ["stderr", "ratio", "same_record", "verdict"]
SAME_RECORD = 1.0  # standard errors by which values from the same record may differ
OTHER_RECORD = 2.0  # combined standard errors by which values from two records may differ
UNCOMPARED = ("logs", "benchmarks")
Provenance = dict[str, Any]  # as in provenance.json

JUDGED = f"""\
How a difference is judged: two values from the same record file carry the same noise, so that their standard
errors are correlated and must not be combined; more than {SAME_RECORD:g} standard error (the larger of
the two) is a change, made by settings or software. Values from two record files have independent errors: the
difference is taken over the combined standard error, and more than {OTHER_RECORD:g} of it is a change."""


class Comparison(NamedTuple):
    """What `compare_results` finds; a and b are the two folders."""

    parameters: pd.DataFrame
    outcomes: pd.DataFrame
    only_a: list[str]
    only_b: list[str]
    provenance: pd.DataFrame


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("a", metavar="A", help="results of a campaign, as results/palermo_virtual")
    add("b", metavar="B", help="results to compare with them")
    add("--csv", metavar="FILE", help="write all parameters of both to a table")


def run(chosen: Namespace) -> None:
    """Print what changed."""
    found = compare_results(chosen.a, chosen.b)
    print(printable(comparison_text(found, chosen.a, chosen.b)))
    if chosen.csv:
        write_csv(found.parameters, chosen.csv)


def compare_results(a: str | Path, b: str | Path) -> Comparison:
    """Compare the products of two analyses.

    Parameters
    ----------
    a, b : path
        Results of a campaign, as `results/palermo_virtual`.

    Returns
    -------
    Comparison
        parameters: a row per parameter that either has, columns `COLUMNS`; ratio is the difference over
        stderr, verdict one of "identical", "within", "changed", "failed" (a fit that may not be used),
        "only a", "only b". outcomes: test, run, what ("verdict" of a run or "model" that it needs), a, b;
        those that differ. only_a, only_b: products that the other lacks. provenance: what, a, b; those that
        differ of inputs, configuration, software and code.

    Raises
    ------
    FreerockError
        A folder holds no results of a campaign, or the two have no record in common.
    """
    a, b = Path(a), Path(b)
    made_by, (in_a, in_b) = [_provenance(a), _provenance(b)], map(_products, (a, b))
    checksums = [_checksums(each) for each in made_by]
    if not checksums[0].keys() & checksums[1].keys():
        remedy = "name two analyses of one campaign"
        raise FreerockError(f"{a}, {b}", "no record is in both", remedy)
    tables = [_table(folder, "parameters") for folder in (a, b)]
    outcomes = [_outcomes(a, b, "runs", "verdict"), _outcomes(a, b, "choice", "model")]
    return Comparison(
        _parameters(tables, checksums),
        pd.concat(outcomes, ignore_index=True),
        *(sorted(in_a - in_b), sorted(in_b - in_a)),
        _differences(*map(_settings, made_by)),
    )


def comparison_text(found: Comparison, a: str | Path, b: str | Path) -> str:
    """What a comparison prints: only what differs, and how it was judged."""
    frame = found.parameters
    counts = ", ".join(f"{n} {verdict}" for verdict, n in frame["verdict"].value_counts(sort=False).items())
    parts = [f"a: {a}\nb: {b}", f"Parameters: {counts or 'none'}."]
    differing = frame[~frame["verdict"].isin(["identical", "within"])]
    if len(differing):
        parts.append(_aligned(_parameter_cells(differing)))
    if not frame["verdict"].isin(["identical"]).all():
        parts.append(JUDGED)
    outcomes = [(row.test, row.run, row.what, f"{row.a} → {row.b}") for row in found.outcomes.itertuples()]
    if outcomes:
        parts.append("Verdicts and models needed:\n" + _aligned(outcomes))
    for name, products in (("a", found.only_a), ("b", found.only_b)):
        if products:
            parts.append(f"Products in {name} only:\n" + _aligned([(product,) for product in products]))
    if len(found.provenance):
        rows = [(row.what, f"{row.a} → {row.b}") for row in found.provenance.itertuples()]
        parts.append("Made from other inputs, or by other software:\n" + _aligned(rows))
    else:
        parts.append("Made from the same inputs, by the same configuration and software.")
    return "\n\n".join(parts)


def _table(folder: Path, name: str) -> pd.DataFrame:
    path = folder / f"tables/{name}.csv"
    if not path.is_file():
        raise FreerockError(path, "there is no such table", "name the results of a campaign, as results/NAME")
    return read_csv(path)


def _provenance(folder: Path) -> Provenance:
    path, remedy = folder / "provenance.json", "name the results of a campaign, as results/NAME"
    if not path.exists():
        raise FreerockError(path, "there is no such file", remedy)
    found: Provenance = read_json(path, remedy)
    try:
        _settings(found)
        _checksums(found)
    except (AttributeError, KeyError, TypeError) as error:
        raise FreerockError(path, f"does not state what made the results ({error!r})", remedy) from error
    return found


def _products(folder: Path) -> set[str]:
    inside = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return {path.as_posix() for path in inside if path.parts[0] not in UNCOMPARED}


def _settings(made_by: Provenance) -> dict[str, str]:
    """All of a provenance by dotted key, records by their test instead of their place in the list."""
    records = {each["test"]: each for each in made_by["config"]["records"]}
    by_name = made_by | {"config": made_by["config"] | {"records": records}}
    return {".".join(key): str(value) for key, value in leaves(by_name)}


def _checksums(made_by: Provenance) -> dict[str, str]:
    """Checksum of the record file by test."""
    config = made_by["config"]
    paths = {each["test"]: f"{config['raw']}/{each['file']}" for each in config["records"]}
    return {test: made_by["inputs"].get(path, "") for test, path in paths.items()}


def _parameters(frames: Sequence[pd.DataFrame], checksums: Sequence[Mapping[str, str]]) -> pd.DataFrame:
    kept = [frame[[*KEY, "unit", "value", "stderr", "success"]] for frame in frames]
    frame = kept[0].merge(kept[1], on=[*KEY, "unit"], how="outer", suffixes=("_a", "_b"), sort=False)
    same = [checksums[0].get(test, "a") == checksums[1].get(test, "b") for test in frame["test"]]
    difference = frame["value_b"] - frame["value_a"]
    larger = frame[["stderr_a", "stderr_b"]].max(axis=1, skipna=False)
    stderr = np.where(same, larger, np.hypot(frame["stderr_a"], frame["stderr_b"]))
    frame = frame.assign(
        difference=difference,
        difference_percent=100 * difference / frame["value_a"].abs(),
        stderr=stderr,
        ratio=difference / stderr,
        same_record=np.array(same, bool),
    )
    return frame.assign(verdict=[_verdict(row) for row in frame.itertuples()])[COLUMNS]


def _verdict(row: Any) -> str:
    if pd.isna(row.value_a) or pd.isna(row.value_b):
        return "only b" if pd.isna(row.value_a) else "only a"
    in_a, in_b = (row.value_a, row.stderr_a, row.success_a), (row.value_b, row.stderr_b, row.success_b)
    if np.array_equal(np.array(in_a, float), np.array(in_b, float), equal_nan=True):
        return "identical"
    if row.success_a and row.success_b:
        return "within" if abs(row.ratio) <= (SAME_RECORD if row.same_record else OTHER_RECORD) else "changed"
    return "failed"


def _outcomes(a: Path, b: Path, table: str, what: str) -> pd.DataFrame:
    key = ["test", "run"]
    one, other = (_of_runs(_table(folder, table))[[*key, what]] for folder in (a, b))
    frame = one.merge(other, on=key, how="outer", suffixes=("_a", "_b")).fillna("–")
    frame = frame.rename(columns={f"{what}_a": "a", f"{what}_b": "b"})
    return frame[frame["a"] != frame["b"]].assign(what=what)[[*key, "what", "a", "b"]]


def _of_runs(frame: pd.DataFrame) -> pd.DataFrame:
    """The row of each run; in the table choice that of the candidate named, which was its only one once."""
    return frame[frame["status"] == "selected"] if "status" in frame else frame


def _differences(a: Mapping[str, str], b: Mapping[str, str]) -> pd.DataFrame:
    rows = [(name, a.get(name, "–"), b.get(name, "–")) for name in dict.fromkeys([*a, *b])]
    return pd.DataFrame([row for row in rows if row[1] != row[2]], columns=["what", "a", "b"])


def _parameter_cells(frame: pd.DataFrame) -> Sequence[tuple[str, ...]]:
    cells = [("record", "run", "model", "parameter", "a", "b", "b − a / %", "over s.e.", "")]
    for row in frame.itertuples():
        cells.append(
            (
                *(row.test, row.run, MODEL_LABELS[row.model]),
                with_unit(symbol_of(row.parameter), row.unit),
                *(quantity(row.value_a, row.stderr_a), quantity(row.value_b, row.stderr_b)),
                *(quantity(row.difference_percent), quantity(row.ratio), row.verdict),
            )
        )
    return cells


def _aligned(rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"  {line}" for line in aligned(rows))
