"""The study of discrepancy: whether numbers ± u hold where the block moves as no law says."""

import pandas as pd
import pytest

from freerock_bench.discrepancy import FIRST, KINDS, MARK, SIZES, STUDY, UNKNOWN, rows_of
from freerock_bench.harness import NUMBERS, coverage

pytestmark = pytest.mark.slow

AERSTOP_2 = 4  # of six scenes: configuration 2 on Aerstop
MARBLE_1 = 6  # configuration 1 on marble, of a later round
COLUMNS = [*NUMBERS, *STUDY.columns]


def test_the_law_itself_is_no_more_uncertain_than_its_noise():
    rows = rows_of(("Hunt and Crossley's law", AERSTOP_2))
    assert [row["parameter"] for row in rows] == ["k", "lambda"]
    for row in rows:
        assert row["explained"] and row["candidate"] == "hunt_crossley"
        assert row["u"] == row["stderr"] > 0
        assert abs(row["value"] - row["truth"]) < 4 * row["stderr"]


@pytest.mark.parametrize(
    ("kind", "i"),
    [("force by the depth to the 1.05", AERSTOP_2), ("rigid, r falls with the rate", 0)],
)
def test_what_no_law_explains_is_more_uncertain_than_its_noise(kind, i):
    for row in rows_of((kind, i)):
        assert not row["explained"] and row["inside"]
        assert row["u"] > 1.4 * row["stderr"] > 0
        assert row["u"] < 0.5 * abs(row["truth"])


def by_energy(kind):
    rows = [row for row in rows_of((kind, MARBLE_1)) if row["parameter"] == "r_energy"]
    assert len(rows) > 10 and [row["impact"] for row in rows] == [*range(1, len(rows) + 1)]
    assert {*rows[0]} == {*COLUMNS}
    return rows


def test_r_by_energy_of_the_law_itself_is_no_more_uncertain_than_its_noise():
    for row in by_energy("Hunt and Crossley's law"):
        assert row["explained"] and (row["u"] == row["stderr"] or row["impact"] == 1)  # a finger lets go
        assert abs(row["value"] - row["truth"]) < 5 * row["stderr"]


@pytest.mark.parametrize("kind", ["force by the depth to the 1.05", "a cable rubs"])
def test_r_by_energy_is_more_uncertain_where_the_law_does_not_explain_the_run(kind):
    rows = by_energy(kind)
    assert sum(row["inside"] for row in rows) >= 0.8 * len(rows)
    assert all(not row["explained"] and 0.1 > row["u"] > row["stderr"] > 0 for row in rows)


def test_r_by_energy_is_asked_of_later_runs_alone_and_where_the_energy_is_known():
    assert FIRST >= 4 and {*UNKNOWN} < {*KINDS} and (SIZES["full"] - FIRST) >= 12
    assert all(row["parameter"] != "r_energy" for row in rows_of((UNKNOWN[0], MARBLE_1)))


def test_the_study_writes_its_table(monkeypatch, tmp_path):
    one = "rigid, r ± 0.01 by the side"
    monkeypatch.setattr("freerock_bench.discrepancy.KINDS", {one: KINDS[one]})
    monkeypatch.setitem(SIZES, "small", 1)
    document = tmp_path / "uncertainty.md"
    document.write_text(f"a\n{MARK[0]}old{MARK[1]}\nb\n", encoding="utf-8")
    STUDY.main(str(tmp_path / "discrepancy.csv"), "small", str(document))
    text = document.read_text(encoding="utf-8")
    assert f"| {one} | r | 1 |" in text and "old" not in text and text.endswith("discrepancy -->\nb\n")
    frame = pd.read_csv(tmp_path / "discrepancy.csv")
    assert list(frame) == COLUMNS and frame["parameter"].tolist() == ["r"]
    assert coverage(frame)["n"].tolist() == [1]
