# Before the first job of a run: what a killed run left behind, folders to write to, times from the future; and the
# plan is compared with the ledger of what was made, after the last job once more.
#
# The rules do this in an input function each. That is the only moment after
# Snakemake knows what it is to do and before it looks for locks: rules are read before, onstart runs after.
# Where the workflow is only read (-n, --dag, --summary, --lint, --unlock …) there is no executor, or a dry one.

import time
from functools import cache, partial

from freerock.cli.check_command import check_files, configuration_doubts
from freerock.jobs.newer_input import newer_than
from freerock.jobs.guard import NOTES_BYTES, check_clock, check_room, hold, job_runs, run_starts, watch_folder
from freerock.jobs.ledger import read_entry
from freerock.jobs.code_identity import note_meanings
from freerock.jobs.whole_or_rerun import (
    VERIFIED,
    PlanAgainstLedger,
    PlannedJob,
    compare,
    in_doubt,
    left_over,
    made_by_other_software,
    some,
    verified,
)
from freerock.virtual_lab.truth import read_truth

LAST = []  # lines below all that Snakemake tells
VERIFY = bool(config.get("verify"))  # every file is read, even one that looks as it did
AGAIN = {}  # by step and wildcards of each job of the plan: what makes Snakemake do it again, or nothing


def say_last():
    """What Snakemake does not tell, when it ends."""
    tell_plan()
    lines = [*misspelt(workflow.dag_settings.targets if workflow.dag_settings else ()), *LAST]
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
        check_room(Path(".snakemake"), NOTES_BYTES)
        run_starts()
        watch_folder()
    if workflow.is_main_process and "MTIME" not in {each.name for each in workflow.rerun_triggers}:
        sys.exit(
            "--rerun-triggers: mtime is not among them, by which products in doubt are made again; add it"
        )


@cache
def plan():
    """What the ledger bears out of the plan, to which each job is added as Snakemake comes to it."""
    return PlanAgainstLedger([Path("results", name) for name in (*CAMPAIGNS, "studies")], thorough=VERIFY)


def again(step, name=None, start=None):
    """Input function of a step: a file newer than its products where the ledger does not bear them out.

    Snakemake takes a file that is there for whole, and what it knows of its making is gone with the folder
    .snakemake. The step is of the campaign `name`, or of that of its wildcards.
    """

    def of_job(wildcards):
        (start or partial(start_campaign, name or campaign(wildcards).name))()
        if not workflow.is_main_process or workflow.storage_settings.default_storage_provider:
            return []
        job = step, *sorted(wildcards.items())
        if job not in AGAIN:
            AGAIN[job] = []  # for the inputs of the job, among which this function is
            try:
                planned = as_planned(getattr(rules, step), wildcards)
                made = any(map(os.path.exists, planned.outputs))
                if plan().add(planned) and (made or plan().entries[planned.log]):
                    AGAIN[job] = [newer_than(planned.outputs, Path(planned.log).stem)]
            except FreerockError as error:
                sys.exit(str(error))
        return AGAIN[job]

    return of_job


def as_planned(step, wildcards):
    """A job of a step, as it would be done now."""

    def given(value):
        return value(wildcards) if callable(value) else value

    def files(declared):
        for each in map(given, declared):
            each = [*each.values()] if isinstance(each, dict) else each
            yield from [each.format(**dict(wildcards.items()))] if isinstance(each, str) else flat(each)

    settings = {name: given(value) for name, value in step.params.items()}
    return PlannedJob(next(files(step.log)), [*files(step.input)], [*files(step.output)], settings)


def flat(files):
    """Paths in lists of lists."""
    for each in files:
        yield from [each] if isinstance(each, str) else flat(each)


@cache
def tell_plan():
    """What is made again and why, what else there is in the folders; of a verification nothing else."""
    if not AGAIN:
        return
    found = plan()
    if makes_something():
        found.contents.note()
        note_meanings()
    products = {path for step in found.steps for path in step.outputs}
    folders = [Path("results", name) for name in CAMPAIGNS if f"results/{name}/complete.txt" in products]
    drawn = [Path(path) for folder in folders for path in made_by_name(folder.name)]
    products |= {
        f"{path.with_suffix(suffix)}" for path in drawn for suffix in (".pdf", ".png", ".csv", ".txt")
    }
    if VERIFY and workflow.dryrun:
        told = [verified(found, folder) for folder in folders]
        print(VERIFIED, all(whole for _, whole in told))
        print(*(line for lines, _ in told for line in lines), sep="\n", flush=True)
        return
    for line in in_doubt(found):
        print(f"{line}: made again", file=sys.stderr)
    if told := made_by_other_software(found.entries.values()):
        LAST.append(f"{told}; snakemake --forceall makes everything again")
    for folder in folders:
        if others := left_over(folder, products):
            LAST.append(f"{folder}: not of this configuration: {some(others)}; delete them")


def check_again():
    """Refuse to end well when files were changed in the course of the run; else tell where the reports are."""
    chosen = workflow.dag_settings
    partly = chosen.until or chosen.omit_from or chosen.batch
    before = plan()
    done = [step for step in before.steps if not (partly and left_undone(before, step))]
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


def left_undone(before, step):
    """Whether a step in doubt was not done in the run."""
    return step.log in before.doubts and read_entry(entry_path(step.log)) == before.entries[step.log]


@cache
def start_campaign(name):
    """Of each campaign that something is made of, once."""
    section = CAMPAIGNS[name]
    try:
        if workflow.is_main_process and not os.path.isdir(section.raw):  # a share away, a renamed folder
            raise next(check_files(SOURCES[name]))
        if section.truth:
            read_truth(f"{section.raw}/{section.truth}")
        results = Path("results", name)
        if makes_something():
            hold(results)
        start()
        if makes_something():
            check_room(results)
            check_clock(results.rglob("*"), map(Path, raw_files(section, section.records)))
            for doubt in configuration_doubts(SOURCES[name]):
                print(f"doubt: {doubt}", file=sys.stderr)
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


def raw_files_of(name, records):
    """Input function: the files of some records of a campaign; by content, not by time."""
    return lambda wildcards: [ancient(path) for path in raw_files(CAMPAIGNS[name], records)]
