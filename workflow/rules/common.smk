import logging
import os
import re
import sys
from functools import cache
from pathlib import Path

from freerock.config import step_settings as settings
from freerock.config.campaign import check_options, load_config
from freerock.config.figure_names import FIGURES
from freerock.config.review_log import log_of
from freerock.config.values import did_you_mean
from freerock.errors import FreerockError
from freerock.figures.declared import declared
from freerock.files import listed_checksums
from freerock.jobs.guard import check_folder
from freerock.jobs.home import PACKAGE
from freerock.jobs.ledger import entry_path
from freerock.jobs.log import in_utf8, why_failed
from freerock.jobs.code_identity import code_checksum

os.environ.setdefault("OMP_NUM_THREADS", "1")  # jobs run side by side: threads within one only get in the way
logging.raiseExceptions = False  # no traceback for each line that Snakemake's log has no room for
SCRIPTS = Path(workflow.snakefile).parents[1] / "scripts"
CONFIGURED = ("blocks", "set_ups", "debonding")  # what a figure reads of the configuration
A_CAMPAIGN = "among the campaigns to analyse"


try:
    check_options(config)
    SOURCES = load_config("config/config.yaml", given).sources
    CAMPAIGNS = {name: source.campaign for name, source in SOURCES.items()}
    CHECKSUMS = {name: listed_checksums(section.raw) for name, section in CAMPAIGNS.items()}
    check_folder(Path("results"))
    check_folder(Path(".snakemake"), writable=True)
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
    """A line for each target that is of no record or figure there is; Snakemake says no more than that no rule makes it."""
    for target in map(os.path.normpath, targets):
        if found := re.fullmatch(r"results/(\w+)/(?:records/|fits/|figures/qc_)(\w+)\.\w+", target):
            name, test = found.groups()
            tests = {each.test for each in CAMPAIGNS[name].records} if name in CAMPAIGNS else ()
            no_campaign = unknown(name, CAMPAIGNS, A_CAMPAIGN, f"results/{name}")
            if told := no_campaign or unknown(test, sorted(tests), "a record of this campaign", target):
                yield told
        elif found := re.fullmatch(
            r"results/(?!studies/)\w+/figures/(\w+)\.(?:pdf|png|csv|txt)", target
        ):
            if told := unknown(found[1], dict.fromkeys(FIGURES), "a figure", target):
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


def figure_files(name, figures):
    """Input function: what some figures of a campaign read, by name."""
    folder, tests = f"results/{name}", [each.test for each in CAMPAIGNS[name].records]
    files = {kind: [f"{folder}/{kind}/{test}.nc" for test in tests] for kind in ("records", "fits")}
    names = dict.fromkeys(each for figure in figures for each in declared_of(figure)["reads"])
    return {each: files.get(each, f"{folder}/tables/{each}.csv") for each in names if each not in CONFIGURED}


def figure_settings(name, figures):
    """What each of some figures needs to know of a campaign, by the figure's name."""
    section = CAMPAIGNS[name]
    known = {
        "scenes": scenes_of(section.records),
        "blocks": settings.geometries(section),
        "set_ups": settings.set_ups(section),
        "debonding": section.fits.debonding,
    }
    found = {}
    for figure in figures:
        declared = declared_of(figure)
        reads = {*declared["reads"]} | ({"scenes"} if {"records", "fits"} & {*declared["reads"]} else set())
        found[figure] = {each: known[each] for each in known if each in reads} | {
            "origin": section.origin,
            "labels": settings.drawn_labels(section),
            "title": figure_title(name, figure),
            "caption": declared["caption"],
        }
    return found


def reported(wildcards, suffix):
    """Files of the figures of a campaign's report."""
    names = campaign(wildcards).figures
    return [f"results/{wildcards.campaign}/figures/{name}.{suffix}" for name in names]


def declared_of(figure):
    """Title, caption and inputs of a figure."""
    return declared(f"freerock.figures.{figure}")


def modules_of(figures):
    """The modules that draw some figures."""
    return [f"freerock.figures.{figure}" for figure in figures]


def figure_title(campaign, figure):
    return declared_of(figure)["title"].format(Measured=CAMPAIGNS[campaign].origin.capitalize())


def made_by_name(name):
    """PDFs of the figures of a campaign that were asked for by their path, as long as these are there."""
    folder = f"results/{name}"
    return [
        f"{folder}/figures/{figure}.pdf"
        for figure in FIGURES
        if os.path.exists(f"{folder}/figures/{figure}.pdf")
        and os.path.exists(entry_path(f"{folder}/logs/figure_{figure}.log"))
    ]


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
