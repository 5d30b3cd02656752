"""What a data repository asks of a supplement: who, what, which licence; CITATION.cff, DataCite, README."""

import json
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from freerock.config.campaign import Campaign
from freerock.errors import FreerockError
from freerock.tables.text import SIMULATED_NOTE

DOI = re.compile(r"\b10\.\d{4,9}/[^\s;,]*[^\s;,.]")
SPDX = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]*-[A-Za-z0-9.+-]+")  # BSD-3-Clause, CC-BY-4.0
KEYWORDS = [
    "rocking",
    "rigid block",
    "free rocking test",
    "coefficient of restitution",
    "system identification",
]
SCHEMA = "http://datacite.org/schema/kernel-4"
FOLDERS = {
    "results/NAME/report.html": "the report; open it in a browser",
    "results/NAME/records": "θ(t), runs and impacts of each record, netCDF",
    "results/NAME/fits": "models fitted to each run, netCDF",
    "results/NAME/tables": "all numbers, CSV; those of the paper also as LaTeX and Markdown",
    "results/NAME/figures": "figures as PDF and PNG, the numbers drawn as CSV, captions",
    "results/NAME/provenance.json": "inputs, settings and versions of the software",
    "results/NAME/ledger": "what each product was made from and by, with checksums",
    "RAW": "the record files, and their checksums",
    "config/campaigns": "blocks, foundations, sensors and records; all settings",
    "docs/datasets.md": "what every variable and column means, with units",
    "docs/glossary.md": "the words",
    "Snakefile, workflow, src": "the code, freerock",
    "SHA256SUMS": "checksums of all files but the ledger's",
    "ro-crate-metadata.json": "all of this as a Workflow Run RO-Crate, for repositories and programs",
}
AGAIN = """\
```sh
sha256sum --check --quiet SHA256SUMS   # every file as it was packed
make setup
. .venv/bin/activate
freerock verify {name}   # every product as a run would make it
snakemake --forceall   # everything anew, from the records
sha256sum --check --quiet SHA256SUMS
```"""


@dataclass(frozen=True)
class Metadata:
    """What the configuration does not say.

    Parameters
    ----------
    paper : str
        DOI of the paper that this is the supplement of, empty where it has none yet.
    year : int, optional
        Of publication; a repository adds it where it is left out.
    """

    paper: str = ""
    year: int | None = None


def creators_of(campaign: Campaign) -> list[str]:
    """The names in `creator`, parted by semicolons, or the institution.

    Raises
    ------
    FreerockError
        There is neither.
    """
    names = [name.strip() for name in campaign.creator.split(";") if name.strip()]
    if not (names or campaign.institution):
        where = f"config/campaigns/{campaign.name}.yaml"
        raise FreerockError(where, "names no creator", "add creator: Family, Given; Family, Given")
    return names or [campaign.institution]


def citation_cff(campaign: Campaign, metadata: Metadata) -> str:
    """CITATION.cff of the data set, version 1.2.0 of the format; its strings are JSON's, which YAML reads."""
    article = f" and the article it belongs to, https://doi.org/{metadata.paper}" if metadata.paper else ""
    message = f"Please cite this data set{article}."
    lines = ["cff-version: 1.2.0", f"message: {_quoted(message)}", "type: dataset"]
    lines += [f"title: {_quoted(campaign.title)}"]
    if campaign.summary:
        lines.append(f"abstract: {_quoted(campaign.summary)}")
    lines.append("authors:")
    for name in creators_of(campaign):
        family, _, given = name.partition(",")
        if given:
            lines += [
                f"  - family-names: {_quoted(family.strip())}",
                f"    given-names: {_quoted(given.strip())}",
            ]
        else:
            lines.append(f"  - name: {_quoted(name)}")
    if SPDX.fullmatch(campaign.license):
        lines.append(f"license: {campaign.license}")
    lines += ["keywords:", *(f"  - {word}" for word in KEYWORDS)]
    return "\n".join([*lines, ""])


def datacite_json(campaign: Campaign, metadata: Metadata) -> str:
    """Metadata of the data set in DataCite's schema 4; a repository adds DOI and publisher."""
    creators = []
    for name in creators_of(campaign):
        family, _, given = (part.strip() for part in name.partition(","))
        personal = {"nameType": "Personal", "givenName": given, "familyName": family} if given else {}
        at = [{"name": campaign.institution}] if campaign.institution and given else []
        creators.append({"name": name, **personal} | ({"affiliation": at} if at else {}))
    related = [(doi, "References") for doi in _cited(campaign) if doi != metadata.paper]
    related += [(metadata.paper, "IsSupplementTo")] if metadata.paper else []
    found: dict[str, Any] = {
        "schemaVersion": SCHEMA,
        "types": {"resourceTypeGeneral": "Dataset", "resourceType": "Free-rocking tests"},
        "titles": [{"title": campaign.title}],
        "creators": creators,
        "subjects": [{"subject": word} for word in KEYWORDS],
        "language": "en",
        "formats": ["application/zip"],
    }
    if metadata.year:
        found["publicationYear"] = str(metadata.year)
    if campaign.summary or campaign.origin == "simulated":
        told = " ".join(
            filter(None, [campaign.summary, SIMULATED_NOTE if campaign.origin == "simulated" else ""])
        )
        found["descriptions"] = [{"description": told, "descriptionType": "Abstract"}]
    if campaign.license:
        spdx = {"rightsIdentifier": campaign.license, "rightsIdentifierScheme": "SPDX"}
        found["rightsList"] = [
            {"rights": campaign.license} | (spdx if SPDX.fullmatch(campaign.license) else {})
        ]
    if related:
        found["relatedIdentifiers"] = [
            {"relatedIdentifier": doi, "relatedIdentifierType": "DOI", "relationType": kind}
            for doi, kind in related
        ]
    return json.dumps(found, indent=2, ensure_ascii=False) + "\n"


def readme(
    campaign: Campaign,
    metadata: Metadata,
    made_by: Mapping[str, Any],
    captions: Mapping[str, str],
    files: Collection[str],
) -> str:
    """README.md of the supplement, of these files: what is in it, what made it, how to make it again."""
    by = ["; ".join(creators_of(campaign)), campaign.institution]
    licence = f"Data: {campaign.license}. " if campaign.license else ""
    versions = ", ".join(f"{name} {version}" for name, version in made_by["software"].items())
    folders = {
        name.replace("NAME", campaign.name).replace("RAW", campaign.raw): does
        for name, does in FOLDERS.items()
        if not name.startswith("docs/") or name in files
    }
    parts = [
        f"# {campaign.title}",
        f"**{SIMULATED_NOTE}**" if campaign.origin == "simulated" else "",
        campaign.summary,
        f"By {', '.join(dict.fromkeys(filter(None, by)))}.",
        f"Supplement of https://doi.org/{metadata.paper}." if metadata.paper else "",
        f"{licence}Code: BSD-3-Clause, see LICENSE.",
        f"## What is here\n\n{len(campaign.records)} records.",
        "\n".join(["| | |", "|---|---|", *(f"| `{name}` | {does} |" for name, does in folders.items())]),
        "## Make it again",
        "Python 3.11 or newer. `make setup` installs the versions of requirements.lock, once.",
        AGAIN.format(name=campaign.name),
        "The same versions of the software and the same kind of processor give the same bytes; on another "
        "processor `freerock compare` shows the differences. "
        f"Files of `results/{campaign.name}/ledger` tell how files "
        "looked on the machine that made them; they have no checksum.",
        f"Made by {versions}; state of the code: {made_by['git']}.",
        "## Figures",
        "\n".join(f"{n}. `{name}`: {text}" for n, (name, text) in enumerate(captions.items(), 1)),
    ]
    return "\n\n".join(filter(None, parts)) + "\n"


def _cited(campaign: Campaign) -> list[str]:
    """DOIs of the configuration."""
    published = campaign.published.doi if campaign.published else ""
    return list(dict.fromkeys(DOI.findall(f"{campaign.references} {published}")))


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
