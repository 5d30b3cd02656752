"""Exit code 0 means: these products, from these inputs, by these settings; whatever Snakemake has noted."""

import os
import shutil
import subprocess

import pytest
from small_campaign import simulated
from test_bad_day import FIT, RAW, RECORD, Run
from test_reruns import CSV, EVERYTHING, OF_ONE_RECORD, PAGES, REPORT, YAML
from warm import commands

from freerock.products.groups import reasons_in
from freerock.products.netcdf import open_record
from freerock.runs.verdict import in_one_line
from freerock.virtual_lab.write_tdms import write_tdms

OLD = (1e9, 1e9)  # a time long before


def freerock(checkout, *arguments):
    command = [commands() / "freerock", *arguments]
    environment = os.environ | {"PYTHONPATH": str(checkout / "src")}
    return subprocess.run(command, cwd=checkout.folder, env=environment, capture_output=True, text=True)


def flip(path):
    """Another byte in the middle, under the same size and time."""
    before, data = path.stat(), bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


WITHOUT_RECORDS = {job: n for job, n in OF_ONE_RECORD.items() if job not in ("record", "fit", "quality")}
DAMAGE = {
    "deleted": lambda path: path.unlink(),
    "emptied": lambda path: path.write_bytes(b""),
    "cut": lambda path: path.write_bytes(path.read_bytes()[:-1]),
    "byte flipped": flip,
}


@pytest.mark.parametrize(
    ("product", "damage", "jobs"),
    [
        ("figures/restitution.pdf", "deleted", {"figures": 1} | REPORT),
        ("figures/qc_tall_mat.pdf", "emptied", PAGES | {"quality": 1}),
        ("tables/numbers.tex", "cut", {"printed_tables": 1, "complete": 1}),
        ("provenance.json", "byte flipped", REPORT),
        ("complete.txt", "emptied", {"complete": 1}),
        ("records/squat_mat.nc", "byte flipped", OF_ONE_RECORD),
        ("fits/squat_mat.nc", "deleted", {"fit": 1, "quality": 1} | WITHOUT_RECORDS),
    ],
)
def test_any_product_is_missed(checkout, product, damage, jobs):
    DAMAGE[damage](checkout / f"results/small/{product}")
    assert checkout.planned() == jobs


def test_damage_is_undone_by_the_same_command(finished, checkout):
    for number, product in enumerate(["figures/restitution.pdf", "tables/numbers.tex", "provenance.json"]):
        [*DAMAGE.values()][number](checkout / f"results/small/{product}")
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    assert "\nresults/small/figures/restitution.pdf is missing: made again\n" in done.stderr
    assert "\nresults/small/tables/numbers.tex is not as it was written: made again\n" in done.stderr
    assert checkout.products() == finished.products()
    assert checkout.planned() == {}


@pytest.mark.parametrize(
    ("path", "old", "new", "jobs"),
    [
        (YAML, "mass_kg: 2.98", "mass_kg: 2.97", OF_ONE_RECORD),
        (CSV, "squat,mat,low,,,,", "squat,mat,low,record,,wet base,", OF_ONE_RECORD),
        (YAML, "title: Two", "title: Both", REPORT),
    ],
)
def test_without_snakemakes_notes_settings_count_as_with_them(checkout, path, old, new, jobs):
    shutil.rmtree(checkout / ".snakemake")
    assert checkout.planned() == {}
    checkout.edit(path, old, new)
    assert checkout.planned() == jobs


def test_results_of_another_campaign_copied_into_its_folder(checkout):
    for suffix in ("yaml", "csv"):
        shutil.copy(
            checkout / f"config/campaigns/small.{suffix}", checkout / f"config/campaigns/other.{suffix}"
        )
    checkout.edit("config/campaigns/other.yaml", "mass_kg: 2.98", "mass_kg: 2.97")
    for part in ("raw", "results"):
        shutil.copytree(checkout / f"{part}/small", checkout / f"{part}/other")
    assert checkout.planned("--config", "campaigns=[other]") == EVERYTHING


def test_earlier_results_put_back_after_a_change(finished, checkout):
    """Snakemake's notes are of the new settings, the products of the old ones."""
    checkout.edit(YAML, "mass_kg: 2.98", "mass_kg: 2.97")
    assert checkout.snakemake(RECORD).returncode == 0
    shutil.copy2(finished / RECORD, checkout / RECORD)
    entry = "results/small/ledger/record_squat_mat.json"
    assert checkout.planned(RECORD) == {"record": 1}
    shutil.copy2(finished / entry, checkout / entry)
    done = checkout.snakemake("--dry-run", RECORD)
    masses = ("attributes.block_mass_kg", "block.mass_kg", "laboratory.block.mass_kg")
    told = [f"records.squat_mat.{name} 2.98, now 2.97" for name in masses]
    told.append("records.squat_mat.laboratory.inputs.3.u 0.00298, now 0.00297")  # a thousandth by default
    told.append("records.squat_mat.laboratory.inputs.5.u 3.04208333333e-05, now 3.031875e-05")  # of inertia
    assert f"\n{RECORD} was made by other settings ({', '.join(told)}): made again\n" in done.stderr


@pytest.mark.parametrize("name", ["squat_mat.tdms", "./squat_mat.tdms"])
@pytest.mark.parametrize("notes", [True, False], ids=["with Snakemake's notes", "without"])
def test_another_record_under_an_old_time_is_refused(checkout, name, notes):
    checkout.edit(CSV, "squat_mat,squat_mat.tdms", f"squat_mat,{name}")
    if not notes:
        shutil.rmtree(checkout / ".snakemake")
    assert checkout.planned() == {}
    write_tdms(checkout / RAW, simulated("squat", 9))
    os.utime(checkout / RAW, OLD)
    assert checkout.planned() == OF_ONE_RECORD
    assert checkout.snakemake(RECORD).returncode == 0
    told = in_one_line(reasons_in(open_record(checkout / RECORD).attrs))
    assert f"{RAW}: has the sha256" in told and "restore the file" in told


def test_a_record_changed_while_the_run_is_at_work(finished, checkout):
    """Its products are made from the earlier one: the run does not end well."""
    (checkout / FIT).unlink()
    first = Run(checkout, FIT, accident="wait")
    first.wait_for(first.mark.exists)
    os.utime(checkout / RAW, OLD)
    flip(checkout / RAW)
    first.mark.unlink()
    assert first.ended().process.returncode == 1
    assert first.told.endswith(
        f"{RECORD} was made from another {RAW}\n"
        "results: files were changed while snakemake was at work; run the same command again\n"
    )


def test_verify(checkout):
    whole = freerock(checkout, "verify")
    assert whole.returncode == 0, whole.stderr
    number = sum(path.is_file() for path in (checkout / "results/small").rglob("[!.]*"))
    number -= sum(
        len([*(checkout / f"results/small/{part}").iterdir()]) for part in ("logs", "benchmarks", "ledger")
    )
    assert whole.stdout == f"results/small: {number} whole, 0 missing, 0 damaged, 0 stale, 0 foreign\n"
    (checkout / "results/small/tables/table1.md").unlink()
    (checkout / "results/small/tables/mine.csv").touch()
    checkout.edit(YAML, "title: Two", "title: Both")
    changed = freerock(checkout, "verify", "small")
    assert changed.returncode == 1
    other = "was made by other settings (campaign.title Two blocks on a mat, now Both blocks on a mat)"
    assert changed.stdout.splitlines() == [
        "missing: results/small/tables/table1.md",
        "stale: results/small/complete.txt was made from results/small/report.html, "
        "results/small/tables/table1.md",
        f"stale: results/small/figures/captions.tex {other}",
        f"stale: results/small/provenance.json {other}",
        f"stale: results/small/report.html {other}",
        f"stale: results/small/tables/methods.bib {other}",
        f"stale: results/small/tables/methods.md {other}",
        "foreign: results/small/tables/mine.csv",
        f"results/small: {number - 7} whole, 1 missing, 0 damaged, 6 stale, 1 foreign",
    ]
    assert changed.stderr == (
        "results/small: some products are not as a run would make them; "
        "run snakemake --config campaigns=small, and delete what is foreign\n"
    )
    (checkout / YAML).unlink()
    refused = freerock(checkout, "verify", "small")
    assert refused.returncode == 1 and not refused.stdout
    assert "there is no campaign 'small'" in refused.stderr
