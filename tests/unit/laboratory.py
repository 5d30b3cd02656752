"""A campaign of one record in two texts, and the problems found in it after a change of these."""

from pathlib import Path

import pytest

from freerock.config.campaign import load_campaign
from freerock.config.mistakes import ConfigError
from freerock.models.laws import LAWS

YAML = """\
title: Blocks
origin: measured
blocks:
  tall:
    height_m: 0.28
    width_m: 0.07
    mass_kg: 5.84
foundations:
  marble: {}
lasers:
  near: {beam: horizontal, position_m: 0.1, range_m: 0.05}
"""
QUOTED_LAWS = " or ".join(", ".join(map(repr, LAWS)).rsplit(", ", 1))
HEADER = "test,file,channel,block,foundation,laser,exclude,override,reason,note\n"
CSV = HEADER + "a,a.tdms,,tall,marble,near,,,,\n"


def problems(yaml_change=("", ""), csv_change=("", "")):
    """Write the campaign into the current folder, with parts of its files replaced; give its problems."""
    yaml_text, csv_text = YAML.replace(*yaml_change), CSV.replace(*csv_change)
    assert (yaml_text, csv_text) != (YAML, CSV)
    Path("config/campaigns").mkdir(parents=True, exist_ok=True)
    Path("config/campaigns/lab.yaml").write_text(yaml_text, encoding="utf-8")
    Path("config/campaigns/lab.csv").write_text(csv_text, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_campaign("config/campaigns/lab.yaml")
    return str(caught.value).replace("config/campaigns/", "").splitlines()
