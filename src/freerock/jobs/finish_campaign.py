"""The end of a campaign: which records have no usable run.

A product is moved into place once it is whole (`files.atomic`): what a killed process was writing is removed
here. `freerock verify` holds products against the checksums that `make_report` writes.
"""

import csv
import logging
import sys
from pathlib import Path

from freerock.errors import number_of
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
    for half_written in Path(output).parent.rglob(".*.partial*"):
        half_written.unlink(missing_ok=True)
    with open(runs, newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    kept = [row for row in rows if row["excluded"] != "True"]
    usable = {row["test"] for row in kept if row["verdict"] != "fail"}
    why = dict[str, list[str]]()
    for row in kept:
        if row["test"] not in usable:
            why.setdefault(row["test"], []).append(row["reasons"])
    if why:
        report = f"{Path(output).with_name('report.html')}: the report, with the reasons"
        failed = [f"{campaign}: record {test} failed: {'; '.join(each)}" for test, each in why.items()]
        log.error("\n".join([report, *failed]))
        sys.exit(1)
    numbers = {"record": len({row["test"] for row in rows}), "run": sum(row["run"] != "" for row in rows)}
    write_text(output, ", ".join(number_of(n, what) for what, n in numbers.items()) + "\n")
