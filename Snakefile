"""Free-rocking tests: from laser records to θ(t), runs, restitution, identified models and a report.

record file → record → fit → quality, tables, figure → report → complete
"""

from snakemake.utils import min_version

min_version("9.27")


include: "workflow/rules/common.smk"
include: "workflow/rules/records.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"


rule all:
    default_target: True
    input:
        [products(campaign) for campaign in CAMPAIGNS],


onstart:
    print(f"freerock: {', '.join(f'{name} ({len(tests)} records)' for name, tests in RECORDS.items())}")


onerror:
    print(f"freerock: the log of this run is {', '.join(log)}", file=sys.stderr)
