"""What reruns after a change, by Snakemake's own triggers: the steps that depend on it."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
from small_campaign import Checkout, copied, simulated

from freerock.cli import subcommands as cli
from freerock.virtual_lab.write_tdms import write_tdms

REPORT = {"report": 1, "complete": 1}
PAGES = REPORT | {"quality": 2}
PRINTED = REPORT | {"printed_tables": 1}
AFTER_TABLES = PRINTED | {"figure": 5}
AFTER_FITS = PAGES | AFTER_TABLES | {"tables": 1, "figure": 6}
EVERYTHING = AFTER_FITS | {"record": 2, "fit": 2, "figure": 7}
OF_ONE_RECORD = EVERYTHING | {"record": 1, "fit": 1, "quality": 1, "figure": 8}

YAML = "config/campaigns/small.yaml"
CSV = "config/campaigns/small.csv"


def append(checkout, path, text):
    with open(checkout / path, "a", encoding="utf-8") as file:
        file.write(text)


def test_nothing_changed_nothing_reruns(checkout):
    assert checkout.planned() == {}


def test_time_stamps_alone_rerun_nothing(checkout):
    for path in [*(checkout / "src").rglob("*.py"), checkout / YAML, *(checkout / "raw").rglob("*.*")]:
        os.utime(path)
    assert checkout.planned() == {}


def test_a_record_added(checkout):
    write_tdms(checkout / "raw/small/second.tdms", simulated("squat", 7))
    append(checkout, CSV, "second,second.tdms,,squat,mat,low,,,,\n")
    assert checkout.planned() == OF_ONE_RECORD


def test_a_record_replaced(checkout):
    write_tdms(checkout / "raw/small/squat_mat.tdms", simulated("squat", 7))
    assert checkout.planned() == OF_ONE_RECORD | {"figure": 7}


def test_a_picture_deleted_is_drawn_again_alone(checkout):
    picture = checkout / "results/small/figures/restitution.png"
    before = picture.read_bytes()
    picture.unlink()
    assert checkout.planned() == REPORT | {"figure": 1}
    assert checkout.snakemake().returncode == 0
    assert picture.read_bytes() == before


@pytest.mark.parametrize(
    ("path", "old", "new", "jobs"),
    [
        (YAML, "mass_kg: 2.98", "mass_kg: 2.97", OF_ONE_RECORD),
        (YAML, "position_m: 0.2,", "position_m: 0.21,", OF_ONE_RECORD),
        (YAML, "title: Two", "title: Both", REPORT),
        (YAML, "title: Two", "# a comment\ntitle: Two", {}),
        (YAML, "title: Two", "fits: {debonding: tensionless}\ntitle: Two", AFTER_FITS | {"fit": 2}),
        (YAML, "title: Two", "processing: {rotation: {mains_hz: 60}}\ntitle: Two", EVERYTHING),
        (CSV, "tall,mat,high,,,,", "tall,mat,high,,,,cold day", REPORT),
        (CSV, "squat,mat,low,,,,", "squat,mat,low,record,,wet base,", OF_ONE_RECORD | {"figure": 7}),
    ],
)
def test_a_line_of_the_configuration_edited(checkout, path, old, new, jobs):
    checkout.edit(path, old, new)
    assert checkout.planned() == jobs


@pytest.mark.parametrize(
    ("path", "text", "jobs"),
    [
        ("src/freerock/identification/fit.py", "# a comment\n", {}),
        ("src/freerock/identification/fit.py", "EDITED = 1\n", AFTER_FITS | {"fit": 2}),
        ("src/freerock/records/tdms.py", "EDITED = 1\n", EVERYTHING),
        ("src/freerock/figures/restitution.py", "EDITED = 1\n", REPORT | {"figure": 1}),
        ("src/freerock/figures/freerock.mplstyle", "# edited\n", PAGES | {"figure": 8}),
        ("src/freerock/tables/tidy_tables.py", "EDITED = 1\n", AFTER_TABLES | {"tables": 1}),
        ("src/freerock/report/report.html.j2", "edited\n", PRINTED),
        ("src/freerock/config/campaign.py", "EDITED = 1\n", {}),
        ("workflow/scripts/complete.py", "EDITED = 1\n", {"complete": 1}),
    ],
)
def test_code_edited(checkout, path, text, jobs):
    append(checkout, path, text)
    assert checkout.planned() == jobs


def test_a_moved_tree_reruns_nothing(checkout, tmp_path):
    checkout.folder.rename(tmp_path / "moved")
    assert Checkout(tmp_path / "moved").planned() == {}


def test_a_tree_copied_with_its_times_reruns_nothing(checkout, tmp_path):
    """Also where data have new times: Snakemake knows their checksums. A newer script reruns its step."""
    copy = Checkout(tmp_path / "copied")
    shutil.copytree(checkout.folder, copy.folder)
    for path in sorted([*(copy / "raw").rglob("*.*"), *(copy / "results").rglob("*.*")]):
        os.utime(path)
    assert copy.planned() == {}
    os.utime(copy / "workflow/scripts/complete.py")
    assert copy.planned() == {"complete": 1}


def test_results_in_a_fresh_clone_are_taken_for_whole_once_touched(finished, tmp_path):
    clone = Checkout(copied(finished.folder, tmp_path / "clone", ".snakemake"))
    for path in (clone / "workflow").rglob("*.py"):
        os.utime(path)
    assert clone.planned()["record"] == 2
    assert clone.snakemake("--touch").returncode == 0
    assert clone.planned() == {}


def test_a_run_that_is_killed_goes_on_to_the_same_bytes(finished, tmp_path):
    """By SIGKILL to Snakemake and its jobs, twice; the lock that it leaves is Snakemake's own."""
    checkout = Checkout(copied(finished.folder, tmp_path / "killed", "results", ".snakemake"))
    environment = os.environ | {"PYTHONPATH": str(checkout / "src")}
    for log in ("record_tall_mat", "fit_squat_mat"):
        run = [sys.executable, "-m", "snakemake", "--cores", "2"]
        started = subprocess.Popen(
            run, cwd=checkout.folder, env=environment, stderr=subprocess.PIPE, start_new_session=True
        )
        while started.poll() is None and not (checkout / f"results/small/logs/{log}.log").exists():
            time.sleep(0.05)
        os.killpg(started.pid, signal.SIGKILL)
        started.communicate()
        assert checkout.snakemake("--unlock").returncode == 0
    half_written = checkout / "results/small/figures/.0123456789abcdef.partial.pdf"
    half_written.write_bytes(b"%PDF-1.4")
    assert checkout.planned()
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    assert checkout.products() == finished.products()


def test_verify_names_what_differs(checkout, monkeypatch, capsys):
    monkeypatch.chdir(checkout.folder)
    assert cli.main(["verify"]) == 0
    assert capsys.readouterr().out.endswith(" files as listed\n")
    append(checkout, "results/small/tables/runs.csv", "edited\n")
    append(checkout, "raw/small/squat_mat.tdms", "edited")
    (checkout / "results/small/fits/tall_mat.nc").unlink()
    assert cli.main(["verify"]) == 1
    printed = capsys.readouterr()
    assert printed.err.startswith("results/small: ") and " 3 of " in printed.err
    assert set(re.findall(r"^(\w+: \S+)$", printed.out, re.M)) == {
        "changed: results/small/tables/runs.csv",
        "changed: raw/small/squat_mat.tdms",
        "missing: results/small/fits/tall_mat.nc",
    }
