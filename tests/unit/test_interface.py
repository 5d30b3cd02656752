"""The public interface: no name of it is gone, and a campaign of version 0.1 is told of each key that is."""

import shutil
from importlib.metadata import version
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from freerock.cli import subcommands as cli
from freerock.config import mistakes

ROOT = Path(__file__).parents[2]
OF_0_1 = """\
title: Free rocking of marble blocks
origin: simulated
truth: truth.json
blocks:
  config2: {height_m: 0.28, width_m: 0.07, mass_kg: 5.84, release_angle_deg: 10}
foundations:
  marble: {label: Marble}
lasers:
  at_200mm: {beam: horizontal, position_m: 0.20, range_m: 0.1}
fits:
  pooled: true
  models: [housner, winkler, hunt_crossley]
figures: [comparison, restitution]
"""
CSV_0_1 = """\
test,file,channel,block,foundation,laser,exclude,override,reason,note
config2_marble,config2_marble.tdms,,config2,marble,at_200mm,,,,
"""


@pytest.fixture
def campaign_of_0_1(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    raw = tmp_path / "raw/old"
    raw.mkdir(parents=True)
    for name in ("config2_marble.tdms", "truth.json"):
        shutil.copy2(ROOT / "raw/palermo_virtual" / name, raw)
    folder = tmp_path / "config/campaigns"
    folder.mkdir(parents=True)
    (tmp_path / "config/config.yaml").write_text("campaigns: [old]\n")
    (folder / "old.csv").write_text(CSV_0_1)
    (folder / "old.yaml").write_text(OF_0_1)
    return folder / "old.yaml"


def test_check_names_each_key_of_0_1_that_is_gone(campaign_of_0_1, capsys):
    assert cli.main(["check", "old"]) == 1
    told = capsys.readouterr()
    lines = (told.out + told.err).splitlines()
    line = OF_0_1.splitlines().index("  pooled: true") + 1
    expected = f"config/campaigns/old.yaml:{line}: fits.pooled: runs are no longer fitted jointly; remove it"
    assert [each for each in lines if each.startswith(expected)], lines
    campaign_of_0_1.write_text(OF_0_1.replace("  pooled: true\n", ""))
    assert cli.main(["check", "old"]) == 0


def test_a_renamed_key_is_told_with_its_new_name(campaign_of_0_1, capsys, monkeypatch):
    monkeypatch.setitem(mistakes.FORMER, "release_deg", ("is release_angle_deg", "use release_angle_deg"))
    text = OF_0_1.replace("  pooled: true\n", "").replace("release_angle_deg", "release_deg")
    campaign_of_0_1.write_text(text)
    assert cli.main(["check", "old"]) == 1
    told = capsys.readouterr()
    assert "blocks.config2.release_deg: is release_angle_deg; use release_angle_deg" in told.out + told.err


def test_metadata_agree():
    cited = YAML(typ="safe").load(ROOT / "CITATION.cff")
    conda = (ROOT / "conda/meta.yaml").read_text(encoding="utf-8")
    built = f'{{% set version = "{version("freerock")}" %}}'
    assert cited["version"] == version("freerock") and built in conda


def test_the_recipe_requires_what_the_package_does():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = (ROOT / "conda/meta.yaml").read_text(encoding="utf-8")
    recipe = recipe.partition("  run:\n")[2].partition("\ntest")[0]
    conda = {line.split()[1] for line in recipe.splitlines() if line.strip()}
    names = {"matplotlib": "matplotlib-base", "snakemake": "snakemake-minimal"}
    required = {each.split(">")[0].split("[")[0].lower() for each in project["dependencies"]}
    assert conda == {names.get(each, each) for each in required} | {"python"}
