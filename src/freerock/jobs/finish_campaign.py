"""The end of a campaign: which records have no usable run.

Whether a product is whole is told elsewhere: it is moved into place when it is (`files.atomic`), and
`freerock verify` holds it against the checksums that `make_report` writes.
"""

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
    records = _rows_by_record(runs)
    failed = [f"{campaign}: record {test} failed: {why}" for test, why in _why_failed(records).items()]
    if failed:
        report = f"{Path(output).with_name('report.html')}: the report, with the reasons"
        log.error("\n".join([report, *failed]))
        sys.exit(1)
    numbers = {"record": len(records)}
    numbers["run"] = sum(row["run"] != "" for rows in records.values() for row in rows)
    write_text(output, ", ".join(f"{n} {what}{'s' * (n != 1)}" for what, n in numbers.items()) + "\n")


def _why_failed(records: dict[str, list[dict[str, str]]]) -> dict[str, str]:
    return {test: why for test, rows in records.items() if (why := _failed(rows))}


def _rows_by_record(runs: str | Path) -> dict[str, list[dict[str, str]]]:
    records: dict[str, list[dict[str, str]]] = {}
    with open(runs, newline="", encoding="utf-8") as table:
        for row in csv.DictReader(table):
            records.setdefault(row["test"], []).append(row)
    return records


def _failed(rows: list[dict[str, str]]) -> str:
    """Why a record has no usable run, empty where it has one or all its runs are excluded."""
    kept = [row for row in rows if row["excluded"] != "True"]
    return "; ".join(row["reasons"] for row in kept) if {row["verdict"] for row in kept} == {"fail"} else ""
