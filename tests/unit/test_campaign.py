"""Campaigns as they are loaded."""

import importlib
import json
from pathlib import Path

import pytest
from laboratory import CSV, problems

from freerock.config.campaign import load_campaign, load_config
from freerock.config.record import Record
from freerock.rotation.sensor import Laser

ROOT = Path(__file__).parents[2]


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    """An empty folder, and the function that writes a campaign there and gives its problems."""
    monkeypatch.chdir(tmp_path)
    return problems


def test_campaigns_named_by_the_caller_replace_those_of_the_file(campaign):
    campaign(csv_change=("near", "far"))
    Path("config/campaigns/lab.csv").write_text(CSV)
    Path("config/config.yaml").write_text("campaigns: [nowhere]\n")
    assert list(load_config("config/config.yaml", campaigns=["lab"])) == ["lab"]
    assert list(load_config("config/config.yaml", campaigns="lab")) == ["lab"]


def test_accepted_campaign(campaign):
    campaign(csv_change=("near", "far"))
    rows = (
        "\n# a remark\n"
        'b,day1/b.tdms,Laser,tall,marble,near,2;3,1@12.310:19.8,"slid, wet",\n'
        "c,c,,tall,marble,near,record,,x,\n"
    )
    Path("config/campaigns/lab.csv").write_text(CSV + rows, encoding="utf-8-sig")
    lab = load_campaign("config/campaigns/lab.yaml")
    assert (lab.name, lab.raw, lab.file("b")) == ("lab", "raw/lab", "raw/lab/day1/b.tdms")
    assert [record.test for record in lab.records] == ["a", "b", "c"]
    assert lab.record("b").exclusions == ((2, "slid, wet"), (3, "slid, wet"))
    assert lab.record("b").overrides == ((1, 12.31, 19.8, "slid, wet", None),)
    assert [record.excluded for record in lab.records] == [False, False, True]
    assert lab.blocks["tall"].label == "tall"
    assert lab.blocks["tall"].block.width_m == 0.07
    assert json.loads(json.dumps(lab.model_dump())) == lab.model_dump(mode="json")


def test_palermo_campaign():
    virtual = importlib.import_module("freerock.virtual_lab.palermo")
    palermo = load_campaign(ROOT / "config/campaigns/palermo_virtual.yaml")
    blocks, foundations = ("config1", "config2", "config3"), ("marble", "aerstop")
    assert {record.test for record in palermo.records} == {f"{b}_{f}" for b in blocks for f in foundations}
    assert all(record.test == f"{record.block}_{record.foundation}" for record in palermo.records)
    for record in palermo.records:
        block, _, laser = virtual.CONFIGURATIONS[record.block]
        assert palermo.blocks[record.block].block == block
        assert Laser(**palermo.lasers[record.laser].model_dump(exclude={"uncertainty"})) == laser
    assert palermo.origin == "simulated"
    assert list(load_config(ROOT / "config/config.yaml")) == ["palermo_virtual"]


@pytest.mark.parametrize("cells", [("exclude", "1"), ("override", "1@2.5:3.5")])
def test_what_is_corrected_needs_a_reason_where_the_csv_has_no_column_for_it(campaign, cells):
    column, cell = cells
    rows = f"test,file,block,foundation,laser,{column}\na,a.tdms,tall,marble,near,{cell}\n"
    (problem,) = campaign(csv_change=(CSV, rows))
    assert "lab.csv:2: reason: " in problem and "without a reason" in problem


def test_two_lasers_and_their_channels():
    record = Record(test="a", file="a.tdms", channel="top; low", block="b", foundation="f", laser="high;near")
    assert (record.lasers, record.channels) == (("high", "near"), ("top", "low"))
    alone = record.model_copy(update={"channel": "", "laser": "near"})
    assert (alone.lasers, alone.channels) == (("near",), ("",))
