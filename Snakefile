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
    # Else Snakemake asks ten times a second which jobs are ready, and waits for a second at its end.
    limit = getattr(getattr(workflow, "scheduler", None), "job_rate_limiter", None)
    if limit and limit.max_jobs >= 100 * limit.timespan:  # more than any machine starts
        workflow.scheduler.job_rate_limiter = None
    print(f"freerock: {', '.join(f'{name} ({len(tests)} records)' for name, tests in RECORDS.items())}")


onerror:
    print(f"freerock: the log of this run is {', '.join(log)}", file=sys.stderr)
