import json

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from fabricated import campaign, failed_record, fits, record, tidy_tables

from freerock.runs.verdict import Reason, Verdict, in_one_line
from freerock.tables.campaign_tables import joined, rows_of
from freerock.tables.tidy_tables import (
    _with_energies,
    epsilon_table,
    parameters_table,
    reasons_table,
    restitution_table,
    runs_table,
)


@pytest.fixture(scope="module")
def datasets():
    return campaign()


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


def test_reasons_are_the_verdicts_of_the_runs_one_by_one(datasets):
    runs, reasons = runs_table(*datasets), reasons_table(*datasets)
    own = {key: rows for key, rows in reasons.fillna({"run": 0}).groupby(["test", "run"])}
    told = runs.fillna({"run": 0}).set_index(["test", "run"])
    assert {*own} == {*told.index[told["reasons"] != ""]}
    for key, rows in own.items():
        found = [Reason(*row) for row in rows[["verdict", "reason", "sentence"]].itertuples(index=False)]
        assert in_one_line(found) == told.loc[key, "reasons"]
        assert Verdict(tuple(found)).level == told.loc[key, "verdict"]


def test_parameters_per_run(datasets):
    table = parameters_table(datasets[1])
    own = table[(table["test"] == "b1_marble") & (table["model"] == "hunt_crossley")]
    assert own["run"].tolist() == [1] * 3 + [2] * 3
    assert own["parameter"].tolist()[-3:] == ["k", "lambda", "theta0"]
    assert own["unit"].tolist()[-3:] == ["N m-2", "N s m-3", "rad"]
    assert own["value"].tolist()[:2] == [6.88e6, 1.30e8]


def test_epsilon_selects_the_lowest_bic_of_the_successful_fits(datasets):
    table = epsilon_table(datasets[1])
    assert set(table[table["selected"]]["model"]) == {"hunt_crossley"}
    assert table.groupby(["test", "run"])["selected"].sum().eq(1).all()

    table = epsilon_table([fits(record(), failed=["hunt_crossley"])])
    assert set(table[table["selected"]]["model"]) == {"winkler"}


def test_restitution_of_experiment_and_models_since_release(datasets):
    table = restitution_table(*datasets)
    first = table[(table["test"] == "b1_marble") & (table["run"] == 2) & (table["impact"] == 1)]
    assert first["r_stderr"].iloc[0] == 0.002
    of_impacts = first[["r_u", "peak_before_u_deg"]].to_numpy()
    assert of_impacts[0] == pytest.approx([0.003, np.degrees(2e-4)]) and np.isnan(of_impacts[1:]).all()
    assert first["source"].tolist() == ["experiment", "housner", "winkler", "hunt_crossley"]
    assert first["time_s"].tolist() == pytest.approx([0.3] * 4)
    assert first["peak_before_deg"].iloc[0] == pytest.approx(10.2)
    assert set(table["run"]) == {1, 2, 3}


def test_impacts_beside_a_law_that_has_none_stay_without_energies():
    measured = xr.Dataset({"impact_time": ("impact", [0.3]), "release": 0.0})
    law = xr.Dataset({name: ("impact", np.empty(0)) for name in ("impact_time", "restitution_energy")})
    assert _with_energies(measured, law).identical(measured)


@pytest.mark.parametrize("odd", [[], [failed_record()], [failed_record(), record("b9_oak", n_runs=1)]])
def test_tables_joined_of_each_record_are_those_of_all_at_once(datasets, odd):
    records, fitted = datasets
    records = [*odd, *records]
    fitted = [*(fits(tree, failed=["winkler"]) for tree in odd), *fitted]
    whole = tidy_tables(records, fitted)
    apart = joined([rows_of([one], [its]) for one, its in zip(records, fitted, strict=True)])
    assert list(apart) == list(whole)
    for name, frame in whole.items():
        pd.testing.assert_frame_equal(apart[name], frame)
