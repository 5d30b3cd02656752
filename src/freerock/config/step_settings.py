"""What a step gets of the configuration: plain values, and only those it uses, since their edits rerun it.

Texts that only describe (title, summary, notes) are no settings of a step that computes: see `descriptions`.
"""

import math
import re
from functools import lru_cache
from typing import Any

from freerock.config.campaign import Campaign
from freerock.config.input_uncertainties import inputs_of
from freerock.config.record import Record, Scene
from freerock.config.values import Section

Settings = dict[str, Any]
NUMBERED = re.compile(r"\w+ ?#?\d+")  # a block's label that says no more than which it is


def section_values(section: Section, *without: str) -> Settings:
    """A section as numbers and texts, in the order of its fields, without some of them."""
    return section.model_dump(mode="json", exclude={*without})


@lru_cache
def laboratory(campaign: Campaign, scene: Scene) -> Settings:
    """What `freerock.rotation.laboratory.Laboratory` is made of: block, lasers and inputs of a record.

    A base that was levelled to ±a lies within, evenly: u = a/√3. A record has one clock and one response, its
    first laser's.
    """
    block, lasers = campaign.blocks[scene.block], {name: campaign.lasers[name] for name in scene.lasers}
    stated = {name: section_values(each.uncertainty) for name, each in lasers.items()}
    stated |= {scene.block: section_values(block.uncertainty)}
    inputs = inputs_of((scene.block, block.block), lasers, stated)
    levelled = campaign.foundations[scene.foundation].levelled_deg
    if levelled:
        u = levelled / math.sqrt(3)
        inputs.append({"owner": scene.foundation, "name": "levelled_deg", "stated": True, "u": u})
    own = {name: section_values(each, "uncertainty", "calibration") for name, each in lasers.items()}
    return {"block": block.shape, "lasers": own, "inputs": inputs}


def record_attributes(campaign: Campaign, record: Record) -> Settings:
    """What identifies a record in its datasets."""
    found = {"campaign": campaign.name, "test": record.test, "block": record.block}
    found |= {"foundation": record.foundation, "origin": campaign.origin}
    shape = campaign.blocks[record.block].shape
    return found | {f"block_{name}": value for name, value in shape.items() if value}


def descriptions(campaign: Campaign) -> Settings:
    """The texts that describe a campaign and its records in their datasets, empty where there are none.

    They reach the scripts beside the parameters of their rules: a dataset has them as they are when it is
    made, and an edited text alone makes no dataset again.
    """
    return {
        "title": campaign.title,
        "summary": campaign.summary,
        "institution": campaign.institution,
        "creator_name": campaign.creator,
        "license": campaign.license,
        "references": campaign.references,
        "comments": {record.test: record.note for record in campaign.records if record.note},
    }


def record_settings(campaign: Campaign, record: Record, sha256: str) -> Settings:
    """What `freerock.jobs.make_record.make_record` needs; `sha256` as the manifest lists it, else empty."""
    return {
        "raw": campaign.raw,
        "file": record.file,
        "sha256": sha256,
        "channels": list(record.channels),
        "attributes": record_attributes(campaign, record),
        "block": campaign.blocks[record.block].shape,
        "lasers": [section_values(campaign.lasers[name], "uncertainty") for name in record.lasers],
        "laboratory": laboratory(campaign, record.scene),
        "overrides": record.overrides,
        "exclusions": record.exclusions,
        "excluded": record.reason if record.excluded else "",
        **({"stretches": record.stretches} if record.stretches else {}),
        "rotation": section_values(campaign.processing.rotation),
        "runs": section_values(campaign.processing.runs),
        "impacts": section_values(campaign.processing.impacts),
    }


def fit_settings(campaign: Campaign, record: Record) -> Settings:
    """What `freerock.jobs.make_fits.make_fits` needs."""
    fits = campaign.fits
    return {
        "attributes": record_attributes(campaign, record),
        "block": campaign.blocks[record.block].shape,
        "laboratory": laboratory(campaign, record.scene),
        "models": list(fits.models),
        "kinematics": list(fits.rivals),
        "free": {model: list(free) for model, free in fits.freed.items()},
        "options": section_values(fits, "models", "kinematics", "free", "parameters", "paper_mode")
        | ({"parameters": fits.given} if fits.given else {}),
        "impacts": section_values(campaign.processing.impacts),
    }


def figure_settings(campaign: Campaign) -> Settings:
    """What `freerock.jobs.make_figure.make_figure` needs."""
    return {
        "origin": campaign.origin,
        "labels": drawn_labels(campaign),
        "scenes": [f"{each.block} on {each.foundation}" for each in campaign.records],
        "blocks": geometries(campaign),
        "set_ups": set_ups(campaign),
    }


def geometries(campaign: Campaign) -> Settings:
    """The blocks by name, as `freerock.models.block.Block` takes them."""
    return {name: each.shape for name, each in campaign.blocks.items()}


def release_angles(campaign: Campaign) -> dict[str, float]:
    """Nominal release angle [degree] of each block that has one."""
    angles = {name: section.release_angle_deg for name, section in campaign.blocks.items()}
    return {name: angle for name, angle in angles.items() if angle}


def labels(campaign: Campaign) -> dict[str, str]:
    """Printed names of the blocks and foundations."""
    printed = {name: block.label for name, block in campaign.blocks.items()}
    return printed | {name: foundation.label for name, foundation in campaign.foundations.items()}


def drawn_labels(campaign: Campaign) -> dict[str, str]:
    """The labels, those of blocks that are numbered only with their slenderness, "Block 3, h/b = 4"."""
    slender = {
        name: f"{block.label}, h/b = {block.height_m / block.width_m:.3g}"
        for name, block in campaign.blocks.items()
        if NUMBERED.fullmatch(block.label)
    }
    return labels(campaign) | slender


def set_ups(campaign: Campaign) -> Settings:
    """By block of the records, the foundations it stood on and the sensors that looked at it."""
    found: Settings = {}
    for record in campaign.records:
        own = found.setdefault(record.block, {"foundations": [], "lasers": []})
        sensors = ({"name": name} | section_values(campaign.lasers[name]) for name in record.lasers)
        shown = [{key: each[key] for key in ("name", "beam", "position_m", "face")} for each in sensors]
        own["lasers"] += [each for each in shown if each not in own["lasers"]]
        if record.foundation not in own["foundations"]:
            own["foundations"].append(record.foundation)
    return found
