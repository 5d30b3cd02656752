"""The study of discrepancy: whether k ± u holds where the block moves as no law says."""

import math

import pandas as pd
import pytest

from freerock_bench.discrepancy import COLUMNS, KINDS, SIZES, coverage, main, markdown, rows_of
from freerock_bench.figures.discrepancy import draw

pytestmark = pytest.mark.slow

AERSTOP_2 = 4  # of six scenes: configuration 2 on Aerstop


def test_the_law_itself_is_no_more_uncertain_than_its_noise():
    rows = rows_of(("Hunt and Crossley's law", AERSTOP_2))
    assert [row["parameter"] for row in rows] == ["k", "lambda"] and {*rows[0]} == {*COLUMNS}
    for row in rows:
        assert row["explained"] and row["candidate"] == "hunt_crossley"
        assert row["discrepancy_percent"] == 0
        assert abs(row["error_percent"]) < 4 * row["stderr_percent"]


@pytest.mark.parametrize(
    ("kind", "i"),
    [("force by the depth to the 1.05", AERSTOP_2), ("rigid, r falls with the rate", 0)],
)
def test_what_no_law_explains_is_more_uncertain_than_its_noise(kind, i):
    for row in rows_of((kind, i)):
        assert not row["explained"] and row["inside"]
        assert row["discrepancy_percent"] > row["stderr_percent"] > 0
        assert row["discrepancy_percent"] < 50


def made_up(kind, half, explained, inside):
    row = {"kind": kind, "half": half, "run": 1, "explained": explained, "parameter": "k"}
    row |= {"error_percent": -3.0, "stderr_percent": 3.0, "discrepancy_percent": 4.0}
    return row | {"inside_stderr": False, "inside": inside}


def test_the_table_counts_by_kind_and_by_half():
    rows = [
        made_up("a", "set", False, True),
        made_up("a", "set", False, False),
        made_up("b", "shown", False, True),
        made_up("b", "shown", True, False),
        made_up("b", "shown", False, True) | {"error_percent": math.nan},
    ]
    frame = pd.DataFrame(rows, columns=COLUMNS).assign(run=range(5))
    known = coverage(frame).set_index("kind")
    assert known["n"].tolist() == [2, 2] and known["after"].tolist() == [50, 50]
    assert known.loc["b", "explained"] == 50 and known.loc["a", "u"] == pytest.approx(5)
    assert markdown(frame).splitlines()[2:] == [
        "| a | set | 0 % | k | 3 % | 3 % | 5 % | 0 % | 50 % |",
        "| b | shown | 50 % | k | 3 % | 3 % | 5 % | 0 % | 50 % |",
        "| **set: 2 runs that nothing explains, mean of the kinds** |  |  |  |  |  |  | 0 % | 50 % |",
        "| **set: 0 runs that a law explains, mean of the kinds** |  |  |  |  |  |  |  |  |",
        "| **shown: 2 runs that nothing explains, mean of the kinds** |  |  |  |  |  |  | 0 % | 100 % |",
        "| **shown: 1 runs that a law explains, mean of the kinds** |  |  |  |  |  |  | 0 % | 0 % |",
    ]
    figure, drawn = draw(frame)
    assert drawn["inside"].tolist() == [50, 50]
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["a", "b"]


def test_the_study_writes_its_table(monkeypatch, tmp_path):
    one = "rigid, r ± 0.01 by the side"
    monkeypatch.setattr("freerock_bench.discrepancy.KINDS", {one: KINDS[one]})
    monkeypatch.setitem(SIZES, "small", 1)
    document = tmp_path / "uncertainty.md"
    ends = "<!-- discrepancy -->\n\nold\n\n<!-- end of the discrepancy -->"
    document.write_text(f"a\n{ends}\nb\n", encoding="utf-8")
    main(str(tmp_path / "discrepancy.csv"), "small", str(document))
    text = document.read_text(encoding="utf-8")
    assert f"| {one} | set |" in text and "old" not in text and text.endswith("discrepancy -->\nb\n")
    frame = pd.read_csv(tmp_path / "discrepancy.csv")
    assert list(frame) == COLUMNS and frame["parameter"].tolist() == ["r"]
