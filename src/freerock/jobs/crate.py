"""A supplement as a Workflow Run RO-Crate: ro-crate-metadata.json, which data repositories read.

RO-Crate 1.1 (doi:10.3233/DS-210053) with the profiles Workflow RO-Crate 1.0, Process Run Crate and Workflow
Run Crate 0.5 (doi:10.1371/journal.pone.0309210). No time of packing is written: same files, same bytes.
"""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from freerock.config.campaign import Campaign
from freerock.jobs.metadata import KEYWORDS, SPDX, Metadata, creators_of, parted
from freerock.products.netcdf import start_of

CRATE_FILE = "ro-crate-metadata.json"
RUN_PROFILES = ("process/0.5", "workflow/0.5")
PROFILES = (
    *(f"https://w3id.org/ro/wfrun/{name}" for name in RUN_PROFILES),
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0",
)
CONTEXT = ["https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context"]
SNAKEMAKE = "https://w3id.org/workflowhub/workflow-ro-crate#snakemake"
FORMATS = {
    ".nc": "application/x-netcdf",
    ".csv": "text/csv",
    ".json": "application/json",
    ".yaml": "application/yaml",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".html": "text/html",
    ".md": "text/markdown",
    ".tex": "application/x-tex",
    ".py": "text/x-python",
    ".txt": "text/plain",
}
WORKFLOW = "Snakefile"
Json = dict[str, Any]
DESCRIPTOR: Json = {
    "@id": CRATE_FILE,
    "@type": "CreativeWork",
    "about": {"@id": "./"},
    "conformsTo": [{"@id": "https://w3id.org/ro/crate/1.1"}, {"@id": PROFILES[-1]}],
}


def newest_date(campaign: Campaign) -> str:
    """Day of the newest record that says when it was taken, as 2017-05-02; empty where none does."""
    paths = [Path(f"results/{campaign.name}/records/{each.test}.nc") for each in campaign.records]
    starts = map(start_of, paths)
    return max((start[:10] for start in starts if re.match(r"\d{4}-\d\d-\d\d", start)), default="")


def crate_json(
    campaign: Campaign, metadata: Metadata, made_by: Mapping[str, Any], sums: Mapping[str, tuple[str, int]]
) -> str:
    """Text of ro-crate-metadata.json.

    Parameters
    ----------
    campaign : Campaign
    metadata : Metadata
        Its year counts where no record is dated.
    made_by : mapping
        `provenance.json` of the campaign: versions of the software.
    sums : mapping of str to (str, int)
        SHA-256 and bytes of each file of the supplement, by its path.
    """
    results = f"results/{campaign.name}/"
    made = [name for name in sums if name.startswith(results)]
    read = [campaign.raw, *([campaign.ground_motions.folder] if campaign.ground_motions else []), "config"]
    used = [name for name in sums if name.startswith(tuple(f"{folder}/" for folder in read))]
    creators = [_creator(number, name) for number, name in enumerate(creators_of(campaign), 1)]
    software = [
        _entity(f"#{name}", "SoftwareApplication", name, softwareVersion=version)
        for name, version in made_by["software"].items()
    ]
    root: Json = _entity("./", "Dataset", campaign.title) | {
        "description": campaign.summary or campaign.title,
        "keywords": KEYWORDS,
        "creator": _refer(creators),
        "conformsTo": [{"@id": profile} for profile in PROFILES],
        "hasPart": [{"@id": name} for name in sums],
        "mainEntity": {"@id": WORKFLOW},
        "mentions": [{"@id": "#analysis"}],
    }
    if date := newest_date(campaign) or (str(metadata.year) if metadata.year else ""):
        root["datePublished"] = date
    further: list[Json] = []
    if SPDX.fullmatch(name := campaign.license):
        further.append(_entity(f"https://spdx.org/licenses/{name}", "CreativeWork", name))
        root["license"] = {"@id": further[-1]["@id"]}
    elif name:
        root["license"] = name
    if doi := metadata.paper:
        further.append(_entity(f"https://doi.org/{doi}", "ScholarlyArticle", f"doi:{doi}"))
        root["isBasedOn"] = {"@id": further[-1]["@id"]}
    told = f"Analysis of {campaign.name} by freerock {made_by['software']['freerock']}"
    analysis = _entity("#analysis", "CreateAction", told) | {
        "instrument": {"@id": WORKFLOW},
        "object": [{"@id": name} for name in used],
        "result": [{"@id": name} for name in made],
    }
    language = _entity(SNAKEMAKE, "ComputerLanguage", "Snakemake", softwareRequirements=_refer(software))
    graph = [DESCRIPTOR, root, *creators, analysis, language, *software, *further]
    for profile in PROFILES:
        name, version = profile.rsplit("/", 2)[1:]
        graph.append(_entity(profile, "CreativeWork", name, version=version))
    graph += [_file(name, *sums[name]) for name in sums]
    return json.dumps({"@context": CONTEXT, "@graph": graph}, indent=1, ensure_ascii=False) + "\n"


def _entity(at: str, kind: str, name: str, **more: Any) -> Json:
    return {"@id": at, "@type": kind, "name": name, **more}


def _creator(number: int, name: str) -> Json:
    family, given = parted(name)
    if not given:
        return _entity(f"#creator-{number}", "Organization", name)
    whole = f"{given} {family}"
    return _entity(f"#creator-{number}", "Person", whole, givenName=given, familyName=family)


def _file(name: str, sha256: str, n_bytes: int) -> Json:
    found: Json = {"@id": name, "@type": "File", "sha256": sha256, "contentSize": str(n_bytes)}
    if name == WORKFLOW:
        found |= {
            "@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow"],
            "name": "freerock: from laser records to identified models",
            "programmingLanguage": {"@id": SNAKEMAKE},
        }
    if form := FORMATS.get(Path(name).suffix):
        found["encodingFormat"] = form
    return found


def _refer(entities: list[Json]) -> list[Json]:
    return [{"@id": each["@id"]} for each in entities]
