# What a job takes on a cluster: megabytes, twice what was measured, and minutes; batches of records take a minute more
# for each. Steps record, fit and quality of a batch are one job there (group "batch"): with the largest memory and the
# sum of the minutes. Of all other rules: default-resources in profiles/slurm/config.yaml.
TAKES = {
    "record": {"mem_mb": 400, "runtime": 5},
    "fit": {"mem_mb": 700, "runtime": 5},
    "quality": {"mem_mb": 500, "runtime": 5},
    "tables": {"mem_mb": 1000},
    "report": {"mem_mb": 1000},
}


def resources_of(step, n_records=0):
    """Resources of a job; more at the next attempt."""

    def growing(first):
        return lambda wildcards, attempt: first * attempt

    return {name: growing(first + n_records * (name == "runtime")) for name, first in TAKES[step].items()}


def of_batch(step, n_records):
    """Resources of a batch of records, whose rule has no name one knows; --set-resources names the step."""
    asked = workflow.resource_settings.overwrite_resources.get(step, {})
    return resources_of(step, n_records) | {name: value_of(each) for name, each in asked.items()}


def value_of(resource):
    """The value of a resource of the command line, or a function where it is an expression."""
    if not resource.is_evaluable():
        return resource.value

    def evaluated(wildcards, input, threads, rulename, attempt, async_run):
        known = {"input": input, "threads": threads, "rulename": rulename, "attempt": attempt}
        known["async_run"] = async_run
        return resource.evaluate(wildcards, **known).value

    return evaluated
