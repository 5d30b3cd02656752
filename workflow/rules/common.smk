import logging
import os
import re
import sys
from pathlib import Path

from freerock.config import step_settings as settings
from freerock.config.campaign import check_options, load_config
from freerock.config.history import log_of
from freerock.config.values import did_you_mean
from freerock.errors import FreerockError
from freerock.figures.declared import declared
from freerock.files import listed_checksums
from freerock.jobs.guard import check_folder, check_notes
from freerock.jobs.home import PACKAGE
from freerock.jobs.log import in_utf8, why_failed
from freerock.jobs.reruns import code_checksum

os.environ.setdefault("OMP_NUM_THREADS", "1")  # jobs run side by side: threads within one only get in the way
logging.raiseExceptions = False  # no traceback for each line that Snakemake's log has no room for
SCRIPTS = Path(workflow.snakefile).parents[1] / "scripts"
A_CAMPAIGN = "among the campaigns to analyse"


try:
    check_options(config)
    CAMPAIGNS = load_config("config/config.yaml", given).campaigns
    CHECKSUMS = {name: listed_checksums(section.raw) for name, section in CAMPAIGNS.items()}
    check_folder(Path("results"))
    check_notes(Path(".snakemake"))
except FreerockError as error:
    sys.exit(str(error))

# Beside the parameters of the rules: an edited title or note makes no dataset again.
config["descriptions"] = {name: settings.descriptions(section) for name, section in CAMPAIGNS.items()}

if not os.access(PACKAGE, os.W_OK):  # no room for the compiled integrator beside its source
    os.environ.setdefault("NUMBA_CACHE_DIR", os.path.abspath(".snakemake/numba"))


wildcard_constraints:
    campaign=r"\w+",
    test=r"\w+",
    block=r"\w+",
    target="single_column|double_column|slide",


def code(script, *modules):
    """Checksum of the files a script runs, as a parameter: an edited module reruns the steps that use it."""
    return code_checksum(SCRIPTS / f"{script}.py", *modules)


def unknown(name, names, kind, target):
    """The line about a name of a target that is none of those there are; empty where it is."""
    remedy = did_you_mean(name, names) or f"use one of {', '.join(names)}"
    return "" if name in names else str(FreerockError(target, f"{name!r} is not {kind}", remedy))


def chosen(name, names, kind, target):
    """A name of a target among those there are; refused in one line where there is none."""
    if told := unknown(name, names, kind, target):
        sys.exit(told)
    return names[name]


def misspelt(targets):
    """A line for each target of a step that is no record's; Snakemake says no more than that no rule makes it."""
    for target in map(os.path.normpath, targets):
        if found := re.fullmatch(r"results/(\w+)/(?:records/|fits/|figures/qc_)(\w+)\.\w+", target):
            name, test = found.groups()
            tests = {each.test for each in CAMPAIGNS[name].records} if name in CAMPAIGNS else ()
            no_campaign = unknown(name, CAMPAIGNS, A_CAMPAIGN, f"results/{name}")
            if told := no_campaign or unknown(test, sorted(tests), "a record of this campaign", target):
                yield told


def campaign(wildcards):
    name = wildcards.campaign
    return chosen(name, CAMPAIGNS, A_CAMPAIGN, f"results/{name}")


def raw_files(section, records):
    """The files of some records and the calibration tables of their lasers, as far as they exist."""
    names = {name: None for record in records for name in record.lasers}
    tables = filter(None, (section.lasers[name].calibration for name in names))
    files = [f"{section.raw}/{file}" for file in [*(record.file for record in records), *tables]]
    return [file for file in files if os.path.exists(file)]  # missing: the script says so


def of_campaign(chosen):
    """Input function: what is chosen of the settings of a rule's campaign."""
    return lambda w: chosen(campaign(w))


def tests_of(wildcards):
    """The tests of a campaign."""
    return [each.test for each in campaign(wildcards).records]


def scenes_of(records):
    """What block stood on what foundation in each of these records, as one word that can be compared."""
    return [f"{each.block} on {each.foundation}" for each in records]


def changes_of(wildcards):
    """Input function: the log of what was changed at the review desk, where there is one."""
    log = log_of(f"config/campaigns/{wildcards.campaign}.csv")
    return [str(log)] if log.exists() else []


def figures_of(section):
    """Of each figure that a campaign can have, in order: its line and the block it is of, if of one."""
    blocks = dict.fromkeys(record.block for record in section.records)
    return {
        line.format(block=block): (line, block)
        for line in FIGURES
        for block in (blocks if "{block}" in line else [None])
    }


def reported(section):
    """Names of the figures that a campaign asks for, in the order of its report."""
    return [name for name, (line, _) in figures_of(section).items() if module_of(line) in section.figures]


def declared_of(line):
    """Title, caption and inputs of the figures of a line."""
    return declared(f"freerock.figures.{module_of(line)}")


def module_of(line):
    """The module that draws the figures of a line."""
    return line.partition("_{")[0]


def figure_of(wildcards):
    """A figure's line, and the campaign's records that it is of."""
    section = campaign(wildcards)
    figures = f"results/{section.name}/figures"
    line, block = chosen(wildcards.figure, figures_of(section), "a figure of this campaign", figures)
    return declared_of(line), [each for each in section.records if block in (None, each.block)]


def figure_module(wildcards):
    return module_of(figures_of(campaign(wildcards))[wildcards.figure][0])


def figure_files(wildcards):
    """Input function: what a figure reads, by name."""
    line, records = figure_of(wildcards)
    folder = f"results/{wildcards.campaign}"
    files = {name: f"{folder}/tables/{name}.csv" for name in line["reads"]}
    files |= {kind: [f"{folder}/{kind}/{each.test}.nc" for each in records] for kind in ("records", "fits")}
    files["maps"] = f"{folder}/misfit_map.nc"
    return {name: files[name] for name in line["reads"] if name != "blocks"}


def figure_settings(wildcards):
    """What a figure needs to know of a campaign."""
    section = campaign(wildcards)
    line, records = figure_of(wildcards)
    known = {"origin": section.origin, "labels": settings.labels(section)}
    known["title"] = figure_title(section.name, wildcards.figure)
    known["caption"] = line["caption"]
    if {"records", "fits"} & {*line["reads"]}:
        known["scenes"] = scenes_of(records)
    if "blocks" in line["reads"]:
        known["blocks"] = settings.geometries(section)
    return known


def figure_title(campaign, figure):
    section = CAMPAIGNS[campaign]
    line, block = figures_of(section)[figure]
    label = block and section.blocks[block].label
    return declared_of(line)["title"].format(block=label, Measured=section.origin.capitalize())


def for_targets(wildcards):
    """The figures of a campaign for each further target it names."""
    section, folder = campaign(wildcards), f"results/{wildcards.campaign}/figures"
    names = reported(section)
    return expand(f"{folder}/{{target}}/{{name}}.pdf", target=section.figures_for, name=names)


def csv_tables(*names):
    """Tables of a rule's campaign, as CSV."""
    return [f"results/{{campaign}}/tables/{name}.csv" for name in names]


def of_all(product):
    """Input function: a product of each record of all campaigns."""
    return lambda w: [
        f"results/{name}/{product.format(test=each.test)}"
        for name, section in CAMPAIGNS.items()
        for each in section.records
    ]


def products(kind):
    """Input function: the records or fits of the tests."""
    return lambda w: expand(f"results/{w.campaign}/{kind}/{{test}}.nc", test=tests_of(w))


def memory(mb):
    """Megabytes of a job on a cluster: twice what was measured; more at the next attempt."""
    return lambda wildcards, attempt: mb * attempt


def minutes(first):
    """Minutes of a job on a cluster; more at the next attempt."""
    return lambda wildcards, attempt: first * attempt


def of_step(step, **resources):
    """Resources of a step's batches, which have no names one knows; --set-resources names the step."""
    asked = workflow.resource_settings.overwrite_resources.get(step, {})
    return resources | {name: value_of(each) for name, each in asked.items()}


def value_of(resource):
    """The value of a resource of the command line, or a function where it is an expression."""
    if not resource.is_evaluable():
        return resource.value

    def evaluated(wildcards, input, threads, rulename, attempt, async_run):
        known = {"input": input, "threads": threads, "rulename": rulename, "attempt": attempt}
        known["async_run"] = async_run
        return resource.evaluate(wildcards, **known).value

    return evaluated
