"""What fails in one record, foreseen or not, stops no other; tables say what is missing and why."""

import csv
import json
import re

from small_campaign import CAMPAIGN, add_campaign, check_out, simulated

from freerock.files import sha256
from freerock.products.netcdf import open_record
from freerock.virtual_lab.write_tdms import write_tdms

STEPS = {  # module and function of each
    "record": ("make_record", "make_record"),
    "fit": ("make_fits", "make_fits"),
    "quality": ("make_quality", "make_quality"),
}
INJECTED = """

_{function} = {function}


def {function}(*arguments, **options):
    if "{test}" in str(arguments) and "unforeseen" not in str(arguments):
        raise ZeroDivisionError("injected")
    return _{function}(*arguments, **options)
"""
OUT = "left_out.tdms,,squat,mat,low,record,,the base was wet,"
MISSING = "raw/lab/missing.tdms: no such file; put it there, or correct its name"
TOLD = "unforeseen: ZeroDivisionError: injected; the log of the step has the traceback"


def test_a_missing_file_and_the_unforeseen_in_each_step(tmp_path):
    checkout = check_out(tmp_path / "checkout")
    tests = ["good", "bad_record", "bad_fit", "bad_quality"]
    files = [f"raw/lab/{test}.tdms" for test in (*tests, "left_out")]
    add_campaign(checkout, "lab", CAMPAIGN, [(test, "", "squat") for test in (*tests, "missing", "left_out")])
    checkout.edit("config/campaigns/lab.csv", "left_out.tdms,,squat,mat,low,,,,", OUT)
    (checkout / "raw/lab").mkdir(parents=True)
    for seed, file in enumerate(files):
        write_tdms(checkout / file, simulated("squat", seed))
    for step, (name, function) in STEPS.items():
        with open(checkout / f"src/freerock/jobs/{name}.py", "a") as module:
            module.write(
                INJECTED.format(
                    function=function, test=f"bad_{step}.tdms" if step == "record" else f"bad_{step}.nc"
                )
            )

    done = checkout.snakemake()
    assert done.returncode == 1
    assert f"\nlab: record bad_record failed: {TOLD}\n" in done.stderr
    assert f"\nlab: record bad_fit failed: not fitted: {TOLD}\n" in done.stderr
    assert f"\nlab: record missing failed: {MISSING}\n" in done.stderr
    assert "record good failed" not in done.stderr and "Traceback" not in done.stderr
    assert not checkout.partial_files()
    assert "\nresults/lab/report.html: the report, with the reasons\n" in done.stderr
    assert "record bad_quality failed" not in done.stderr
    (log,) = re.findall(r"^freerock: the log of this run is (\S+)$", done.stderr, re.M)
    assert (checkout.folder / log).is_file()
    with open(checkout / "results/lab/tables/runs.csv", newline="", encoding="utf-8") as table:
        rows = {row["test"]: (row["run"], row["verdict"], row["reasons"]) for row in csv.DictReader(table)}
    assert "inject" not in rows["bad_quality"][2]
    rows["bad_quality"] = *rows["bad_quality"][:2], ""  # a pull may be noted
    assert rows == {
        "good": ("1", "ok", ""),
        "bad_record": ("", "fail", TOLD),
        "bad_fit": ("1", "fail", f"not fitted: {TOLD}"),
        "bad_quality": ("1", "ok", ""),
        "missing": ("", "fail", MISSING),
        "left_out": ("", "ok", "excluded: the base was wet"),
    }
    with open(checkout / "results/lab/tables/parameters.csv", newline="", encoding="utf-8") as table:
        assert {row["test"] for row in csv.DictReader(table)} == {"good", "bad_quality"}
    assert not open_record(checkout / "results/lab/records/bad_record.nc").children
    page = (checkout / "results/lab/report.html").read_text(encoding="utf-8")
    assert page.count("ZeroDivisionError: injected") >= 2
    for step in STEPS:
        assert "Traceback" in (checkout / f"results/lab/logs/{step}_bad_{step}.log").read_text()
        assert "Traceback" not in (checkout / f"results/lab/logs/{step}_good.log").read_text()
    assert (checkout / "results/lab/figures/qc_bad_quality.pdf").stat().st_size > 0
    assert {path.name for path in (checkout / "results/lab").iterdir()} == {
        *("figures", "fits", "logs", "records", "tables"),
        *("provenance.json", "report.html"),
    }
    made_by = json.loads((checkout / "results/lab/provenance.json").read_text(encoding="utf-8"))
    read = [file for file in files if "bad_record" not in file]
    assert made_by["inputs"] == {file: sha256(checkout / file) for file in read}
    assert checkout.planned() == {"complete": 1}

    write_tdms(checkout / "raw/lab/missing.tdms", simulated("squat", 5))
    assert checkout.planned()["record"] == 1
