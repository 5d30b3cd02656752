"""What reruns after a change: exactly the steps that depend on it."""

import os

import pytest
from small_campaign import simulated

from freerock.virtual_lab.write_tdms import write_tdms

FIGURES = {"figures": 1}
REPORT = {"report": 1, "complete": 1}
PAGES = REPORT | {"quality": 2}
AFTER_TABLES = {"printed_tables": 1, "recovered": 1} | FIGURES
AFTER_FITS = PAGES | AFTER_TABLES | {"tables": 1}
EVERYTHING = AFTER_FITS | {"record": 2, "fit": 2}
AFTER_STYLE = PAGES | FIGURES
AFTER_LABELS = AFTER_STYLE | {"printed_tables": 1}
OF_ONE_RECORD = EVERYTHING | {"record": 1, "fit": 1, "quality": 1}

YAML = "config/campaigns/small.yaml"
CSV = "config/campaigns/small.csv"


def append(checkout, path, text):
    with open(checkout / path, "a", encoding="utf-8") as file:
        file.write(text)


def test_nothing_touched_nothing_reruns(checkout):
    done = checkout.snakemake()
    assert done.returncode == 0
    assert "Nothing to be done" in done.stdout + done.stderr


def test_time_stamps_alone_rerun_nothing(checkout):
    for path in [*(checkout / "src").rglob("*.py"), *(checkout / "workflow").rglob("*.*"), checkout / YAML]:
        os.utime(path)
    for path in (checkout / "raw").rglob("*.tdms"):
        os.utime(path)
    assert checkout.planned() == {}


@pytest.mark.parametrize(
    ("added", "jobs"),
    [
        ("processing: {rotation: {mains_hz: 60}}\n", EVERYTHING),
        ("processing: {impacts: {min_samples: 13}}\n", EVERYTHING),
        ("fits: {debonding: tensionless}\n", {"fit": 2} | AFTER_FITS),
        ("summary: Two releases.\n", REPORT),
    ],
)
def test_added_key(checkout, added, jobs):
    append(checkout, YAML, added)
    assert checkout.planned() == jobs


@pytest.mark.parametrize(
    ("path", "old", "new", "jobs"),
    [
        (YAML, "mass_kg: 2.98", "mass_kg: 2.97", OF_ONE_RECORD),
        (YAML, "label: Mat", "label: Rubber mat", AFTER_LABELS),
        (YAML, "position_m: 0.2,", "position_m: 0.21,", OF_ONE_RECORD),
        (CSV, "tall,mat,high,,,,", "tall,mat,high,,,,cold day", REPORT),
        (YAML, "title: Two", "title: Both", REPORT),
        (CSV, "squat,mat,low,,,,", "squat,mat,low,record,,wet base,", OF_ONE_RECORD),
    ],
)
def test_edited_line(checkout, path, old, new, jobs):
    checkout.edit(path, old, new)
    assert checkout.planned() == jobs


@pytest.mark.parametrize(
    ("path", "jobs"),
    [
        ("src/freerock/virtual_lab/virtual_record.py", {}),
        ("src/freerock/config/campaign.py", {}),
        ("src/freerock/figures/quality.py", PAGES),
        ("src/freerock/figures/freerock.mplstyle", AFTER_STYLE),
        ("src/freerock/report/report.html.j2", REPORT),
        ("src/freerock/tables/csvfile.py", AFTER_STYLE | AFTER_TABLES | {"tables": 1}),
        ("src/freerock/tables/tidy_tables.py", {"tables": 1} | AFTER_TABLES | REPORT),
        ("src/freerock/tables/printed_tables.py", AFTER_TABLES | REPORT),
        ("src/freerock/tables/latex.py", {"printed_tables": 1, "recovered": 1} | REPORT),
        ("src/freerock/identification/fit.py", {"fit": 2} | AFTER_FITS),
        ("src/freerock/models/kernel.py", {"fit": 2} | AFTER_FITS),
        ("src/freerock/records/tdms.py", EVERYTHING),
        ("src/freerock/rotation/sensor.py", EVERYTHING),
        ("src/freerock/figures/restitution.py", FIGURES | REPORT),
        ("src/freerock/figures/backbone.py", {}),
        ("workflow/scripts/figure.py", FIGURES | REPORT),
        ("workflow/scripts/complete.py", {"complete": 1}),
    ],
)
def test_edited_code(checkout, path, jobs):
    append(checkout, path, "\nEDITED = 1\n" if path.endswith(".py") else "\n# edited\n")
    assert checkout.planned() == jobs


def test_new_record(checkout):
    write_tdms(checkout / "raw/small/second.tdms", simulated("squat", 7))
    append(checkout, CSV, "second,second.tdms,,squat,mat,low,,,,\n")
    assert checkout.planned() == OF_ONE_RECORD


@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_line_inserted_anywhere_with_a_comment(checkout, place):
    write_tdms(checkout / "raw/small/another.tdms", simulated("squat", 7))
    header, *lines = (checkout / CSV).read_text(encoding="utf-8").splitlines(keepends=True)
    lines[place:place] = ["# of another day\n", "\n", "another,another.tdms,,squat,mat,low,,,,\n"]
    (checkout / CSV).write_text(header + "".join(lines), encoding="utf-8")
    assert checkout.planned() == OF_ONE_RECORD


def test_what_only_looks_different_in_the_csv(checkout):
    header, *lines = (checkout / CSV).read_text(encoding="utf-8").splitlines()
    text = "\r\n".join([header, "# nothing new", *(line.replace(",", " , ") for line in lines)])
    (checkout / CSV).write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert checkout.planned() == {}


def test_records_that_share_a_job_rerun_together(checkout):
    checkout.edit(YAML, "records_per_job: 1", "records_per_job: 2")
    assert checkout.snakemake("record").returncode == 0
    assert checkout.planned("record") == {}
    checkout.edit(YAML, "mass_kg: 2.98", "mass_kg: 2.97")
    assert checkout.planned("record") == {"record": 1}
    checkout.edit(YAML, "mass_kg: 2.97", "mass_kg: 2.98")
    checkout.edit(YAML, "records_per_job: 2", "records_per_job: 3")
    write_tdms(checkout / "raw/small/third.tdms", simulated("squat", 7))
    append(checkout, CSV, "third,third.tdms,,squat,mat,low,,,,\n")
    assert checkout.planned("record") == {"record": 1}


def test_record_replaced_or_taken_away(checkout):
    raw = checkout / "raw/small/squat_mat.tdms"
    write_tdms(raw, simulated("squat", 7))
    assert checkout.planned() == OF_ONE_RECORD
    raw.unlink()
    assert checkout.planned() == OF_ONE_RECORD
