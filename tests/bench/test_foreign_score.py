"""How an analysis of foreign records is graded, on tables made by hand."""

import pandas as pd
import pytest

from freerock_bench import foreign

TRUTH = {
    "about": "a mat",
    "right_names": ["unexplained"],
    "right_choices": ["winkler"],
    "parameters": {"k": 1e6},
    "runs": [
        {"let_go_s": 3.9, "free_s": 3.912, "impacts_s": [4.0, 4.2, 4.4], "restitution": [0.9, 0.89, 0.88]}
    ],
}


def graded(verdict="ok", reasons="", selected="winkler", k=1.01e6, r=0.9005):
    """The rows of one run by parameter."""
    of = {"test": "mat", "run": 1}
    tables = {
        "runs": [of | {"release_s": 3.905, "verdict": verdict, "reasons": reasons}],
        "choice": [of | {"model": selected, "status": "selected", "explains": True}],
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
        "restitution": [of | {"source": "experiment", "time_s": 0.095, "r_energy": r, "r_energy_u": 1e-3}],
    }
    heads = {
        "populations": ["test", "level", "model"],
        "predictions": ["test", "run"],
        "reasons": ["test"],
        "epsilon": ["test", "model"],
    }
    frames = {name: pd.DataFrame(rows) for name, rows in tables.items()}
    frames |= {name: pd.DataFrame(columns=columns) for name, columns in heads.items()}
    return foreign.grade(frames, {"mat": TRUTH}).set_index("parameter")


def test_a_right_run_is_ok_and_right():
    rows = graded()
    assert rows.loc["verdict ok", "inside"] and not rows.loc["ok, wrong", "inside"]
    assert rows.loc["true law in the set", "inside"] and rows.loc["k", "inside"]
    assert rows.loc["r of an impact", "inside"] and "rightly warned" not in rows.index


@pytest.mark.parametrize(
    "how, note", [({"k": 1.05e6}, "k"), ({"selected": "housner"}, "law"), ({"r": 0.91}, "r of an impact")]
)
def test_an_ok_over_a_wrong_number_or_law_is_seen(how, note):
    row = graded(**how).loc["ok, wrong"]
    assert row["inside"] and row["note"] == note


def test_a_warned_run_is_named_rightly_or_not():
    right, wrong = (graded("warn", text).loc["rightly warned"] for text in ("unexplained; drift", "drift"))
    assert right["inside"] and not wrong["inside"]
    assert not graded("warn", "drift", k=2e6).loc["ok, wrong", "inside"]


def test_a_run_that_is_not_found_is_missed():
    tables = {
        name: pd.DataFrame(columns=["test", "run", "release_s", "model", "status", "success"])
        for name in foreign.TABLES
    }
    tables["populations"] = pd.DataFrame(columns=["test", "level", "model"])
    tables["restitution"] = pd.DataFrame(columns=["test", "run", "source"])
    rows = foreign.grade(tables, {"mat": TRUTH}).set_index("parameter")
    assert rows.loc["verdict missed", "inside"] and not rows.loc["ok, wrong", "inside"]
