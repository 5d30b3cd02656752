"""The study of kinds of laboratories: volts to verdict, cause and number."""

import math

import numpy as np
import pandas as pd
import pytest

from freerock.errors import FreerockError
from freerock.runs.verdict import Reason, Verdict
from freerock.selection.hypotheses_tried import Identified
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench import kinds
from freerock_bench.analysed import Analysed
from freerock_bench.document import BEGIN, END
from freerock_bench.kinds import (
    KINDS,
    SIZES,
    STUDY,
    Advice,
    advice,
    analysed_as_stated,
    cases,
    followed,
    record,
    rows_of,
)

pytestmark = pytest.mark.slow

COLUMNS = {*STUDY.columns}


def without_advice(monkeypatch):
    """What is advised is not analysed once more."""
    monkeypatch.setattr(kinds, "_advised", lambda *_: {})


def test_every_kind_has_its_records_and_most_have_a_name():
    assert len(KINDS) >= 40 and SIZES["full"] >= 5
    assert len(cases("full")) == SIZES["full"] * len(KINDS)
    clean = [name for name, kind in KINDS.items() if not kind.names]
    assert all("clean" in name or name in ("card of 12 bits", "slow noise") for name in clean)


@pytest.mark.parametrize("name", ["clean, rigid", "three samples lost", "beam tilted by 5°"])
def test_a_record_is_that_of_its_seed(name):
    volts, stated, _, true, row = record(name, 1)
    if name == "clean, rigid":
        np.testing.assert_array_equal(record(name, 1).volts, volts)
    assert np.all(np.isfinite(volts)) and volts.size > 5000 and np.std(volts[:1000]) < 5e-3
    assert {*true} <= {"r", "k", "c", "lambda"} and {*row} <= COLUMNS
    assert len({each.name for each in stated.inputs}) == len(stated.inputs) == 9


def test_blocks_of_other_sizes_are_none_of_table_1():
    sizes = [record("clean, other sizes, Hunt–Crossley", i).stated.block.height_m for i in range(4)]
    assert len({*sizes}) == 4 and not {*sizes} & {block.height_m for block, _, _ in CONFIGURATIONS.values()}


def test_another_seed_gives_another_record():
    """Scene and noise are drawn alike for all kinds."""
    one, other = (record("clean, rigid", seed).volts for seed in (1, 2))
    assert other.size != one.size or not np.array_equal(other, one)


@pytest.mark.parametrize(
    "name", ["clean, rigid", "clean, Hunt–Crossley, pivoting", "clean, other sizes, Winkler"]
)
def test_a_clean_laboratory_is_ok_and_gives_the_truth(name):
    rows = rows_of((name, 0))
    assert {row["verdict"] for row in rows} == {"ok"} and all(row["explained"] for row in rows)
    for row in rows:
        assert {*row} <= COLUMNS and abs(row["z_u"]) < 3 and row["u"] >= row["stderr"] > 0


def test_a_base_off_level_is_named_first(monkeypatch):
    without_advice(monkeypatch)
    for row in rows_of(("base tilted by 0.3°", 0)):
        assert row["verdict"] == "warn" and row["first"] and row["among"]
        assert "off_level" in row["causes"].split()[:2]


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


def test_an_input_off_by_far_is_not_hidden_by_a_second_damping(monkeypatch):
    """Hunt and Crossley's law lacks one as long as the moment of inertia is as stated."""
    without_advice(monkeypatch)
    rows = rows_of(("inertia 3 % too large", 4))
    assert len(rows) > 1 and all(row["first"] and abs(row["z_u"]) < 2 for row in rows)


def test_advice_is_read_from_the_warnings_and_followed():
    texts = ["width_m of config3 fitted -0.001 m off, a pull of -3.4: measure it again"]
    texts += [
        "no candidate explains the run. Winkler, width free comes nearest if one further cause acts. "
        "Possible causes, with their share of its misfit (measure a cause before you change its setting): "
        "(1) height_m, +0.002 m of config3, "
        "or sampling_rate_fraction, −0.003 of laser (40 %), (2) friction, a moment of 0.007 N m, as of a "
        "cable (9 %)"
    ]
    texts += ["blurred as by a sensor that averages over 6.1 ms, beside the 0 ms stated: find out"]
    texts[1] = texts[1].replace(
        "height_m, +0.002 m", "response_ms, 3.5 ms of laser (40 %), (2) height_m, +0.002 m"
    )
    verdict = Verdict(tuple(Reason("warn", "any", text) for text in texts))
    found = [*advice(Analysed(verdict, Identified(), None))]
    assert found == [
        Advice("width_m", "config3", -0.001, True),
        Advice("response_ms", "laser", 3.5, False),
        Advice("height_m", "config3", 0.002, False),
        Advice("sampling_rate_fraction", "laser", -0.003, False),
        Advice("response_ms", "laser", 6.1, False),
    ]
    _, stated, true, _, _ = record("width 1 mm less", 0)
    u = next(each.u for each in stated.inputs if each.name == "width_m")
    draw = np.random.default_rng(1)
    again = followed(stated, true, found[0], draw)
    assert abs(again.block.width_m - true.block.width_m) < 4 * u
    assert followed(stated, true, found[2], draw).block.height_m == pytest.approx(
        stated.block.height_m + 0.002
    )
    assert followed(stated, true, found[3], draw).clock == pytest.approx(stated.clock / 0.997)
    assert followed(stated, true, found[4], draw).lasers["laser"].response_ms == 6.1


def test_what_is_advised_is_analysed_once_more(monkeypatch):
    made, seen = record("width 1 mm less", 0), []
    text = f"width_m of {made.row['block']} fitted -0.001 m off, a pull of -3.4: measure it again"
    warned = Analysed(Verdict((Reason("warn", "pulled_input", text),)), Identified(), None)

    def again(volts, stated):
        seen.append((volts, stated.block.width_m))
        if len(seen) > 1:
            raise FreerockError("record", "is refused", "record again")
        return Analysed(Verdict(), Identified(), None)

    monkeypatch.setattr(kinds, "analysed_as_stated", again)
    row = kinds._advised(made, warned, "width 1 mm less")
    assert (row["advice"], row["advised"]) == ("width_m again", "ok") and math.isnan(row["advised_z_u"])
    ((volts, width_m),) = seen
    assert volts is made.volts
    u = next(each.u for each in made.stated.inputs if each.name == "width_m")
    assert abs(width_m - made.laboratory.block.width_m) < 4 * u
    assert kinds._advised(made, warned, "width 1 mm less")["advised"] == "fail"
    assert kinds._advised(made, Analysed(Verdict(), Identified(), None), "width 1 mm less") == {}


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
