"""The study of energies: whether r by energy ± u holds where the block moves as no law says."""

import pandas as pd
import pytest

from freerock_bench.energies import BEDS, COLUMNS, FIRST, SIZES, main, markdown, rows_of

pytestmark = pytest.mark.slow

MARBLE_1 = 6  # of six scenes: configuration 1 on marble, of a later round


def test_the_law_itself_is_no_more_uncertain_than_its_noise():
    rows = rows_of((BEDS[0], MARBLE_1))
    assert len(rows) > 10 and {*rows[0]} == {*COLUMNS}
    for row in rows:
        assert row["explained"] and (row["u"] == row["stderr"] or row["impact"] == 1)  # a finger lets go
        assert abs(row["error"]) < 5 * row["stderr"]


@pytest.mark.parametrize("kind", ["force by the depth to the 1.05", "a cable rubs"])
def test_what_the_law_does_not_explain_is_more_uncertain_than_its_noise(kind):
    rows = rows_of((kind, MARBLE_1))
    assert sum(row["inside"] for row in rows) >= 0.8 * len(rows) > 10
    for row in rows:
        assert not row["explained"]
        assert row["u"] > row["stderr"] > 0 and row["u"] < 0.1


def made_up(kind, explained, before, after):
    row = {"kind": kind, "run": 1, "explained": explained, "error": -0.003, "stderr": 0.001, "u": 0.002}
    return row | {"inside_stderr": before, "inside": after}


def test_the_table_counts_by_kind_and_by_what_is_explained():
    rows = [
        made_up("a", False, False, True),
        made_up("a", False, False, False) | {"run": 2},
        made_up("b", False, True, True),
        made_up("b", True, False, False) | {"run": 2},
    ]
    table = markdown(pd.DataFrame(rows, columns=COLUMNS)).splitlines()
    assert table[2] == "| a | 2 | 0 % | 2 | 0.003 | 0.001 | 0.002 | 0 % | 50 % |"
    assert table[4].endswith("| 3 |  | 3 |  |  |  | 50 % | 75 % |")
    assert table[5].endswith("| 1 |  | 1 |  |  |  | 0 % | 0 % |")


def test_the_product_and_the_document_are_written(tmp_path, monkeypatch):
    frame = pd.DataFrame([made_up("a", False, False, True)], columns=COLUMNS)
    monkeypatch.setattr("freerock_bench.energies.run", lambda size: frame)
    document = tmp_path / "a.md"
    document.write_text("x <!-- energies -->\n\nold\n\n<!-- end of the energies --> y")
    main(tmp_path / "a.csv", "small", document)
    assert document.read_text().startswith("x <!-- energies -->\n\n| motion")
    assert pd.read_csv(tmp_path / "a.csv")["kind"].tolist() == ["a"]
    assert FIRST >= 4 and SIZES["full"] % 6 == 0
