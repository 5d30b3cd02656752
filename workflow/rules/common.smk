import os
import sys
from pathlib import Path

from freerock.config import load_config
from freerock.errors import FreerockError
from freerock.manifest import listed_checksums
from freerock.truth import read_truth
from freerock.workflow import PACKAGE
from freerock.workflow import code as files_run

os.environ.setdefault("OMP_NUM_THREADS", "1")  # jobs run side by side: threads within one only get in the way
SCRIPTS = Path(workflow.snakefile).parents[1] / "scripts"

try:
    CAMPAIGNS = load_config("config/config.yaml", given).campaigns
    CHECKSUMS = {name: listed_checksums(section.raw) for name, section in CAMPAIGNS.items()}
    for section in CAMPAIGNS.values():
        if section.truth:
            read_truth(f"{section.raw}/{section.truth}")
except FreerockError as error:
    sys.exit(str(error))

if not os.access(PACKAGE, os.W_OK):  # no room for the compiled integrator beside its source
    os.environ.setdefault("NUMBA_CACHE_DIR", os.path.abspath(".snakemake/numba"))


wildcard_constraints:
    campaign=r"\w+",
    test=r"\w+",
    block=r"\w+",


def code(script):
    """The files a script runs, as inputs: an edited module reruns the steps that use it."""
    paths = map(Path, files_run(SCRIPTS / f"{script}.py"))
    here = Path.cwd()
    return [local(str(path.relative_to(here) if path.is_relative_to(here) else path)) for path in paths]


def campaign(wildcards):
    return CAMPAIGNS[wildcards.campaign]


def record(wildcards):
    """The line of the campaign's CSV file that a test stands on."""
    return campaign(wildcards).record(wildcards.test)


def raw_files(wildcards):
    """The file of a record and the calibration tables of its lasers."""
    sections = [campaign(wildcards).lasers[name] for name in record(wildcards).lasers]
    tables = [f"{campaign(wildcards).raw}/{each.calibration}" for each in sections if each.calibration]
    return [campaign(wildcards).file(wildcards.test), *tables]


def checksum(wildcards):
    """What the campaign's manifest lists for a record file: renewed there, the record is processed again."""
    return CHECKSUMS[wildcards.campaign].get(record(wildcards).file, "")


def plain(section, *without):
    """A section of the configuration as a rule's parameter: numbers and texts, in the order of its fields."""
    return section.model_dump(mode="json", exclude={*without})


def geometry(section):
    return plain(section, "label", "release_angle_deg")


def geometries(wildcards):
    return {name: geometry(section) for name, section in campaign(wildcards).blocks.items()}


def release_angles(wildcards):
    """Nominal release angle of each block that has one, in degrees."""
    angles = {name: section.release_angle_deg for name, section in campaign(wildcards).blocks.items()}
    return {name: angle for name, angle in angles.items() if angle}


def published(wildcards):
    section = campaign(wildcards).published
    return plain(section) if section else None


def tests(wildcards):
    """The tests of a campaign, or of one block where the rule has that wildcard."""
    block = wildcards.get("block")
    return [each.test for each in campaign(wildcards).records if block in (None, each.block)]


def blocks(wildcards):
    """The blocks that were tested."""
    return list(dict.fromkeys(each.block for each in campaign(wildcards).records))


def products(kind):
    """Input function: the records or fits of the tests."""
    return lambda w: expand(f"results/{w.campaign}/{kind}/{{test}}.nc", test=tests(w))


def labels(wildcards):
    """Printed names of the blocks and foundations of a campaign."""
    sections = {**campaign(wildcards).blocks, **campaign(wildcards).foundations}
    return {name: section.label for name, section in sections.items()}
