"""Compare the products of campaigns, and the record files they were made from, with their checksums.

example:
  freerock verify palermo_virtual

Reads every file that results/NAME/provenance.json lists and names those that are
  missing
  changed   since the report was made
Exit code 0: all files are as they were. Nothing is made or changed.
"""

from argparse import Namespace
from collections.abc import Callable
from pathlib import Path

from freerock.config.campaign import load_config
from freerock.config.mistakes import refuse
from freerock.errors import FreerockError, number_of
from freerock.files import read_json, sha256

AGAIN = "restore record files; make products again: snakemake --forcerun FILE …"


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", nargs="*", help="by default those of config.yaml")


def run(chosen: Namespace) -> None:
    """Print what differs, and how many files do not; raise when there is anything."""
    problems = list[FreerockError]()
    for name in load_config(campaigns=chosen.campaign or None):
        known = read_json(f"results/{name}/provenance.json", "run snakemake")
        listed: dict[str, str] = known["inputs"] | known["products"]
        told = {path: state_of(path, checksum) for path, checksum in listed.items()}
        differing = [f"{state}: {path}" for path, state in told.items() if state]
        print(*differing, f"{name}: {number_of(len(listed) - len(differing), 'file')} as listed", sep="\n")
        if differing:
            what = f"differs from its provenance.json in {len(differing)} of {len(listed)} files"
            problems.append(FreerockError(f"results/{name}", what, AGAIN))
    refuse(problems)


def state_of(path: str, checksum: str) -> str:
    """What is wrong with a file, in a word; empty where it has the checksum."""
    if not Path(path).is_file():
        return "missing"
    return "" if sha256(path) == checksum else "changed"
