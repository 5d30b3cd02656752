"""How an analysis of foreign records is graded, on tables made by hand."""

import subprocess
from pathlib import Path

import pandas as pd
import pytest
from warm import commands

from freerock_bench import foreign

ROOT = Path(__file__).parents[2]
RUNS = "test,run,release_s,verdict"
CHOICE = "test,run,model,status,explains"
PARAMETERS = "test,run,model,parameter,value,stderr"
RESTITUTION = "test,run,source,time_s,r,r_stderr"
PREDICTIONS = "test,run,model,basis,epsilon_theta"
HEADS = dict(zip(foreign.TABLES, (RUNS, CHOICE, PARAMETERS, RESTITUTION, PREDICTIONS), strict=True))
CLEAN = {
    "runs": ["mat,1,3.905,ok"],
    "choice": ["mat,1,winkler,selected,True", "mat,1,housner,rejected,False"],
    "parameters": [
        "mat,1,winkler,k,1010000,10000",
        "mat,1,winkler,theta0,0.1,0.001",
        "mat,1,housner,r,0.9,0.001",
    ],
    "restitution": [
        "mat,1,experiment,0.1,0.901,0.001",
        "mat,1,experiment,0.3,0.893,0.001",
        "mat,1,experiment,0.9,0.5,0.001",
        "mat,1,winkler,0.1,0.7,0",
    ],
    "predictions": ["mat,1,winkler,this run,0.5", "mat,1,winkler,other runs,0.002"],
}
TRUTH = {
    "about": "a mat",
    "right_names": ["unexplained"],
    "right_choices": ["winkler"],
    "parameters": {"k": 1e6, "lambda": 5e7},
    "runs": [
        {"let_go_s": 3.9, "free_s": 3.912, "impacts_s": [4.0, 4.2, 4.4], "restitution": [0.9, 0.89, 0.88]}
    ],
}


def graded(tmp_path, changed=None, told=(), **truth):
    """The one run of the record, with some tables in place of those of a right analysis."""
    (tmp_path / "tables").mkdir()
    for name, rows in (CLEAN | (changed or {})).items():
        (tmp_path / "tables" / f"{name}.csv").write_text("\n".join([HEADS[name], *rows]) + "\n")
    frame = foreign.grade(foreign.tables_of(tmp_path), {"mat": {"1": told}}, {"mat": TRUTH | truth})
    assert len(frame) == 1 and frame.columns.tolist() == foreign.COLUMNS
    return frame.iloc[0]


def test_a_right_run(tmp_path):
    row = graded(tmp_path)
    assert (row.verdict, row.model, row.explained, row.choice, row.wrong) == (
        "ok",
        "winkler",
        True,
        "right",
        "",
    )
    assert not row.named  # nothing was said, and nothing had to be
    assert (row.k_error_percent, row.k_error_stderrs) == pytest.approx((1.0, 1.0))
    assert pd.isna(row.lambda_error_percent)  # the law has none
    assert row.prediction_epsilon == 0.002


def test_restitutions_are_held_against_those_of_the_same_impacts(tmp_path):
    """On the record's clock they are at 4.005, 4.205 and 4.805 s: the last is none of the true ones."""
    row = graded(tmp_path)
    assert (row.n_r, row.n_r_inside, row.r_wrong) == (2, 1, 0)  # 1 and 3 standard errors off
    assert row.r_error == pytest.approx(0.002)


@pytest.mark.parametrize(
    ("r", "stderr", "wrong"), [(0.911, 0.001, "r"), (0.909, 0.001, ""), (0.92, 0.01, ""), (0.92, 0.006, "r")]
)
def test_a_restitution_is_wrong_beyond_three_errors_and_a_hundredth(tmp_path, r, stderr, wrong):
    assert graded(tmp_path, {"restitution": [f"mat,1,experiment,0.1,{r},{stderr}"]}).wrong == wrong


@pytest.mark.parametrize(("k", "wrong"), [(1_029_000, ""), (1_031_000, "k"), (969_000, "k")])
def test_an_ok_over_a_number_beyond_three_errors_is_wrong(tmp_path, k, wrong):
    rows = [f"mat,1,winkler,k,{k},10000"]
    assert graded(tmp_path, {"parameters": rows}).wrong == wrong


def test_a_warned_run_is_not_wrong_and_rightly_named_by_a_right_name_only(tmp_path):
    rows = {"runs": ["mat,1,3.905,warn"], "parameters": ["mat,1,winkler,k,2e6,10000"]}
    row = graded(tmp_path, rows, told=("drift", "unexplained"))
    assert (row.verdict, row.names, row.named, row.wrong) == ("warn", "drift unexplained", True, "")
    assert row.k_error_stderrs == pytest.approx(100)  # told all the same


def test_another_name_is_no_right_one(tmp_path):
    assert not graded(tmp_path, {"runs": ["mat,1,3.905,warn"]}, told=("drift",)).named


def test_an_ok_run_is_not_named_by_a_note(tmp_path):
    assert not graded(tmp_path, told=("off_level",), right_names=["off_level"]).named


def test_a_law_that_is_not_the_truths(tmp_path):
    row = graded(tmp_path, right_choices=["hunt_crossley"])
    assert (row.choice, row.wrong) == ("wrong", "explained")


def test_a_law_that_is_chosen_but_does_not_explain_is_not_wrong(tmp_path):
    row = graded(tmp_path, {"choice": ["mat,1,winkler,selected,False"]}, right_choices=[])
    assert (row.model, row.explained, row.choice, row.wrong) == ("winkler", False, "none explains", "")


def test_no_candidate(tmp_path):
    row = graded(tmp_path, {"choice": ["mat,1,winkler,rejected,False"], "runs": ["mat,1,3.905,fail"]})
    assert (row.model, row.explained, row.choice) == ("", False, "none explains")
    assert pd.isna(row.k_error_percent)


@pytest.mark.parametrize(("release_s", "off_ms"), [(3.905, 0), (3.89, -10), (3.932, 20)])
def test_a_release_is_late_only_beyond_the_time_in_which_the_hand_leaves(tmp_path, release_s, off_ms):
    assert graded(tmp_path, {"runs": [f"mat,1,{release_s},ok"]}).release_error_ms == pytest.approx(off_ms)


def test_a_run_elsewhere_is_not_the_one(tmp_path):
    row = graded(tmp_path, {"runs": ["mat,1,5.5,ok", "other,1,3.905,ok"]})
    assert (row.verdict, row.named, row.choice, row.wrong) == ("missed", False, "none explains", "")


def test_sentence_and_table(tmp_path):
    frame = graded(tmp_path, {"parameters": ["mat,1,winkler,k,1.5e6,10000"]}).to_frame().T
    assert foreign.counts(frame) == (
        "1 records, 1 runs: 1 `ok`, 0 others, 0 of them for the right reason. 1 are explained, "
        "0 of them by a wrong law. `ok` with a wrong number or law: 1:\n\n- `mat`, run 1: k (winkler)."
    )
    assert foreign.table(frame).splitlines()[2] == (
        "| `mat` | a mat | ok |  | winkler, right | +50 (+50.0) |  | 1 of 2, 0.002 | +0.0 | 0.002 |"
    )


def test_a_run_without_a_law_and_one_that_was_missed(tmp_path):
    frame = graded(tmp_path, {"runs": ["mat,1,3.905,fail"], "choice": []}).to_frame().T
    missed = foreign.grade(
        {name: foreign.tables_of(tmp_path)[name].iloc[:0] for name in foreign.TABLES},
        {"mat": {}},
        {"mat": TRUTH},
    )
    both = pd.concat([frame, missed])
    assert foreign.table(both).splitlines()[2] == (
        "| `mat` | a mat | fail, missed | 0 of 2 | none |  |  | 1 of 2, 0.002 | +0.0 |  |"
    )
    assert foreign.counts(both) == (
        "1 records, 2 runs: 0 `ok`, 2 others, 0 of them for the right reason. 0 are explained, "
        "0 of them by a wrong law. `ok` with a wrong number or law: none."
    )


def main(*arguments, cwd=ROOT):
    command = [commands() / "python", "-m", "freerock_bench.foreign", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd)


def test_results_without_tables_are_one_line(tmp_path):
    done = main(tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == (
        f"{tmp_path}/tables/runs.csv: there is no such file; run `snakemake --config campaigns=foreign`, or "
        "name the folder of its results\n"
    )


def test_elsewhere_the_truths_are_missed_in_one_line(tmp_path):
    done = main(tmp_path, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (
        1,
        "benchmarks/foreign/truths.json: there is no such file; run it in the checkout of freerock\n",
    )
