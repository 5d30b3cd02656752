"""What a data repository asks of a supplement: who, what, which licence; CITATION.cff, DataCite, README."""

import json
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from freerock.config.campaign import Campaign
from freerock.errors import FreerockError
from freerock.tables.number_text import SIMULATED_NOTE

DOI = re.compile(r"\b10\.\d{4,9}/[^\s;,]*[^\s;,.]")
SPDX = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]*-[A-Za-z0-9.+-]+")  # BSD-3-Clause, CC-BY-4.0
KEYWORDS = ["rocking", "rigid block", "free rocking test"]
KEYWORDS += ["coefficient of restitution", "system identification"]
SCHEMA = "http://datacite.org/schema/kernel-4"
TEMPLATES = Path(__file__).parent / "templates"  # no room: their words are code of no step


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
    licensed = bool(SPDX.fullmatch(campaign.license))
    return _filled("CITATION.cff.j2", campaign, metadata, licensed=licensed, keywords=KEYWORDS)


def datacite_json(campaign: Campaign, metadata: Metadata) -> str:
    """Metadata of the data set in DataCite's schema 4; a repository adds DOI and publisher."""
    creators = []
    for name in creators_of(campaign):
        family, given = parted(name)
        personal = {"nameType": "Personal", "givenName": given, "familyName": family} if given else {}
        at = [{"name": campaign.institution}] if campaign.institution and given else []
        creators.append({"name": name, **personal} | ({"affiliation": at} if at else {}))
    related = [(doi, "References") for doi in _cited(campaign) if doi != metadata.paper]
    related += [(metadata.paper, "IsSupplementTo")] if metadata.paper else []
    is_spdx = {"rightsIdentifier": campaign.license, "rightsIdentifierScheme": "SPDX"}
    rights = {"rights": campaign.license} | (is_spdx if SPDX.fullmatch(campaign.license) else {})
    told = " ".join(
        filter(None, [campaign.summary, SIMULATED_NOTE if campaign.origin == "simulated" else ""])
    )
    found: dict[str, Any] = {
        "schemaVersion": SCHEMA,
        "types": {"resourceTypeGeneral": "Dataset", "resourceType": "Free-rocking tests"},
        "titles": [{"title": campaign.title}],
        "creators": creators,
        "subjects": [{"subject": word} for word in KEYWORDS],
        "language": "en",
        "formats": ["application/zip"],
        "publicationYear": metadata.year and str(metadata.year),
        "descriptions": [{"description": told, "descriptionType": "Abstract"}] if told else [],
        "rightsList": [rights] if campaign.license else [],
        "relatedIdentifiers": [
            {"relatedIdentifier": doi, "relatedIdentifierType": "DOI", "relationType": kind}
            for doi, kind in related
        ],
    }
    return json.dumps({key: each for key, each in found.items() if each}, indent=2, ensure_ascii=False) + "\n"


def readme(
    campaign: Campaign,
    metadata: Metadata,
    made_by: Mapping[str, Any],
    captions: Mapping[str, str],
    files: Collection[str],
) -> str:
    """README.md of the supplement, of these files: what is in it, what made it, how to make it again."""
    known = {"made_by": made_by, "captions": captions, "files": files, "note": SIMULATED_NOTE}
    return _filled("README.md.j2", campaign, metadata, **known)


def _filled(template: str, campaign: Campaign, metadata: Metadata, **known: Any) -> str:
    """The text of a template about a campaign; its filter `parted` gives family and given name."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES), trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined
    )
    environment.filters |= {"quoted": _quoted, "parted": parted}
    known |= {"campaign": campaign, "metadata": metadata, "creators": creators_of(campaign)}
    return environment.get_template(template).render(known)


def parted(name: str) -> tuple[str, str]:
    """Family and given name of a person; no given name of anyone else."""
    family, _, given = (part.strip() for part in name.partition(","))
    return family, given


def _cited(campaign: Campaign) -> list[str]:
    """DOIs of the configuration."""
    published = campaign.published.doi if campaign.published else ""
    return list(dict.fromkeys(DOI.findall(f"{campaign.references} {published}")))


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
