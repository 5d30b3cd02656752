# Before the first job of a run: what a killed run left behind, folders to write to, times from the future; and the
# plan is compared with the ledger of what was made, after the last job once more.
#
# The rules that begin with files of the user do this in their input functions. That is the only moment after
# Snakemake knows what it is to do and before it looks for locks: rules are read before, onstart runs after.
# Where the workflow is only read (-n, --dag, --summary, --lint, --unlock …) there is no executor, or a dry one.

import time
from functools import cache

from freerock.cli.check import check_files
from freerock.config.campaign import read_campaign
from freerock.jobs.guard import check_clock, check_room, hold, job_runs, run_starts
from freerock.jobs.soundness import (
    VERIFIED,
    Step,
    compare,
    in_doubt,
    left_over,
    other_software,
    some,
    verified,
)
from freerock.jobs.watch import check_space, watch_folder
from freerock.virtual_lab.truth import read_truth

LAST = []  # lines below all that Snakemake tells
IN_DOUBT = set()  # before the first job, by the logs of their steps
VERIFY = bool(config.get("verify"))  # every file is read, even one that looks as it did
RULES = workflow.current_basedir.get_path_or_uri(secret_free=True)


def say_last():
    """What Snakemake does not tell, when it ends."""
    lines = [*misspelt(getattr(workflow.dag_settings, "targets", ())), *LAST]
    print(*lines, sep="\n", end="\n" * bool(lines), file=sys.stderr)


if workflow.is_main_process:
    atexit.register(say_last)
else:
    job_runs()


def makes_something():
    """Whether this is a run and not only a look at the workflow."""
    return workflow.is_main_process and workflow.executor_plugin is not None and not workflow.dryrun


@cache
def start():
    """Of each run, once."""
    if makes_something():
        check_space()
        run_starts()
        watch_folder()
    if workflow.is_main_process:
        compare_before_choosing()


def compare_before_choosing():
    """Have Snakemake make again what the ledger does not bear out.

    Snakemake takes a file that is there for whole, and what it knows of its making is gone with the folder
    .snakemake. So once it has planned all jobs, and before it chooses those to run, the products in doubt are
    added to those that --forcerun names. There is no public way to do so after the plan is made.
    """
    choose = workflow.dag.update_needrun

    async def compare_and_choose(*arguments, **options):
        workflow.dag.update_needrun = choose
        workflow.dag.forcefiles |= compared().to_make
        await choose(*arguments, **options)

    workflow.dag.update_needrun = compare_and_choose


def compared():
    """The plan compared with the ledger; what is found is told, of a verification nothing else."""
    try:
        found = compare((step for _, step in steps()), thorough=VERIFY)
        if makes_something():
            found.contents.note()
    except FreerockError as error:
        sys.exit(str(error))
    products = {path for step in found.steps for path in step.outputs}
    folders = [Path("results", name) for name in CAMPAIGNS if f"results/{name}/complete.txt" in products]
    if VERIFY and workflow.dryrun:
        told = [verified(found, folder) for folder in folders]
        print(VERIFIED, *(line for lines, _ in told for line in lines), sep="\n")
        sys.exit(not all(whole for _, whole in told))
    IN_DOUBT.update(found.doubts)
    for line in in_doubt(found):
        print(f"{line}: made again", file=sys.stderr)
    if told := other_software(found.entries.values()):
        LAST.append(f"{told}; snakemake --forceall makes everything again")
    for folder in folders:
        if others := left_over(folder, products):
            LAST.append(f"{folder}: not of this configuration: {some(others)}; delete them")
    return found


def steps():
    """The jobs of the plan that are of these rules, in files; as a module they stand in a plan with others."""
    for job in workflow.dag.jobs:
        if any(path.is_storage for path in job.output):  # in an object store
            continue
        if job.output and job.rule.basedir.get_path_or_uri(secret_free=True) == RULES:
            files = [[str(path) for path in paths] for paths in (job.input, job.output)]
            yield job, Step(str(job.log[0]), *files, dict(job.params.items()))


def check_again():
    """Refuse to end well when files were changed in the course of the run; else tell where the reports are."""
    done = [step for job, step in steps() if workflow.dag.finished(job) or str(job.log[0]) not in IN_DOUBT]
    end = time.monotonic() + workflow.execution_settings.latency_wait  # of other machines' files
    while (found := compare(done)).doubts and time.monotonic() < end:
        time.sleep(0.5)
    found.contents.note()
    if found.doubts:
        LAST.extend(in_doubt(found))
        LAST.append("results: files were changed while snakemake was at work; run the same command again")
        sys.exit(1)
    reports = [path for step in done for path in step.outputs if Path(path).name == "report.html"]
    LAST[:0] = [f"{path}: the report; open it in a browser" for path in reports]


@cache
def start_campaign(name):
    """Of each campaign that something is made of, once."""
    section = CAMPAIGNS[name]
    try:
        if workflow.is_main_process and not os.path.isdir(section.raw):  # a share away, a renamed folder
            raise next(check_files(read_campaign(f"config/campaigns/{name}.yaml")))
        if section.truth:
            read_truth(f"{section.raw}/{section.truth}")
        results = Path("results", name)
        if makes_something():
            hold(results)
        start()
        if makes_something():
            check_room(results)
            check_clock(results.rglob("*"), map(Path, raw_files(section, section.records)))
    except FreerockError as error:
        sys.exit(str(error))


@cache
def start_studies():
    """Of the studies, once."""
    try:
        if makes_something():
            hold(Path("results/studies"))
        start()
    except FreerockError as error:
        sys.exit(str(error))


def study_starts(wildcards):
    """Input function of what needs no files."""
    start_studies()
    return []


def raw_files_of(name, records):
    """Input function: the files of some records of a campaign."""

    def files(wildcards):
        start_campaign(name)
        return raw_files(CAMPAIGNS[name], records)

    return files
