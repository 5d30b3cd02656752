"""Free-rocking tests: from laser records to θ(t), runs, restitution, identified models and a report.

record file → record → fit → quality, tables, figures → report → complete
"""

import atexit
import gc
from importlib.util import find_spec

from snakemake.utils import min_version

min_version("9.27")
# Python's collector of garbage finds nothing in a plan, whose objects all stay; looking took a sixth of the time.
gc.set_threshold(1_000_000)
atexit.register(gc.freeze)

# Campaigns given by --config or by the workflow that uses this one as a module. Without them freerock.config.campaign reads
# config/config.yaml and reports its mistakes line by line, which the directive configfile would not.
given = config.get("campaigns")


include: "workflow/rules/common.smk"
include: "workflow/rules/resources.smk"
include: "workflow/rules/plan_and_ledger.smk"
include: "workflow/rules/record_and_fit.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/tables_and_report.smk"


if find_spec("freerock_bench"):  # a wheel holds no studies

    include: "workflow/rules/studies.smk"


if not str(rules.complete.output.complete).startswith("results/"):
    sys.exit(
        "module freerock: prefix: is not possible: products lie in results; analyse in a folder of its own"
    )


rule all:
    default_target: True
    input:
        expand("results/{campaign}/complete.txt", campaign=CAMPAIGNS),
        [path for name in CAMPAIGNS for path in made_by_name(name)],


onstart:
    in_utf8()
    tell_plan()


onsuccess:
    if workflow.is_main_process and not workflow.touch:
        check_again()


onerror:
    LAST.extend(why_failed(log))
