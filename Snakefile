"""Free-rocking tests: from laser records to θ(t), runs, restitution, identified models and a report.

record file → record → fit → qc, tables, figures → report → complete
"""

import atexit
import gc

from snakemake.utils import min_version

min_version("9.27")
# What a plan is made of stays: looking for garbage in it, and once more at the end, takes a sixth of its time.
gc.set_threshold(1_000_000)
atexit.register(gc.freeze)

# Campaigns given by --config or by the workflow that uses this one as a module. Without them freerock.config.campaign reads
# config/config.yaml and tells its mistakes line by line, which the directive configfile would not.
given = config.get("campaigns")


include: "workflow/rules/common.smk"
include: "workflow/rules/start.smk"
include: "workflow/rules/records.smk"
include: "workflow/rules/campaign.smk"
include: "workflow/rules/targets.smk"
include: "workflow/rules/studies.smk"


rule all:
    default_target: True
    input:
        expand("results/{campaign}/complete.txt", campaign=CAMPAIGNS),


onstart:
    # Without its limit of jobs per second, which none here reaches: each job that ends would leave a timer that
    # looks at all open jobs once a second, a fifth of the processor time of 600 records.
    workflow.scheduler.job_rate_limiter = None


onerror:
    atexit.register(print, "\n".join(why_failed(log)), file=sys.stderr)  # last, below Snakemake's own lines
