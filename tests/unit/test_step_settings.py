"""What steps get of the configuration: no text that only describes, yet datasets hold these texts."""

from pathlib import Path

import pytest

from freerock.config import step_settings as steps
from freerock.config.campaign import load_campaign
from freerock.jobs.descriptions import described

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def palermo():
    return load_campaign(ROOT / "config/campaigns/palermo_virtual.yaml")


def test_attributes_of_a_dataset_are_complete_and_none_is_empty(palermo):
    record = palermo.records[0].model_copy(update={"note": "cold day"})
    campaign = palermo.model_copy(update={"records": (record,), "license": ""})
    own = steps.fit_settings(campaign, record)
    described_by = {campaign.name: steps.descriptions(campaign)}
    attributes = described(own, described_by)["attributes"]
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
    assert own["block"] == described(own, described_by)["block"]
