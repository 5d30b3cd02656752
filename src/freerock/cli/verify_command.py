"""Compare the products of campaigns, and the record files they were made from, with their checksums.

example:
  freerock verify palermo_virtual

Reads every file that results/NAME/provenance.json lists and names those that are
  missing
  changed   since the report was made
Exit code 0: all files are as they were. Nothing is made or changed.
"""

from argparse import Namespace
from collections.abc import Callable, Iterator
from pathlib import Path

from freerock.config.campaign import load_config
from freerock.errors import FreerockError
from freerock.files import read_json, sha256


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", nargs="*", help="by default those of config.yaml")


def run(chosen: Namespace) -> None:
    """Print what differs; raise when there is anything."""
    told = [
        line for name in load_config(campaigns=chosen.campaign or None).campaigns for line in differing(name)
    ]
    print(*told, sep="\n", end="\n" * bool(told))
    if told:
        remedy = "restore record files; make products again: snakemake --forcerun FILE …"
        raise FreerockError("results", f"{len(told)} files are not as they were", remedy)


def differing(name: str) -> Iterator[str]:
    """A line for each file of a campaign that is missing or changed.

    Raises
    ------
    FreerockError
        The campaign has no provenance.json.
    """
    known = read_json(f"results/{name}/provenance.json", "run snakemake")
    for path, listed in {**known["inputs"], **known["products"]}.items():
        if not Path(path).is_file():
            yield f"missing: {path}"
        elif sha256(path) != listed:
            yield f"changed: {path}"
