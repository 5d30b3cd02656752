import math

import numpy as np
import pandas as pd
import pytest

from freerock.columns import columns_of
from freerock.tables.populations import foundations_table, means_in, populations_table


def fitted(test, foundation, values, parameter="k", model="hunt_crossley", stderr=1e-5):
    unit = {"k": "N m-2", "r": "1"}[parameter]
    return pd.DataFrame(
        {
            "campaign": "lab",
            "test": test,
            "run": range(1, len(values) + 1),
            "block": f"block of {test}",
            "foundation": foundation,
            "model": model,
            "parameter": parameter,
            "value": values,
            "stderr": stderr * np.asarray(values),
            "unit": unit,
            "success": True,
        }
    )


def by_level(table):
    return {level: rows.reset_index(drop=True) for level, rows in table.groupby("level")}


def test_levels_of_a_campaign():
    draw = np.random.default_rng(2)
    parameters = pd.concat(
        [fitted(test, "mat", 3e6 * np.exp(draw.normal(0, 0.03, 40))) for test in ("a", "b", "c")]
        + [fitted("d", "stone", 7e6 * np.exp(draw.normal(0, 0.03, 40)))]
    )
    table = populations_table(means_in(parameters))
    assert list(table) == columns_of("populations")
    levels = by_level(table)
    assert levels["record"]["test"].tolist() == ["a", "b", "c", "d"]
    assert levels["record"]["tau"].tolist() == pytest.approx([0.09e6] * 3 + [0.21e6], rel=0.3)
    assert levels["foundation"]["foundation"].tolist() == ["mat"]
    mat = levels["foundation"].iloc[0]
    assert (mat["n_records"], mat["n_runs"]) == (3, 120)
    assert mat["mean"] == pytest.approx(3e6, rel=0.01)
    assert mat["scatter_p"] > 0.01
    (whole,) = levels["campaign"].itertuples()
    assert whole.tau / whole.mean == pytest.approx(0.03, rel=0.15)
    assert whole.tau_low < whole.tau < whole.tau_high
    assert math.isnan(whole.stderr)


def test_runs_that_scatter_by_their_noise_may_have_some_spread_all_the_same():
    alike = [fitted(test, "mat", [2.95e6, 3e6, 3.05e6], stderr=0.02) for test in ("a", "b")]
    (whole,) = by_level(populations_table(means_in(pd.concat(alike))))["campaign"].itertuples()
    assert whole.tau == whole.tau_low == 0
    assert 0 < whole.tau_high < 0.1 * whole.mean


def test_an_interval_beyond_all_floats_is_open():
    parameters = fitted("a", "mat", [3e6, 3e6, 3e6], stderr=1e3)
    with np.errstate(over="raise"):
        (row,) = by_level(populations_table(means_in(parameters)))["record"].itertuples()
    assert row.next_high == math.inf and math.isfinite(row.mean)


def test_blocks_that_differ_have_a_spread_on_their_foundation():
    values = np.array([0.98, 1.0, 1.02])
    parameters = pd.concat(
        [fitted(test, "mat", k * values) for test, k in (("a", 3e6), ("b", 4e6), ("c", 5e6))]
    )
    (mat,) = by_level(populations_table(means_in(parameters)))["foundation"].itertuples()
    assert mat.scatter_p < 1e-9
    assert mat.tau / mat.mean == pytest.approx(np.log([3, 4, 5]).std(ddof=1), rel=0.01)


def test_r_belongs_to_the_block_and_stays_below_one():
    parameters = pd.concat([fitted(test, "mat", [0.99, 0.97, 0.999], "r", "housner") for test in ("a", "b")])
    levels = by_level(populations_table(means_in(parameters)))
    assert set(levels) == {"record", "campaign"}
    row = levels["record"].iloc[0]
    assert 0 < row["next_low"] < row["mean"] < row["next_high"] < 1


def test_means_hold_every_run_that_may_be_used():
    parameters = pd.concat([fitted("a", "mat", [3e6, 3.1e6, 9e6]), fitted("b", "mat", [8e6, 8.1e6])])
    parameters["success"] = [True, True, False, True, True]
    levels = by_level(populations_table(means_in(parameters)))
    assert levels["record"]["n_runs"].tolist() == [2, 2]
    assert levels["record"]["mean"].iloc[0] == pytest.approx(math.sqrt(3e6 * 3.1e6), rel=1e-3)
    assert levels["foundation"]["n_runs"].tolist() == [4]


def test_a_law_that_does_not_transfer_to_another_block_says_so():
    values = np.array([0.98, 1.0, 1.02])
    apart = [fitted(test, "mat", k * values) for test, k in (("a", 3e6), ("b", 4e6), ("c", 5e6))]
    alike = [fitted(test, "stone", 3e6 * values) for test in ("d", "e", "f")]
    found = foundations_table(populations_table(means_in(pd.concat([*apart, *alike])))).set_index(
        "foundation"
    )
    assert found["transfers"].to_dict() == {"mat": False, "stone": True}
    assert found.loc["mat", "u_total"] > found.loc["mat", "tau"] / math.sqrt(3)  # holds the scatter of blocks
    assert found.loc["mat", "next_low"] < 3e6 and found.loc["mat", "next_high"] > 5e6
