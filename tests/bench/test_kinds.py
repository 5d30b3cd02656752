"""The study of kinds of laboratories: volts to verdict, cause and number."""

import numpy as np
import pandas as pd
import pytest

from freerock_bench.document import BEGIN, END
from freerock_bench.kinds import (
    KINDS,
    STUDY,
    analysed_as_stated,
    record,
    rows_of,
)

pytestmark = pytest.mark.slow

COLUMNS = {*STUDY.columns}


@pytest.mark.parametrize("name", ["clean, rigid", "three samples lost", "beam tilted by 5°"])
def test_a_record_is_that_of_its_seed(name):
    volts, stated, _, true, row = record(name, 1)
    if name == "clean, rigid":
        np.testing.assert_array_equal(record(name, 1).volts, volts)
    assert np.all(np.isfinite(volts)) and volts.size > 5000 and np.std(volts[:1000]) < 5e-3
    assert {*true} <= {"r", "k", "c", "lambda"} and {*row} <= COLUMNS
    assert len({each.name for each in stated.inputs}) == len(stated.inputs) == 9


@pytest.mark.parametrize(
    "name", ["clean, rigid", "clean, Hunt–Crossley, pivoting", "clean, other sizes, Winkler"]
)
def test_a_clean_laboratory_is_ok_and_gives_the_truth(name):
    rows = rows_of((name, 0))
    assert {row["verdict"] for row in rows} == {"ok"} and all(row["explained"] for row in rows)
    for row in rows:
        assert {*row} <= COLUMNS and abs(row["z_u"]) < 3 and row["u"] >= row["stderr"] > 0


@pytest.mark.parametrize("i", [2, 4])
def test_rounded_edges_are_named_and_give_the_law(i):
    """The first is found only where the derivatives by the inputs are renewed on the way. Sharp edges explain
    the second with a slow sensor, then require drag; with inputs as stated its edges become sharp."""
    made = record("edges rounded by 0.7 mm", i)
    result = analysed_as_stated(made.volts, made.stated)
    found, verdict = result.found, result.verdict
    fit = found.fits["hunt_crossley"]
    assert (verdict.level, found.widened) == ("warn", ("edge_radius",)) and found.explained
    assert fit.values["edge_radius"] == pytest.approx(7e-4, rel=0.1)
    off = np.array([fit.values[name] - value for name, value in made.true.items()]) / fit.u_total[:2]
    assert fit.parameters[:2] == (*made.true,) and np.abs(off).max() < 3


def test_the_table_counts_runs_and_numbers(monkeypatch, tmp_path):
    def number(name, run, verdict, causes, z, first):
        row = {"case": name, "run": run, "verdict": verdict, "causes": causes, "z_u": z}
        row |= {"parameter": "k", "inside": abs(z) < 1.96, "inside_stderr": False, "first": first}
        return row | {"among": True, "explained": verdict == "ok"}

    some = ["clean, rigid", "slips, μ = 0.1"]
    rows = [number(some[0], 1, "ok", "", -0.5, False), number(some[0], 2, "ok", "", 2.5, False)]
    rows += [number(some[1], 1, "warn", "slip air", 1.0, True), number(some[1], 2, "ok", "", 9.0, False)]
    rows += [number(some[1], 3, "warn", "air slip", 3.5, False)]
    rows[2] |= {"advice": "width_m again", "advised": "ok", "advised_z_u": 3.5}
    rows[4] |= {"advice": "height_m +0.001", "advised": "warn", "advised_z_u": 5.0}
    table = STUDY.markdown(pd.DataFrame(rows, columns=STUDY.columns)).splitlines()
    assert table[2] == "| clean, rigid | 2 | 0 | 0 |  |  | 1 of 2 | 1 |  |  |  |  |  |"
    assert (
        table[3]
        == "| slips, μ = 0.1 | 1 | 2 | 0 | 1 of 2 | 2 of 2 | 1 of 3 | 1 | 1 | 2 | 1 | 1 | slip 1, air 1 |"
    )
    assert table[-1].startswith("| **all** | 3 | 2 | 0 | 1 of 2 | 2 of 2 | 2 of 5 | 2 | 1 |")
    monkeypatch.setattr("freerock_bench.kinds.KINDS", {some[0]: KINDS[some[0]]})
    document = tmp_path / "validation.md"
    document.write_text(f"a\n{BEGIN}old{END}\nb\n".format("kinds", "kinds"), encoding="utf-8")
    STUDY.main(str(tmp_path / "kinds.csv"), "small", str(document))
    text = document.read_text(encoding="utf-8")
    assert "| clean, rigid | 1 |" in text and "old" not in text and text.endswith("kinds -->\nb\n")
    assert list(pd.read_csv(tmp_path / "kinds.csv")) == STUDY.columns
