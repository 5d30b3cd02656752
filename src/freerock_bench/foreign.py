"""What an analysis says of records of foreign physics, against what is true of them.

The records are those of raw/foreign; their truths lie apart. Each record is a case.
"""

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock_bench.campaigns import COLUMNS, ROOT, Row, Tables, analysed, of_test, rows_of_record
from freerock_bench.document import in_markdown

SEED = 0
TRUTHS = ROOT / "benchmarks/foreign/truths.json"
SURE = 3.0  # u; a number farther from the truth is wrong
SMALL = ("rigid_by_side",)


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table."""
    shutil.copytree(ROOT / "raw/foreign", folder / "raw/foreign", dirs_exist_ok=True)
    (folder / "config/campaigns").mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / "config/campaigns/foreign.yaml", folder / "config/campaigns")
    known = {name: each for name, each in truths().items() if size == "full" or name in SMALL}
    head, *lines = (ROOT / "config/campaigns/foreign.csv").read_text(encoding="utf-8").splitlines()
    kept = "\n".join([head, *(line for line in lines if line.split(",")[0] in known)])
    (folder / "config/campaigns/foreign.csv").write_text(kept + "\n", encoding="utf-8")
    (folder / "config/config.yaml").write_text("campaigns: [foreign]\n", encoding="utf-8")
    return grade(analysed(folder, "foreign", cores), known)


def truths() -> dict[str, Any]:
    """What is true of the records."""
    found: dict[str, Any] = json.loads(TRUTHS.read_text(encoding="utf-8"))
    return found


def grade(tables: Tables, truths: Mapping[str, Any]) -> pd.DataFrame:
    """Rows as of `campaigns.graded`, one case per record.

    Of each run there is a row `ok, wrong`: whether an ok stands over a number more than three u off, or over
    a law that is not right.
    """
    rows: list[Row] = []
    for test, truth in truths.items():
        own, right = of_test(tables, test), truth["right_choices"]
        found = [*rows_of_record(own, _as_record(truth), right)]
        found += [*_of_runs(found, truth)]
        rows += [{"case": test, "test": test} | row for row in found]
    return pd.DataFrame(rows, columns=COLUMNS)


def _as_record(truth: Mapping[str, Any]) -> dict[str, Any]:
    """The truth by the names of a record of the bench."""
    found: dict[str, Any] = {"begins_s": [run["let_go_s"] for run in truth["runs"]]}
    for j, run in enumerate(truth["runs"]):
        found |= {f"run{j}_{name}": value for name, value in truth["parameters"].items()}
        found |= {f"run{j}_volts_impacts_s": np.array(run["impacts_s"])}
        found |= {f"run{j}_volts_true_r": np.array(run["restitution"])}
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
    return found


def markdown(frame: pd.DataFrame) -> str:
    """A row per record, and one of all."""
    asked = ["verdict ok", "true law in the set", "named alone, wrongly", "ok, wrong"]
    asked += ["k", "lambda", "r of an impact"]
    lines, about = [], {name: each["about"] for name, each in truths().items()}
    for test, own in [*frame.groupby("case", sort=False), ("**all**", frame)]:
        known = own[own["inside"].notna()].groupby("parameter")["inside"]
        counts = {name: f"{int(each.astype(bool).sum())} of {len(each)}" for name, each in known}
        lines.append([test, about.get(str(test), ""), *(counts.get(name, "") for name in asked)])
    return in_markdown(["record", "what it is", *asked], lines)
