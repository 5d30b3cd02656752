"""Fixtures of the tests of single modules."""

from pathlib import Path

import pytest
from laboratory import CSV, YAML

from freerock.config.campaign import load_campaign
from freerock.config.mistakes import ConfigError


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    """Write a campaign in an empty folder, with parts of its files replaced; give the problems."""
    monkeypatch.chdir(tmp_path)
    Path("config/campaigns").mkdir(parents=True)

    def problems(yaml_change=("", ""), csv_change=("", "")):
        yaml_text, csv_text = YAML.replace(*yaml_change), CSV.replace(*csv_change)
        assert (yaml_text, csv_text) != (YAML, CSV)
        Path("config/campaigns/lab.yaml").write_text(yaml_text, encoding="utf-8")
        Path("config/campaigns/lab.csv").write_text(csv_text, encoding="utf-8")
        with pytest.raises(ConfigError) as caught:
            load_campaign("config/campaigns/lab.yaml")
        return str(caught.value).replace("config/campaigns/", "").splitlines()

    return problems
