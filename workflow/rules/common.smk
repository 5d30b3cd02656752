"""Configuration and input functions of the rules; `config.step_settings` makes the params of a step."""

import os
import sys
from pathlib import Path

import freerock.jobs  # first: from here on Python looks for garbage seldom
from freerock.config import step_settings as settings
from freerock.config.campaign import check_options, load_config
from freerock.config.review_log import log_of
from freerock.errors import FreerockError
from freerock.figures.listed import FIGURES, entry_of, tables_of
from freerock.files import listed_checksums
from freerock.jobs.home import PACKAGE
from freerock.jobs.reruns import code_checksum

os.environ.setdefault("OMP_NUM_THREADS", "1")  # jobs run side by side: threads within one only get in the way
if not os.access(PACKAGE, os.W_OK):  # no room for the compiled integrator beside its source
    os.environ.setdefault("NUMBA_CACHE_DIR", os.path.abspath(".snakemake/numba"))

try:
    check_options(config)
    # Campaigns given by --config or by the workflow that uses this one as a module replace those of config.yaml.
    CAMPAIGNS = load_config("config/config.yaml", config.get("campaigns"))
    CHECKSUMS = {name: listed_checksums(section.raw) for name, section in CAMPAIGNS.items()}
    for section in CAMPAIGNS.values():
        if not os.path.isdir(section.raw):  # a share away, a renamed folder: no records that failed
            raise FreerockError(section.raw, "there is no such folder", "put the record files there")
except FreerockError as error:
    sys.exit(str(error))

RECORDS = {name: {each.test: each for each in section.records} for name, section in CAMPAIGNS.items()}
SCRIPTS = Path(workflow.snakefile).parents[1] / "scripts"

# Beside the parameters of the rules: an edited title or note makes no dataset again.
config["descriptions"] = {name: settings.descriptions(section) for name, section in CAMPAIGNS.items()}


wildcard_constraints:
    campaign="|".join(CAMPAIGNS),
    figure="|".join(FIGURES),
    test=r"\w+",


def code(script, *modules):
    """Checksum of the code of a step, as a parameter: an edited module reruns the steps that import it."""
    return code_checksum(SCRIPTS / f"{script}.py", *modules)


def campaign(wildcards):
    return CAMPAIGNS[wildcards.campaign]


def of_campaign(chosen):
    """Parameter: what is chosen of the settings of a campaign."""
    return lambda wildcards: chosen(campaign(wildcards))


def of_tests(product):
    """Input function: a product of each record of a campaign."""
    return lambda w: [f"results/{w.campaign}/{product.format(test=test)}" for test in RECORDS[w.campaign]]


def of_figures(suffix):
    """A file of each figure of a rule's campaign."""
    return [f"results/{{campaign}}/figures/{name}.{suffix}" for name in FIGURES]


def figure_files(wildcards):
    """Input function: datasets of all tests and tables that a figure reads."""
    datasets = [kind for kind in ("records", "fits") if kind in entry_of(wildcards.figure)["reads"]]
    files = {kind: of_tests(f"{kind}/{{test}}.nc")(wildcards) for kind in datasets}
    return files | {"tables": expand(csv_tables(*tables_of(wildcards.figure)), campaign=wildcards.campaign)}


def csv_tables(*names):
    """Tables of a rule's campaign, as CSV."""
    return [f"results/{{campaign}}/tables/{name}.csv" for name in names]


def raw_files(wildcards):
    """The file of a record and the calibration tables of its lasers; of one that is missing the job tells."""
    section, record = campaign(wildcards), RECORDS[wildcards.campaign][wildcards.test]
    tables = [section.lasers[name].calibration for name in record.lasers]
    files = [f"{section.raw}/{file}" for file in dict.fromkeys([record.file, *tables]) if file]
    return [file for file in files if os.path.exists(file)]


def record_settings(wildcards):
    record = RECORDS[wildcards.campaign][wildcards.test]
    listed = CHECKSUMS[wildcards.campaign].get(record.file, "")
    return settings.record_settings(campaign(wildcards), record, listed)


def fit_settings(wildcards):
    return settings.fit_settings(campaign(wildcards), RECORDS[wildcards.campaign][wildcards.test])


def products(name):
    """All products of a campaign: one that is missing is made again, though nothing else needs it."""
    of_record = [*rules.record.output, *rules.fit.output, *rules.quality.output]
    of_campaign = [
        *rules.tables.output,
        *rules.printed_tables.output,
        *rules.report.output,
        *rules.complete.output,
    ]
    made = expand(of_record, campaign=name, test=RECORDS[name]) + expand(of_campaign, campaign=name)
    return made + expand(rules.figure.output, campaign=name, figure=FIGURES)


def printed_table(name, suffix, title):
    """A table of the paper, for Snakemake's own report."""
    return report(
        f"results/{{campaign}}/tables/{name}.{suffix}",
        caption="../report/tables.rst",
        category="{campaign}",
        subcategory="Tables",
        labels={"table": title, "format": suffix},
    )


def desk_log(wildcards):
    """The log of what was changed at the review desk, where there is one."""
    log = log_of(f"config/campaigns/{wildcards.campaign}.csv")
    return [str(log)] if log.exists() else []
