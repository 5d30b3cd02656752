"""The end of a campaign: fails, with a line for each record that has no usable run."""

import csv
import sys
from pathlib import Path

from freerock.workflow import log_to

log = log_to(snakemake.log[0])
with open(snakemake.input.runs, newline="", encoding="utf-8") as table:
    rows = list(csv.DictReader(table))
verdicts, failed = {}, []
for row in rows:
    verdicts.setdefault(row["test"], []).append(row["verdict"])
for test, found in verdicts.items():
    if set(found) == {"fail"}:
        reasons = [row["reasons"] for row in rows if row["test"] == test]
        failed.append(f"{snakemake.wildcards.campaign}: record {test} failed: {'; '.join(reasons)}")
if failed:
    log.error("\n".join(failed))
    sys.exit("\n".join(failed))
runs = sum(row["run"] != "" for row in rows)
Path(snakemake.output.complete).write_text(f"{len(verdicts)} records, {runs} runs\n", encoding="utf-8")
