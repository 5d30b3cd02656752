import json
import math
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, failed_record, fits, record, tidy_tables

from freerock.jobs import make_tables
from freerock.populations import predict, shared_foundation
from freerock.runs.verdict import Reason, Verdict, in_one_line
from freerock.tables import columns as listed
from freerock.tables import tidy_tables as tables
from freerock.tables.populations import populations_table
from freerock.tables.printed_tables import table2_text, table3_text
from freerock.tables.summary import table2, table3
from freerock.tables.tidy_tables import (
    epsilon_table,
    parameters_table,
    parts_table,
    reasons_table,
    restitution_table,
    runs_table,
)


@pytest.fixture(scope="module")
def datasets():
    return campaign()


def test_runs_have_the_columns_of_the_contract(datasets):
    assert ",".join(runs_table(datasets[0])) == (
        "campaign,test,run,block,foundation,origin,theta0_deg,theta0_u_deg,release_s,duration_s,"
        "n_impacts,n_restitution,sigma_theta_deg,verdict,reasons,excluded"
    )


def test_records_read_some_at_once_are_all_in_the_tables(datasets, monkeypatch):
    monkeypatch.setattr(make_tables, "AT_ONCE", 2)
    for name in ("open_record", "open_fits"):
        monkeypatch.setattr(make_tables, name, lambda tree, samples: tree)
    records, _, found = make_tables._read(datasets[0][:3], datasets[1][:3])
    tests = ["b1_marble", "b1_mat", "b2_marble"]
    assert [tree.attrs["test"] for tree in records] == found["runs"]["test"].unique().tolist() == tests


def test_runs_in_degrees_and_seconds(datasets):
    row = runs_table(datasets[0]).iloc[1]
    assert (row["test"], row["run"], row["origin"], row["n_impacts"]) == ("b1_marble", 2, "simulated", 4)
    assert row["theta0_deg"] == pytest.approx(10.2)
    assert row["theta0_u_deg"] == pytest.approx(0.02)
    assert (row["release_s"], row["duration_s"]) == pytest.approx((8.0, 4.0))
    assert row["sigma_theta_deg"] == pytest.approx(0.01)


def test_models_that_could_not_be_fitted_are_told_in_the_rows_of_their_runs():
    records = [record(), record("b2_marble")]
    one, other = map(fits, records)
    missed = [[1, "winkler not fitted: too short; hold longer"], [2, "winkler not fitted: so"]]
    one.attrs["not_fitted"] = json.dumps(missed)
    unforeseen = json.dumps([[None, "unforeseen: ZeroDivisionError"]])
    other.attrs |= {"verdict": "fail", "not_fitted": unforeseen}
    for number in (1, 2):
        del other[f"run_{number}"]
    runs = runs_table(records, [one, other])
    told = list(zip(runs["test"], runs["run"], runs["verdict"], runs["reasons"], strict=True))
    left_out = "excluded: the block slid & turned <1°"
    assert told == [
        ("b1_marble", 1, "warn", "winkler not fitted: too short; hold longer"),
        ("b1_marble", 2, "warn", "winkler not fitted: so"),
        ("b1_marble", 3, "warn", left_out),
        ("b2_marble", 1, "fail", "not fitted: unforeseen: ZeroDivisionError"),
        ("b2_marble", 2, "fail", "not fitted: unforeseen: ZeroDivisionError"),
        ("b2_marble", 3, "warn", left_out),
    ]


def test_excluded_runs_and_failed_records_stay_in_the_table(datasets):
    runs = runs_table(datasets[0])
    excluded = runs[(runs["test"] == "b1_marble") & (runs["run"] == 3)]
    assert "slid" in excluded["reasons"].item()
    assert set(runs.loc[runs["excluded"], "run"]) == {3}
    failed = runs[runs["test"] == "b1_broken"]
    assert failed["run"].isna().all()
    assert failed["verdict"].item() == "fail"
    assert "truncated" in failed["reasons"].item()


def test_reasons_are_the_verdicts_of_the_runs_one_by_one(datasets):
    runs, reasons = runs_table(*datasets), reasons_table(*datasets)
    assert list(reasons) == listed.REASONS_COLUMNS
    own = {key: rows for key, rows in reasons.fillna({"run": 0}).groupby(["test", "run"])}
    told = runs.fillna({"run": 0}).set_index(["test", "run"])
    assert {*own} == {*told.index[told["reasons"] != ""]}
    for key, rows in own.items():
        found = [Reason(*row) for row in rows[["verdict", "reason", "sentence"]].itertuples(index=False)]
        assert in_one_line(found) == told.loc[key, "reasons"]
        assert Verdict(tuple(found)).level == told.loc[key, "verdict"]


def test_a_reason_keeps_its_number_through_a_dataset():
    pushed = Reason("warn", "pushed", "why", 0.03, 0.02, "1", "processing.runs.max_push_fraction")
    tree = record(n_runs=1)
    tree["run_1"].attrs["reasons"] = json.dumps([pushed, Reason("ok", "excluded", "by hand")])
    first, second = reasons_table([tree]).itertuples(index=False)
    assert first[5:] == ("warn", "pushed", 0.03, 0.02, "1", "processing.runs.max_push_fraction", "why")
    assert (second.reason, second.sentence, second.key) == ("excluded", "by hand", "")
    assert math.isnan(second.value) and math.isnan(second.limit)


def test_runs_are_ordered_by_number():
    assert runs_table([record(n_runs=11)])["run"].tolist() == list(range(1, 12))


def test_parameters_per_run(datasets):
    table = parameters_table(datasets[1])
    assert ",".join(table) == (
        "campaign,test,run,block,foundation,model,parameter,value,stderr,ci95_low,ci95_high,discrepancy,"
        "u_total,unit,success,given,in_phase"
    )
    own = table[(table["test"] == "b1_marble") & (table["model"] == "hunt_crossley")]
    assert own["run"].tolist() == [1] * 3 + [2] * 3
    assert own["parameter"].tolist()[-3:] == ["k", "lambda", "theta0"]
    assert own["unit"].tolist()[-3:] == ["N m-2", "N s m-3", "rad"]
    assert own["value"].tolist()[:2] == [6.88e6, 1.30e8]
    assert set(table2(populations_table(table), table)["parameter"]) == {"r", "k", "c", "lambda"}


def test_parts_hold_the_parameters_of_the_law_from_each_part_of_a_run(datasets):
    table = parts_table(datasets[1])
    own = table[(table["test"] == "b1_marble") & (table["model"] == "hunt_crossley") & (table["run"] == 2)]
    assert own["parameter"].tolist() == ["k", "k", "lambda", "lambda"]
    assert own["part"].tolist() == [1, 2, 1, 2] and own["end_s"].tolist() == [1.0, 4.0, 1.0, 4.0]
    assert own["value"].tolist() == pytest.approx([1.01 * 6.88e6, 6.88e6, 1.01 * 1.30e8, 1.30e8])
    assert set(own["unit"]) == {"N m-2", "N s m-3"}
    failed = record()
    assert "winkler" not in set(parts_table([fits(failed, failed=["winkler"])])["model"])


def test_epsilon_selects_the_lowest_bic_of_the_successful_fits(datasets):
    table = epsilon_table(datasets[1])
    assert ",".join(table) == (
        "campaign,test,run,block,foundation,model,epsilon_theta,final_time_s,epsilon_holdout,n_parameters,"
        "aic,bic,selected,success,epsilon_in_phase"
    )
    assert set(table[table["selected"]]["model"]) == {"hunt_crossley"}
    assert table.groupby(["test", "run"])["selected"].sum().eq(1).all()

    table = epsilon_table([fits(record(), failed=["hunt_crossley"])])
    assert set(table[table["selected"]]["model"]) == {"winkler"}


def test_restitution_of_experiment_and_models_since_release(datasets):
    table = restitution_table(*datasets)
    assert ",".join(table) == (
        "campaign,test,run,source,impact,time_s,r,r_stderr,r_u,block,foundation,peak_before_deg,"
        "peak_before_u_deg,r_energy,r_energy_stderr,r_energy_u,impact_speed_m_s,r_block,r_block_u,peak_before_block_deg"
    )
    first = table[(table["test"] == "b1_marble") & (table["run"] == 2) & (table["impact"] == 1)]
    assert first["r_stderr"].tolist() == [0.002, 0.0, 0.0, 0.0]
    of_impacts = first[["r_u", "peak_before_u_deg"]].to_numpy()
    assert of_impacts[0] == pytest.approx([0.003, np.degrees(2e-4)]) and np.isnan(of_impacts[1:]).all()
    assert first["source"].tolist() == ["experiment", "housner", "winkler", "hunt_crossley"]
    assert first["time_s"].tolist() == pytest.approx([0.3] * 4)
    assert first["peak_before_deg"].iloc[0] == pytest.approx(10.2)
    assert set(table["run"]) == {1, 2, 3}


@pytest.mark.parametrize("odd", [[], [failed_record()], [failed_record(), record("b9_oak", n_runs=1)]])
def test_tables_joined_of_each_record_are_those_of_all_at_once(datasets, odd):
    records, fitted = datasets
    records = [*odd, *records]
    fitted = [*(fits(tree, failed=["winkler"]) for tree in odd), *fitted]
    whole = tidy_tables(records, fitted)
    apart = tables.joined([tables.rows_of([one], [its]) for one, its in zip(records, fitted, strict=True)])
    assert list(apart) == list(whole)
    for name, frame in whole.items():
        pd.testing.assert_frame_equal(apart[name], frame)


def test_campaign_without_any_run():
    broken = failed_record()
    records, fitted = [broken], [fits(broken)]
    assert len(runs_table(records)) == 1
    assert parameters_table(fitted).empty
    assert epsilon_table(fitted).empty
    assert restitution_table(records, fitted).empty
    nothing = parameters_table(fitted)
    second = table2(populations_table(nothing), nothing)
    assert table2_text(second).empty
    assert table3_text(table3(epsilon_table(fitted))).empty


@pytest.mark.parametrize(
    "columns",
    [
        *(
            listed.RUNS_COLUMNS,
            listed.REASONS_COLUMNS,
            listed.PARAMETERS_COLUMNS,
            listed.PARTS_COLUMNS,
            listed.EPSILON_COLUMNS,
            listed.CHOICE_COLUMNS,
            listed.RESTITUTION_COLUMNS,
        ),
        *(
            listed.CANDIDATES_COLUMNS,
            predict.PREDICTIONS,
            shared_foundation.FOUNDATIONS,
            listed.RESTITUTION_COMPARISON_COLUMNS,
        ),
    ],
    ids="|".join,
)
def test_every_column_of_the_tidy_tables_is_documented(columns):
    text = (Path(__file__).parents[2] / "docs/datasets.md").read_text(encoding="utf-8")
    assert set(columns) <= set(re.findall(r"`(\w+)`", text.split("## tables")[1]))
