"""What steps get of the configuration: no text that only describes, yet datasets hold these texts."""

from pathlib import Path

import pytest

from freerock.config import step_settings as steps
from freerock.config.campaign import load_campaign
from freerock.jobs.descriptions import described

ROOT = Path(__file__).parents[2]
TEXTS = ("title", "summary", "institution", "creator", "license", "references")


@pytest.fixture(scope="module")
def palermo():
    return load_campaign(ROOT / "config/campaigns/palermo_virtual.yaml")


def computing(campaign):
    """Settings of the steps that compute."""
    checksums = {record.file: "0" * 64 for record in campaign.records}
    return [
        steps.record_settings(campaign, campaign.records, checksums),
        steps.fit_settings(campaign, campaign.records),
        steps.geometries(campaign),
    ]


@pytest.mark.parametrize("name", TEXTS)
def test_a_text_of_the_campaign_is_no_setting_of_a_step_that_computes(palermo, name):
    edited = palermo.model_copy(update={name: "edited"})
    assert computing(edited) == computing(palermo)
    assert steps.descriptions(edited) != steps.descriptions(palermo)


def test_notes_and_labels_are_no_settings_of_a_step_that_computes(palermo):
    blocks = {name: each.model_copy(update={"label": "edited"}) for name, each in palermo.blocks.items()}
    records = tuple(record.model_copy(update={"note": "edited"}) for record in palermo.records)
    edited = palermo.model_copy(update={"blocks": blocks, "records": records})
    assert computing(edited) == computing(palermo)
    assert steps.labels(edited) != steps.labels(palermo)
    assert set(steps.descriptions(edited)["comments"].values()) == {"edited"}


def test_attributes_of_a_dataset_are_complete_and_none_is_empty(palermo):
    record = palermo.records[0].model_copy(update={"note": "cold day"})
    campaign = palermo.model_copy(update={"records": (record,), "license": ""})
    own, _ = steps.fit_settings(campaign, campaign.records)
    described_by = {campaign.name: steps.descriptions(campaign)}
    attributes = described(own, described_by)[record.test]["attributes"]
    block = campaign.blocks[record.block]
    expected = {
        "title": f"{campaign.title}: {record.test}",
        "summary": campaign.summary,
        "campaign": "palermo_virtual",
        "test": record.test,
        "block": record.block,
        "foundation": record.foundation,
        "origin": "simulated",
        "block_height_m": block.height_m,
        "block_width_m": block.width_m,
        "block_mass_kg": block.mass_kg,
        "institution": campaign.institution,
        "creator_name": campaign.creator,
        "references": campaign.references,
        "comment": "cold day",
    }
    assert list(attributes.items()) == [(name, value) for name, value in expected.items() if value]
    assert own[record.test]["block"] == described(own, described_by)[record.test]["block"]
