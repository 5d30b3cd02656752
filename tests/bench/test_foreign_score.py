"""How an analysis of foreign records is graded, on tables made by hand."""

import pandas as pd
import pytest

from freerock.tables.tidy_tables import R_ENERGY, R_ENERGY_U
from freerock_bench import foreign
from freerock_bench.campaigns import TABLES

TRUTH = {
    "about": "a mat",
    "right_choices": ["winkler"],
    "parameters": {"k": 1e6},
    "runs": [
        {"let_go_s": 3.9, "free_s": 3.912, "impacts_s": [4.0, 4.2, 4.4], "restitution": [0.9, 0.89, 0.88]}
    ],
}


def graded(verdict="ok", selected="winkler", k=1.01e6, r=0.9005):
    """The rows of one run by parameter."""
    of = {"test": "mat", "run": 1}
    tables = {
        "runs": [of | {"release_s": 3.905, "verdict": verdict}],
        "choice": [of | {"model": selected, "status": "selected", "explains": True, "minus_two_log": 0.0}],
        "parameters": [
            of
            | {
                "model": "winkler",
                "parameter": "k",
                "value": k,
                "stderr": 1e4,
                "u_total": 1e4,
                "success": True,
            }
        ],
        "restitution": [of | {"source": "experiment", "time_s": 0.095, R_ENERGY: r, R_ENERGY_U: 1e-3}],
    }
    heads = {
        "populations": ["test", "level", "model"],
        "predictions": ["test", "run"],
        "reasons": ["test", "run", "reason"],
        "paper": ["test", "model"],
        "epsilon": ["test", "model"],
    }
    frames = {name: pd.DataFrame(rows) for name, rows in tables.items()}
    frames |= {name: pd.DataFrame(columns=columns) for name, columns in heads.items()}
    return foreign.grade(frames, {"mat": TRUTH}).set_index("parameter")


def test_a_right_run_is_ok_and_right():
    rows = graded()
    assert rows.loc["verdict ok", "inside"] and not rows.loc["ok, wrong", "inside"]
    assert rows.loc["true law in the set", "inside"] and rows.loc["k", "inside"]
    assert rows.loc["r of an impact", "inside"]


@pytest.mark.parametrize(
    "how, note", [({"k": 1.05e6}, "k"), ({"selected": "housner"}, "law"), ({"r": 0.91}, "r of an impact")]
)
def test_an_ok_over_a_wrong_number_or_law_is_seen(how, note):
    row = graded(**how).loc["ok, wrong"]
    assert row["inside"] and row["note"] == note


def test_a_warned_run_may_be_wrong():
    assert not graded("warn", k=2e6).loc["ok, wrong", "inside"]


def test_a_run_that_is_not_found_is_missed():
    tables = {
        name: pd.DataFrame(
            columns=["test", "run", "release_s", "model", "status", "success", "reason", "minus_two_log"]
        )
        for name in TABLES
    }
    tables["populations"] = pd.DataFrame(columns=["test", "level", "model"])
    tables["restitution"] = pd.DataFrame(columns=["test", "run", "source"])
    tables["epsilon"] = tables["paper"] = pd.DataFrame(columns=["test", "run", "model"])
    rows = foreign.grade(tables, {"mat": TRUTH}).set_index("parameter")
    assert not rows.loc["run is used", "inside"] and not rows.loc["ok, wrong", "inside"]
