"""The end of a campaign: fails, with a line for each record that has no usable run."""

import csv
import sys
from pathlib import Path

from freerock.jobs.log import log_to

log = log_to(snakemake.log[0])
with open(snakemake.input.runs, newline="", encoding="utf-8") as table:
    rows = list(csv.DictReader(table))
records, failed = {}, []
for row in rows:
    records.setdefault(row["test"], []).append(row)
for test, own in records.items():
    kept = [row for row in own if row["excluded"] != "True"]
    if {row["verdict"] for row in kept} == {"fail"}:
        reasons = [row["reasons"] for row in kept]
        failed.append(f"{snakemake.wildcards.campaign}: record {test} failed: {'; '.join(reasons)}")
folder = Path(snakemake.output.complete).parent
known = {*records, *(f"qc_{test}" for test in records)}
products = (
    path for pattern in ("records/*.nc", "fits/*.nc", "figures/qc_*.*") for path in folder.glob(pattern)
)
if left := sorted(path.relative_to(folder).as_posix() for path in products if path.stem not in known):
    told = f"{folder}: {', '.join(left)} belong to no record of the campaign's CSV; delete them"
    log.warning(told)
    print(told, file=sys.stderr)
if failed:
    log.error("\n".join(failed))
    sys.exit(1)
runs = sum(row["run"] != "" for row in rows)
Path(snakemake.output.complete).write_text(f"{len(records)} records, {runs} runs\n", encoding="utf-8")
