"""What an analysis says of records of foreign physics, against what is true of them.

    snakemake --config campaigns=foreign
    python -m freerock_bench.foreign results/foreign docs/evidence.md

reads the tables of the campaign `foreign` and the truths that lie apart from its records, writes
results/studies/foreign.csv and renews the table in the documentation, where it is named.
"""

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.errors import FreerockError, exit_code
from freerock.tables.csvfile import read_csv, write_csv
from freerock_bench.campaigns import COLUMNS, TABLES, Row, Tables, rows_of_record
from freerock_bench.document import in_markdown, renew

TRUTHS = Path("benchmarks/foreign/truths.json")
SURE = 3.0  # u; a number farther from the truth is wrong


def score(folder: Path, truths: Mapping[str, Any]) -> pd.DataFrame:
    """The long table of a campaign's results folder.

    Raises
    ------
    FreerockError
        A table is missing, or can't be read.
    """
    paths = {name: folder / "tables" / f"{name}.csv" for name in TABLES}
    for path in paths.values():
        if not path.is_file():
            remedy = "run `snakemake --config campaigns=foreign`, or name the folder of its results"
            raise FreerockError(path, "there is no such file", remedy)
    return grade({name: read_csv(path) for name, path in paths.items()}, truths)


def grade(tables: Tables, truths: Mapping[str, Any]) -> pd.DataFrame:
    """Rows as of `campaigns.graded`, one case per record.

    Of each run there is a row `rightly warned` (a reason is one that is right) where it is not ok, and a row
    `ok, wrong` (an ok stands over a number more than three u off, or over a law that is not right).
    """
    rows: list[Row] = []
    for test, truth in truths.items():
        own = {name: table[table["test"] == test] for name, table in tables.items() if "test" in table}
        found = [*rows_of_record(own, _as_record(truth), truth["right_choices"])]
        found += [*_of_runs(found, truth)]
        rows += [{"case": test, "test": test} | row for row in found]
    return pd.DataFrame(rows, columns=COLUMNS)


def _as_record(truth: Mapping[str, Any]) -> dict[str, Any]:
    """The truth by the names of a record of the bench."""
    found: dict[str, Any] = {"begins_s": [run["let_go_s"] for run in truth["runs"]]}
    for j, run in enumerate(truth["runs"]):
        found |= {f"run{j}_{name}": value for name, value in truth["parameters"].items()}
        found |= {f"run{j}_volts_impacts_s": np.array(run["impacts_s"])}
        found |= {f"run{j}_volts_r_energy": np.array(run["restitution"])}
    return found


def _of_runs(rows: list[Row], truth: Mapping[str, Any]) -> list[Row]:
    """What the verdict of each run is worth."""
    found = []
    for run in range(1, len(truth["runs"]) + 1):
        own = [row for row in rows if str(row.get("run")) == str(run)]
        says = {row["parameter"]: row for row in own}
        is_ok = bool(says["verdict ok"]["inside"])
        off = [
            row
            for row in own
            if abs(row.get("value", 0.0) - row.get("truth", 0.0)) > SURE * row.get("u", np.inf)
        ]
        alone = bool(says.get("named alone, wrongly", {}).get("inside", False))
        note = " ".join([*(str(row["parameter"]) for row in off), *["law"] * alone])
        found.append({"parameter": "ok, wrong", "run": run, "inside": is_ok and bool(note), "note": note})
        if not is_ok:
            told = {*says["verdict ok"]["note"].replace(";", " ").replace(",", " ").split()}
            right = bool(told & {*truth["right_names"]})
            found.append({"parameter": "rightly warned", "run": run, "inside": right, "note": " ".join(told)})
    return found


def table(frame: pd.DataFrame, truths: Mapping[str, Any]) -> str:
    """A row per record, and one of all."""
    asked = ["verdict ok", "rightly warned", "true law in the set", "named alone, wrongly", "ok, wrong"]
    asked += ["k", "lambda", "r of an impact"]
    lines = []
    for test, own in [*frame.groupby("case", sort=False), ("**all**", frame)]:
        known = own[own["inside"].notna()].groupby("parameter")["inside"]
        counts = {name: f"{int(each.astype(bool).sum())} of {len(each)}" for name, each in known}
        about = truths[str(test)]["about"] if str(test) in truths else ""
        lines.append([test, about, *(counts.get(name, "") for name in asked)])
    return in_markdown(["record", "what it is", *asked], lines)


def main(results: str = "results/foreign", document: str = "") -> None:
    """Grade, write, print, and renew the table of a document."""
    if not TRUTHS.is_file():
        raise FreerockError(TRUTHS, "there is no such file", "run it in the checkout of freerock")
    truths = json.loads(TRUTHS.read_text(encoding="utf-8"))
    frame = score(Path(results), truths)
    write_csv(frame, Path("results/studies/foreign.csv"))
    print(table(frame, truths))
    if document:
        renew(document, "foreign", table(frame, truths))


if __name__ == "__main__":
    sys.exit(exit_code(lambda: main(*sys.argv[1:])))
