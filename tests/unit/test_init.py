"""freerock init: what a laboratory's own folder begins with, and what is left alone."""

from pathlib import Path

import pytest
import yaml

from freerock.cli import subcommands as cli
from freerock.cli.init_command import WRITTEN, init

SCHEMAS = ("config", "campaign")
GENERATED = {"constraints.txt", "config/README.md", *(f"config/{name}.schema.json" for name in SCHEMAS)}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_everything_is_written_and_told(folder, capsys):
    assert cli.main(["init"]) == 0
    there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert there == {*WRITTEN, *GENERATED, "profiles/default/config.yaml", "requirements.txt"}
    out = capsys.readouterr().out
    assert all(name in out for name in there)
    assert "next:    freerock new-campaign NAME --from FOLDER" in out
    profile = yaml.safe_load(Path("profiles/default/config.yaml").read_bytes())
    assert profile["cores"] == "all"


def test_a_checkout_is_refused(folder, capsys):
    Path("src/freerock").mkdir(parents=True)
    assert cli.main(["init"]) == 1
    assert capsys.readouterr().err == ".: is a checkout of freerock itself; run it in your own folder\n"
    assert not Path("Snakefile").exists()


@pytest.mark.slow
def test_the_first_campaign_is_named_in_config_yaml(folder, capsys):
    init(folder)
    records = Path(__file__).parents[2] / "raw/palermo_virtual"
    for name, told in (("first", "         snakemake\n"), ("second", "--config campaigns=second\n")):
        assert cli.main(["new-campaign", name, "--from", str(records)]) == 0
        assert told in capsys.readouterr().out
    assert "campaigns: [first]" in Path("config/config.yaml").read_text().splitlines()
