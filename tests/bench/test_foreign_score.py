"""How an analysis of foreign records is graded, on tables made by hand."""

import pandas as pd
import pytest

from freerock_bench import foreign

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


@pytest.mark.parametrize(("k", "wrong"), [(1_029_000, ""), (1_031_000, "k"), (969_000, "k")])
def test_an_ok_over_a_number_beyond_three_errors_is_wrong(tmp_path, k, wrong):
    rows = [f"mat,1,winkler,k,{k},10000"]
    assert graded(tmp_path, {"parameters": rows}).wrong == wrong


def test_a_law_that_is_not_the_truths(tmp_path):
    row = graded(tmp_path, right_choices=["hunt_crossley"])
    assert (row.choice, row.wrong) == ("wrong", "explained")


def test_a_run_elsewhere_is_not_the_one(tmp_path):
    row = graded(tmp_path, {"runs": ["mat,1,5.5,ok", "other,1,3.905,ok"]})
    assert (row.verdict, row.named, row.choice, row.wrong) == ("missed", False, "none explains", "")
