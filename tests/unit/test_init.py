"""freerock init: what a laboratory's own folder begins with, and what is left alone."""

from pathlib import Path

import pytest
from packaging.requirements import Requirement
from ruamel.yaml import YAML

from freerock.cli import subcommands as cli
from freerock.cli.init_command import WRITTEN, init
from freerock.cli.run_command import bar, command, share

SCHEMAS = ("config", "campaign", "scene")
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
    profile = YAML().load(Path("profiles/default/config.yaml"))
    assert profile["cores"] == "all"


def test_what_exists_is_kept_and_what_is_generated_renewed(folder):
    init(folder)
    Path("README.md").write_text("of the laboratory")
    Path("config/README.md").write_text("of another version")
    made = init(folder)
    assert made.written == ("config/README.md",)
    assert "README.md" in made.kept and Path("README.md").read_text() == "of the laboratory"


def test_the_tested_libraries_are_pinned_for_pip(folder):
    init(folder)
    lock = (Path(__file__).parents[2] / "requirements.lock").read_text()
    pinned = [line for line in Path("constraints.txt").read_text().splitlines() if not line.startswith("#")]
    assert len(pinned) == sum(not line.startswith((" ", "#")) for line in lock.splitlines())
    assert all(Requirement(line).specifier and not Requirement(line).extras for line in pinned)
    assert "-c constraints.txt" in Path("requirements.txt").read_text().splitlines()


def test_a_checkout_is_refused(folder, capsys):
    Path("src/freerock").mkdir(parents=True)
    assert cli.main(["init"]) == 1
    assert capsys.readouterr().err == ".: is a checkout of freerock itself; run it in your own folder\n"
    assert not Path("Snakefile").exists()


def test_the_first_campaign_is_named_in_config_yaml(folder, capsys):
    init(folder)
    records = Path(__file__).parents[2] / "raw/palermo_virtual"
    for name, told in (("first", "         snakemake\n"), ("second", "--config campaigns=second\n")):
        assert cli.main(["new-campaign", name, "--from", str(records)]) == 0
        assert told in capsys.readouterr().out
    assert "campaigns: [first]" in Path("config/config.yaml").read_text().splitlines()


def test_command_of_run(folder):
    words = command(["a", "b"], 3, True)
    assert words[-2:] == ["--cores", "3"]
    assert "campaigns=[a,b]" in words and "--snakefile" in words and "--workflow-profile" in words
    assert words[words.index("--profile") + 1].endswith("profiles/slurm")
    init(folder)
    words = command(["a"], None, False)
    assert not {"--snakefile", "--workflow-profile", "--profile", "--cores"} & {*words}


def test_the_bar_is_full_at_the_end_only():
    assert bar(0.0) == f"[{'.' * 40}]   0 %"
    assert bar(0.999).endswith(".]  99 %")
    assert bar(1.0) == f"[{'#' * 40}] 100 %"


def test_share_is_of_the_records_of_all_campaigns(folder):
    made = folder / "results/a/records/one.nc"
    made.parent.mkdir(parents=True)
    assert share({"a": ["one"], "b": ["two"]}, 0.0) == 0.0
    for kind, suffix in (("records/one", "nc"), ("fits/one", "nc"), ("figures/qc_one", "csv")):
        path = folder / f"results/a/{kind}.{suffix}"
        path.parent.mkdir(exist_ok=True)
        if kind != "records/one":
            path.write_text("")
    assert share({"a": ["one"], "b": ["two"]}, 0.0) == pytest.approx(0.375)
