"""The end of a campaign: which records have no usable run."""

import csv
import logging
import sys
from pathlib import Path

from freerock.files import write_text

log = logging.getLogger("freerock")


def complete(campaign: str, runs: str | Path, output: str | Path) -> None:
    """Write how many records and runs there are, or end with a line for each record without a usable run.

    Parameters
    ----------
    campaign : str
        Its name, for the messages.
    runs : path
        Table runs.csv of the campaign.
    output : path
        File to write, in the folder of the campaign's products.
    """
    with open(runs, newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    records: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        records.setdefault(row["test"], []).append(row)
    why_failed = {test: _failed(own) for test, own in records.items()}
    failed = [f"{campaign}: record {test} failed: {why}" for test, why in why_failed.items() if why]
    if failed:
        report = f"{Path(output).with_name('report.html')}: the report, with the reasons"
        log.error("\n".join([report, *failed]))
        sys.exit(1)
    number = sum(row["run"] != "" for row in rows)
    write_text(output, f"{len(records)} records, {number} runs\n")


def _failed(rows: list[dict[str, str]]) -> str:
    """Why a record has no usable run, empty where it has one or all its runs are excluded."""
    kept = [row for row in rows if row["excluded"] != "True"]
    return "; ".join(row["reasons"] for row in kept) if {row["verdict"] for row in kept} == {"fail"} else ""
