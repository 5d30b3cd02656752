"""The supplement of a paper, as a zip: records, configuration, code, datasets, tables, figures, metadata.

example:
  freerock supplement palermo_virtual --paper 10.1016/j.proeng.2017.09.024 --year 2026

All products must be whole (freerock verify). The zip holds:
  README.md, CITATION.cff, datacite.json, ro-crate-metadata.json, SHA256SUMS
  records, configuration, code, and all products: datasets, tables, figures with captions, report
In the unzipped folder `snakemake` makes the same bytes again. Equal products give equal zips.
"""

import re
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable
from pathlib import Path

from freerock.cli.verify_command import refusal, verification
from freerock.config.campaign import load_config
from freerock.errors import FreerockError, printable
from freerock.files import sha256
from freerock.jobs.home import HOME


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN")
    add("--paper", metavar="DOI", type=_doi, help="of the paper")
    add("--year", metavar="YYYY", type=_year, help="of publication; by default the repository adds it")
    add("--output", metavar="FILE", help="by default CAMPAIGN_supplement.zip")


def run(chosen: Namespace) -> None:
    """Write the supplement and print what it is."""
    from freerock.jobs.metadata import Metadata, creators_of
    from freerock.jobs.supplement import pack

    name = chosen.campaign
    campaign = load_config(campaigns=[name]).campaigns[name]
    creators_of(campaign)
    path = Path(chosen.output or f"{name}_supplement.zip")
    if path.suffix != ".zip" or not path.name.isprintable():  # the folder in the zip has its name
        raise FreerockError(path, "is not the name of a zip file", f"name it {name}_supplement.zip")
    told, whole = verification([name])
    if not whole:
        print(told, end="")
        raise refusal(f"results/{name}", [name], told)
    n_files = pack(campaign, HOME, path, Metadata(chosen.paper or "", chosen.year))
    print(printable(f"{path}: {n_files} files, {path.stat().st_size / 1e6:.1f} MB"))
    print(f"sha256 {sha256(path)}")
    for what, key in (("licence", campaign.license), ("institution", campaign.institution)):
        if not key:
            print(f"no {what} in config/campaigns/{name}.yaml: the repository will ask for it")
    if chosen.year is None:
        print("no year: the repository adds it, or give --year")


def _doi(text: str) -> str:
    doi = re.sub(r"^(https?://(dx\.)?doi\.org/|doi:)", "", text.strip())
    if not re.fullmatch(r"10\.\d{4,9}/\S+", doi):
        raise ArgumentTypeError(f"{text!r} is no DOI, as 10.1016/j.proeng.2017.09.024")
    return doi


def _year(text: str) -> int:
    if not re.fullmatch(r"(19|20)\d\d", text):
        raise ArgumentTypeError(f"{text!r} is no year, as 2026")
    return int(text)
