# Before the first job of a run: what a killed run left behind, folders to write to, and times from the future.
#
# The rules that begin with files of the user do this in their input functions. That is the only moment after
# Snakemake knows what it is to do and before it looks for locks: rules are read before, onstart runs after.
# Where the workflow is only read (-n, --dag, --summary, --lint, --unlock …) there is no executor, or a dry one.

from functools import cache

from freerock.cli.check import check_files
from freerock.config.campaign import read_campaign
from freerock.jobs.guard import check_clock, check_room, job_runs, run_starts
from freerock.jobs.watch import check_space, watch_folder
from freerock.virtual_lab.truth import read_truth

if not workflow.is_main_process:
    job_runs()


def makes_something():
    """Whether this is a run and not only a look at the workflow."""
    return workflow.is_main_process and workflow.executor_plugin is not None and not workflow.dryrun


@cache
def start():
    """Of each run, once."""
    if makes_something():
        try:
            check_space()
        except FreerockError as error:
            sys.exit(str(error))
        run_starts()
        watch_folder()


@cache
def start_campaign(name):
    """Of each campaign that something is made of, once."""
    section = CAMPAIGNS[name]
    try:
        if workflow.is_main_process and not os.path.isdir(section.raw):  # a share away, a renamed folder
            raise next(check_files(read_campaign(f"config/campaigns/{name}.yaml")))
        if section.truth:
            read_truth(f"{section.raw}/{section.truth}")
        start()
        if makes_something():
            results = Path("results", name)
            check_room(results)
            check_clock(results.rglob("*"), map(Path, raw_files(section, section.records)))
    except FreerockError as error:
        sys.exit(str(error))


def study_starts(wildcards):
    """Input function of what needs no files."""
    start()
    return []


def raw_files_of(name, records):
    """Input function: the files of some records of a campaign."""

    def files(wildcards):
        start_campaign(name)
        return raw_files(CAMPAIGNS[name], records)

    return files
