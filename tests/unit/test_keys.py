"""Sections of the configuration: the settings of the steps."""

import math
import re
from pathlib import Path
from typing import get_args

import pytest

from freerock.config.blocks import BlockSection
from freerock.config.campaign import ConfigFile
from freerock.config.campaign_file import CampaignFile
from freerock.config.fit_settings import FitsSection, FreeSection
from freerock.config.record import Record
from freerock.config.values import Model, Unit, section_in
from freerock.models.block import Block
from freerock.models.free_parameters import PER_RUN
from freerock.models.laws import KINEMATICS, LAWS
from freerock.units import CHANNEL_UNITS

ROOT = Path(__file__).parents[2]


def test_a_block_can_not_be_released_at_its_critical_angle():
    shape = {"height_m": 0.28, "width_m": 0.07, "mass_kg": 5.84}
    critical_deg = math.degrees(Block(**shape).theta_cr)
    with pytest.raises(ValueError, match="the block overturns"):
        BlockSection(**shape, release_angle_deg=critical_deg)
    assert BlockSection(**shape, release_angle_deg=critical_deg - 1e-9)


def test_freed_nuisances_are_named_for_every_model():
    assert list(FreeSection.model_fields) == list(LAWS)
    assert list(FitsSection().models) == list(LAWS)
    for model in LAWS:
        with pytest.raises(ValueError, match=f"or '{LAWS[model].may_free[-1]}'"):
            FreeSection.model_validate({model: ["size"]})
    assert get_args(Model) == tuple(LAWS)
    assert get_args(Unit) == ("", *CHANNEL_UNITS)


def test_what_is_given_of_parameters_is_what_the_configuration_says_and_no_more():
    """A default that changes in a later version makes no fit again that does not state it."""
    stated = {"winkler": {"k": {"max": 6e6}, "c": {"value": 2e4, "vary": False}}}
    assert FitsSection(parameters=stated).given == stated
    assert FitsSection().given == {}


def test_paper_mode_frees_the_parameters_of_the_models_only():
    assert FitsSection().freed == dict.fromkeys(LAWS, PER_RUN)  # the same freedom for all
    free = {"housner": ["theta0"]}
    assert FitsSection(paper_mode=True, free=free).freed == dict.fromkeys(LAWS, ())
    freed = FitsSection(free=free).freed
    assert (freed["housner"], freed["winkler"]) == (("theta0",), ("theta0", "t0"))


def test_rivals_take_both_kinematics_unless_told_otherwise_and_there_are_none_in_paper_mode():
    assert FitsSection().rivals == FitsSection().kinematics == KINEMATICS
    assert FitsSection(kinematics=["pivoting"]).rivals == ("pivoting",)
    assert FitsSection(paper_mode=True).rivals == ()


def test_every_key_is_used():
    """Beyond the model that declares it: as an attribute, as an item, or as an argument of its step."""
    package = ROOT / "src/freerock"
    declaring = {*package.glob("config/*.py"), package / "cli/new_campaign_command.py"}
    others = {*package.rglob("*.py"), *(ROOT / "workflow").rglob("*.smk")} - declaring
    used = {
        word
        for path in package.glob("config/*.py")
        for word in re.findall(r"\.(\w+)", path.read_text("utf-8"))
    }
    for path in others:
        found = re.findall(r"\.(\w+)|[\"'](\w+)[\"']|^ +(\w+): (?=[^=\n]+)", path.read_text("utf-8"), re.M)
        used.update(*found)

    def keys(model):
        for name, field in model.model_fields.items():
            yield name
            child = section_in(field.annotation)
            yield from keys(child) if child else ()

    declared = {*keys(ConfigFile), *keys(CampaignFile), *keys(Record)}
    assert declared - used == set()
