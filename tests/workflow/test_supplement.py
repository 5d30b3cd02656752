"""The supplement of a paper: packed, unpacked elsewhere, and made again to the bit."""

import json
import os
import shutil
import subprocess
import zipfile

import pytest
import yaml
from rocrate.rocrate import ROCrate
from small_campaign import BY, ROOT, Checkout, copied
from warm import commands

from freerock.config.campaign import load_campaign
from freerock.errors import FreerockError
from freerock.files import sha256
from freerock.jobs.supplement import _check_texts

YAML = "config/campaigns/small.yaml"
RECORD, FIT = (f"results/small/{kind}/tall_mat.nc" for kind in ("records", "fits"))
MORE = ("LICENSE", "Makefile", "pyproject.toml", "requirements.lock", "docs/datasets.md")


def supplement(checkout, *arguments):
    command = [commands() / "freerock", "supplement", *arguments]
    environment = os.environ | {"PYTHONPATH": str(checkout / "src")}
    return subprocess.run(command, cwd=checkout.folder, env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def packed(finished, tmp_path_factory):
    """A finished campaign of two named creators, and its supplement."""
    folder = tmp_path_factory.mktemp("packed") / "copy"
    copied(finished.folder, folder)
    checkout = Checkout(folder)
    (folder / "docs").mkdir()
    for file in MORE:
        shutil.copy2(ROOT / file, folder / file)
    (folder / "results/small/figures/stray.pdf").write_text("of no campaign")
    refused = supplement(checkout, "small")
    assert refused.returncode == 1
    assert refused.stderr.splitlines() == [
        "results/small: some products are not as a run would make them; "
        "run snakemake --config campaigns=small, and delete what is foreign"
    ]
    assert "foreign: results/small/figures/stray.pdf" in refused.stdout
    assert not (folder / "small_supplement.zip").exists()
    (folder / "results/small/figures/stray.pdf").unlink()
    ledger = folder / "results/small/ledger"  # what is left of a figure that was drawn and deleted
    entry = json.loads((ledger / "figures.json").read_text())
    entry["outputs"] = {"results/small/figures/backbone.pdf": "0"}
    (ledger / "figure_backbone.json").write_text(json.dumps(entry))
    done = supplement(checkout, "small", "--paper", "https://doi.org/10.1000/xyz", "--year", "2026")
    assert done.returncode == 0, done.stderr
    assert f"sha256 {sha256(folder / 'small_supplement.zip')}" in done.stdout
    return checkout


@pytest.fixture(scope="module")
def unpacked(packed, tmp_path_factory):
    folder = tmp_path_factory.mktemp("elsewhere")
    with zipfile.ZipFile(packed / "small_supplement.zip") as archive:
        assert {each.date_time for each in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert archive.testzip() is None
        archive.extractall(folder)
    return Checkout(folder / "small_supplement")


def share_compiled(one, other):
    """Have the same code compiled in one place count in another; numba goes by the times of files."""
    for path in other.rglob("*.py"):
        source = one / path.relative_to(other)
        if source.exists() and path.read_bytes() == source.read_bytes():
            shutil.copystat(source, path)
    for folder in one.rglob("__pycache__"):
        shutil.copytree(folder, other / folder.relative_to(one), dirs_exist_ok=True)


def test_datasets_of_other_texts_are_refused_until_they_are_made_again(packed, tmp_path, monkeypatch):
    """An edited text alone makes no dataset again."""
    checkout = Checkout(copied(packed.folder, tmp_path / "copy", "*.zip"))
    checkout.edit(YAML, "institution: Laboratory\nlicense: CC-BY-4.0\n", "institution: Another\n")
    assert not {"record", "fit"} & checkout.planned().keys()
    monkeypatch.chdir(checkout.folder)
    campaign = load_campaign(YAML)
    other = "holds another institution and license than the configuration; "
    remedy = "run snakemake --forceall --config campaigns=small"
    with pytest.raises(FreerockError, match=f"^{RECORD}: {other}{remedy}$"):
        _check_texts(campaign)
    done = checkout.snakemake("--forceall", RECORD)
    assert done.returncode == 0, done.stderr
    with pytest.raises(FreerockError, match=f"^{FIT}: {other}{remedy}$"):
        _check_texts(campaign)


def test_everything_in_it_has_a_checksum(unpacked):
    listed = dict(
        reversed(line.split("  ", 1)) for line in (unpacked / "SHA256SUMS").read_text().splitlines()
    )
    assert all(sha256(unpacked / name) == found for name, found in listed.items())
    there = {
        path.relative_to(unpacked.folder).as_posix() for path in unpacked.folder.rglob("*") if path.is_file()
    }
    assert {name for name in there - listed.keys() if "/ledger/" not in name} == {"SHA256SUMS"}
    assert {
        "raw/small/tall_mat.tdms",
        "raw/small/truth.json",
        "results/small/report.html",
        *MORE,
    } <= listed.keys()
    assert not [name for name in there if "__pycache__" in name or "/logs/" in name or "/benchmarks/" in name]


def test_metadata_name_who_what_and_the_paper(unpacked):
    cff = yaml.safe_load((unpacked / "CITATION.cff").read_text(encoding="utf-8"))
    assert cff["authors"][0] == {"family-names": "Rossi", "given-names": "Ada"}
    assert (cff["type"], cff["title"], cff["license"]) == ("dataset", "Two blocks on a mat", "CC-BY-4.0")
    datacite = json.loads((unpacked / "datacite.json").read_text(encoding="utf-8"))
    assert datacite["creators"][1]["familyName"] == "Bianchi"
    assert datacite["publicationYear"] == "2026"
    assert datacite["relatedIdentifiers"] == [
        {"relatedIdentifier": "10.1000/xyz", "relatedIdentifierType": "DOI", "relationType": "IsSupplementTo"}
    ]
    told = (unpacked / "README.md").read_text(encoding="utf-8")
    assert "The records are simulated" in told and "1. `restitution`: " in told


def test_the_crate_is_read_back(unpacked):
    """By the library of the format: files with checksums, the workflow, its run, who, no date of today."""
    crate = ROCrate(unpacked.folder)
    root = crate.root_dataset
    assert root["name"] == "Two blocks on a mat" and root["license"].id.endswith("licenses/CC-BY-4.0")
    assert root.get("datePublished") == "2017-05-02"  # of the records
    assert [each["name"] for each in root["creator"]] == ["Ada Rossi", "Ugo Bianchi"]
    assert {each.id for each in root["conformsTo"]} >= {"https://w3id.org/ro/wfrun/workflow/0.5"}
    workflow = crate.mainEntity
    assert workflow.id == "Snakefile" and "ComputationalWorkflow" in workflow.type
    assert workflow["programmingLanguage"]["name"] == "Snakemake"
    (run,) = root["mentions"]
    assert run.type == "CreateAction" and run["instrument"] == workflow
    used, made = ({each.id for each in run[key]} for key in ("object", "result"))
    assert {"raw/small/tall_mat.tdms", "config/campaigns/small.csv"} <= used
    assert {"results/small/fits/tall_mat.nc", "results/small/tables/runs.csv"} <= made
    files = {each.id: each for each in crate.data_entities}
    assert {path for path in files if not (unpacked / path).is_file()} == set()
    assert used | made <= files.keys()
    for name in (*used, *made):
        assert files[name]["sha256"] == sha256(unpacked / name)


def test_the_same_products_give_the_same_zip(packed):
    done = supplement(
        packed, "small", "--paper", "10.1000/xyz", "--year", "2026", "--output", "again/small_supplement.zip"
    )
    assert done.returncode == 0, done.stderr
    one, other = (packed / f"{folder}small_supplement.zip" for folder in ("", "again/"))
    assert one.read_bytes() == other.read_bytes()


def test_elsewhere_everything_is_whole_and_made_again_to_the_bit(unpacked):
    """From empty, each job in a Python of its own, as `snakemake` starts them: same inputs, same bytes."""
    done = unpacked.snakemake("--config", "verify=true", "--dry-run", "--quiet", "all")
    assert "0 missing, 0 damaged, 0 stale, 0 foreign" in done.stdout, done.stdout + done.stderr
    products = unpacked.products()
    shutil.rmtree(unpacked / "results")
    share_compiled(ROOT / "src", unpacked / "src")
    done = unpacked.snakemake(warm=False)
    assert done.returncode == 0, done.stderr
    again = {path: content for path, content in unpacked.products().items() if "/." not in path}  # locks
    assert again.keys() == products.keys()
    assert [name for name, content in products.items() if again[name] != content] == []


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("results/small/tables/runs.csv", "some products are not as a run would make them"),
        ("raw/small/tall_mat.tdms", "some products are not as a run would make them"),
    ],
)
def test_what_is_damaged_is_not_packed(packed, tmp_path, path, told):
    checkout = Checkout(copied(packed.folder, tmp_path / "copy", "*.zip"))
    (checkout / path).write_bytes((checkout / path).read_bytes()[:-1])
    done = supplement(checkout, "small")
    assert done.returncode == 1
    assert told in done.stderr and len(done.stderr.splitlines()) == 1
    assert not [*checkout.folder.glob("*.zip"), *checkout.folder.glob(".*partial*")]


@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (
            ["small", "--output", "small.tar"],
            1,
            "small.tar: is not the name of a zip file; name it small_supplement.zip",
        ),
        (
            ["small", "--output", "a\nb.zip"],
            1,
            "a b.zip: is not the name of a zip file; name it small_supplement.zip",
        ),
        (
            ["small", "--output", "a\x1bb.zip"],
            1,
            "is not the name of a zip file; name it small_supplement.zip",
        ),
        (["sm\nall"], 1, r"'sm\nall' is not a name; use letters, digits and _ only"),
        (["smal"], 1, "'smal'"),
        (["small", "--year", "26"], 2, "'26' is no year, as 2026"),
        (["small", "--year", "2026\n"], 2, r"'2026\n' is no year, as 2026"),
        (["small", "--paper", "10.1/x\ny"], 2, r"'10.1/x\ny' is no DOI, as 10.1016/j.proeng.2017.09.024"),
        (["small", "--paper", "xyz"], 2, "'xyz' is no DOI, as 10.1016/j.proeng.2017.09.024"),
    ],
)
def test_refused(packed, arguments, code, told):
    done = supplement(packed, *arguments)
    assert done.returncode == code
    assert told in done.stderr.splitlines()[-1]
    assert code == 2 or len(done.stderr.splitlines()) == 1
    assert not [*packed.folder.glob("*a?b*"), *packed.folder.glob(".*partial*")]


def test_a_campaign_of_nobody_is_refused(checkout):
    checkout.edit(YAML, BY, "")
    done = supplement(checkout, "small")
    assert done.returncode == 1
    assert done.stderr == (
        "config/campaigns/small.yaml: names no creator; add creator: Family, Given; Family, Given\n"
    )
