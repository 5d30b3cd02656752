"""A laboratory's own folder beside an installed freerock: analysed, verified and packed as in a checkout."""

import json
import os
import re
import shutil
import subprocess
import zipfile
from importlib.metadata import version

import pytest
from installed import ROOT, install
from small_campaign import Checkout, copied, once
from test_supplement import share_compiled
from warm import commands

pytestmark = pytest.mark.slow


class Laboratory(Checkout):
    """A folder with the files of `freerock init`, a campaign, and freerock installed elsewhere."""

    def __init__(self, folder, site):
        super().__init__(folder)
        self.site = site

    def snakemake(self, *arguments, **environment):
        return super().snakemake(*arguments, **{"PYTHONPATH": str(self.site)} | environment)

    def freerock(self, *arguments):
        environment = os.environ | {"PYTHONPATH": str(self.site)}
        command = [commands() / "freerock", *map(str, arguments)]
        return subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    return once(tmp_path_factory, "installed", install) / "site"


@pytest.fixture(scope="module")
def analysed(finished, site, tmp_path_factory):
    """The campaign of `finished`, analysed in a laboratory's own folder."""
    laboratory = Laboratory(tmp_path_factory.mktemp("own"), site)
    share_compiled(finished / "src/freerock", site / "freerock")
    done = laboratory.freerock("init")
    assert done.returncode == 0, done.stderr
    shutil.copytree(finished / "raw/small", laboratory / "raw/small")
    shutil.copytree(finished / "config/campaigns", laboratory / "config/campaigns")
    laboratory.edit("config/config.yaml", "campaigns: []", "campaigns: [small]")
    done = laboratory.snakemake()
    assert done.returncode == 0, done.stderr
    return laboratory


def test_the_folder_holds_what_version_control_needs(analysed):
    assert (analysed / "requirements.txt").read_text().startswith("freerock==")
    assert "results/" in (analysed / ".gitignore").read_text().splitlines()
    told = analysed.freerock("init")
    assert told.returncode == 0
    assert "written: nothing" in told.stdout and "kept:    Snakefile" in told.stdout


def test_the_same_bytes_as_in_a_checkout(finished, analysed):
    """But for the state of the code: a copy without git knows none, a wheel names its version."""
    products, own = finished.products(), analysed.products()
    assert own.keys() == products.keys()
    state = f"freerock {version('freerock')} as installed".encode()
    assert state in own["results/small/tables/methods.md"]
    assert [name for name in products if own[name].replace(state, b"unknown") != products[name]] == []


def test_nothing_is_made_again_and_all_is_whole(analysed):
    assert analysed.planned() == {}
    done = analysed.freerock("verify")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 missing, 0 damaged, 0 stale, 0 foreign" in done.stdout


def test_the_code_counts_as_that_of_a_checkout(finished, analysed):
    for entry in sorted((finished / "results/small/ledger").glob("*.json")):
        own = json.loads((analysed / "results/small/ledger" / entry.name).read_text())
        assert own["settings"]["code"] == json.loads(entry.read_text())["settings"]["code"], entry.name


def test_run_makes_what_is_missing_and_ends_with_the_report(analysed):
    report = (analysed / "results/small/report.html").read_bytes()
    (analysed / "results/small/report.html").unlink()
    done = analysed.freerock("run", "small", "--cores", "1")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "results/small/report.html: the report; open it in a browser\n"
    assert re.search(r"^\[#{40}\] 100 %$", done.stderr, re.M) and "profile" not in done.stderr
    assert (analysed / "results/small/report.html").read_bytes() == report


def test_run_says_each_failure_in_one_line(analysed, tmp_path):
    broken = Laboratory(copied(analysed.folder, tmp_path / "copy"), analysed.site)
    record = broken / "raw/small/tall_mat.tdms"
    record.write_bytes(record.read_bytes()[:100])
    done = broken.freerock("run", "small")
    assert done.returncode == 1
    told = [line for line in done.stderr.splitlines() if "tall_mat" in line]
    assert any(line.startswith("small: record tall_mat failed: ") for line in told)
    assert len(told) == len(set(told)) <= 3
    assert done.stderr.splitlines()[-1].startswith("freerock run: snakemake ended with exit code 1; correct")


def test_run_without_a_snakefile_takes_that_of_the_package(analysed, tmp_path):
    bare = Laboratory(copied(analysed.folder, tmp_path / "bare"), analysed.site)
    (bare / "Snakefile").unlink()
    shutil.rmtree(bare / "profiles")
    (bare / "results/small/tables/runs.csv").unlink()
    done = bare.freerock("run", "small")
    assert done.returncode == 0, done.stderr
    assert (bare / "results/small/tables/runs.csv").exists()


def test_its_supplement_holds_the_code(analysed, tmp_path):
    named = Laboratory(copied(analysed.folder, tmp_path / "named"), analysed.site)
    done = named.freerock("supplement", "small")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(named / "small_supplement.zip") as archive:
        archive.extractall(tmp_path)
    unpacked = Checkout(tmp_path / "small_supplement")
    done = unpacked.snakemake("--config", "verify=true", "--dry-run", "--quiet", "all")
    assert "0 missing, 0 damaged, 0 stale, 0 foreign" in done.stdout, done.stdout + done.stderr
    assert not (unpacked / "src/freerock/snakemake").exists()


def test_as_a_module_beside_another_version(analysed, tmp_path):
    """The example: rules with a prefix, a rule of the laboratory, another version in a folder of its own."""
    other = tmp_path / "site"
    shutil.copytree(analysed.site, other)
    (metadata,) = other.glob("freerock-*.dist-info/METADATA")
    text = metadata.read_text(encoding="utf-8")
    metadata.write_text(re.sub(r"^Version: .*", "Version: 0.9.9", text, flags=re.M), encoding="utf-8")
    command = tmp_path / "freerock"
    command.write_text(f'#!/bin/sh\nPYTHONPATH={other} exec {commands()}/freerock "$@"\n')
    command.chmod(0o755)
    own = Laboratory(copied(analysed.folder, tmp_path / "own"), analysed.site)
    shutil.copy2(ROOT / "examples/own_workflow/Snakefile", own.folder)
    done = own.snakemake("--config", "campaigns=small", f"other={command}")
    assert done.returncode == 0, done.stderr
    rows = (own / "stiffness.csv").read_text().splitlines()
    assert rows[0] == "test,run,model,k_n_m2,stderr_n_m2" and rows[1].startswith("tall_mat,1,winkler,")
    versions = [
        json.loads((own / f"{part}results/small/provenance.json").read_text())["software"]["freerock"]
        for part in ("", "other/")
    ]
    assert versions[0] != versions[1] == "0.9.9"
    assert "0.9.9" in (own / "comparison.txt").read_text(encoding="utf-8")
    one, two = (own / f"{part}results/small/tables/runs.csv" for part in ("", "other/"))
    assert one.read_bytes() == two.read_bytes()


def test_a_prefix_of_paths_is_refused_in_one_line(analysed, tmp_path):
    shutil.copytree(analysed.folder, tmp_path / "own", ignore=shutil.ignore_patterns("results", ".snakemake"))
    own = Laboratory(tmp_path / "own", analysed.site)
    own.edit(
        "Snakefile",
        "    config:\n        config\n",
        '    config:\n        config\n    prefix:\n        "lab"\n',
    )
    done = own.snakemake("--dry-run")
    assert done.returncode == 1
    assert "module freerock: prefix: is not possible: products lie in results" in done.stderr
    assert "Traceback" not in done.stderr
