"""The end of a campaign: which records have no usable run, and which products belong to no record."""

import csv
import logging
import sys
from pathlib import Path

log = logging.getLogger("freerock")


def complete(campaign: str, runs: str | Path, output: str | Path) -> None:
    """Write how many records and runs there are, or end with a line for each record that has no usable run.

    Products of records that are no longer listed are named on the terminal and in the log.

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
    if left := _left_over(Path(output).parent, set(records)):
        warning = (
            f"{Path(output).parent}: {', '.join(left)} belong to no record of the campaign's CSV; delete them"
        )
        log.warning(warning)
        print(warning, file=sys.stderr)
    failed = [
        f"{campaign}: record {test} failed: {why}" for test, own in records.items() if (why := _failed(own))
    ]
    if failed:
        log.error("\n".join(failed))
        sys.exit(1)
    number = sum(row["run"] != "" for row in rows)
    Path(output).write_text(f"{len(records)} records, {number} runs\n", encoding="utf-8")


def _failed(rows: list[dict[str, str]]) -> str:
    """Why a record has no usable run, empty where it has one or all its runs are excluded."""
    kept = [row for row in rows if row["excluded"] != "True"]
    return "; ".join(row["reasons"] for row in kept) if {row["verdict"] for row in kept} == {"fail"} else ""


def _left_over(folder: Path, tests: set[str]) -> list[str]:
    """Products in a campaign's folder that are of none of its tests."""
    known = tests | {f"qc_{test}" for test in tests}
    patterns = ("records/*.nc", "fits/*.nc", "figures/qc_*.*")
    products = (path for pattern in patterns for path in folder.glob(pattern))
    return sorted(path.relative_to(folder).as_posix() for path in products if path.stem not in known)
