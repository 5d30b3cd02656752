import pytest
from fabricated import fits, record

from freerock.models.block import Block
from freerock.report.tables import compared_restitution
from freerock.tables.populations import populations_table
from freerock.tables.restitution_comparison import restitution_comparison
from freerock.tables.tidy_tables import parameters_table, restitution_table, runs_table

BLOCKS = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}


def test_first_impact_is_compared_with_that_of_a_rigid_block():
    records = [record(n_runs=1, theta0_deg=9.9)]
    fitted = [fits(tree) for tree in records]
    tables = (
        runs_table(records),
        populations_table(parameters_table(fitted)).assign(u_total=0.0027),
        restitution_table(records, fitted),
    )
    row = restitution_comparison(*tables, BLOCKS).iloc[0]
    assert row["rigid_s"] == pytest.approx(0.268884, abs=1e-6)  # quarter period of this block from 10°
    assert row["first_impact_s"] == pytest.approx(0.3)
    assert row["r_fitted"] == pytest.approx(0.957)
    assert (row["r_first"], row["r_median"]) == pytest.approx((0.94, 0.9445))
    assert (row["r_low"], row["r_high"]) == pytest.approx((0.94, 0.949))
    assert (row["r_fitted_u"], row["r_first_u"], row["r_median_u"]) == pytest.approx((0.0027, 0.003, 0.003))
    shown = compared_restitution(restitution_comparison(*tables, BLOCKS)).rows[0]
    assert [cell.text for cell in shown[1:4]] == ["0.9570 ± 0.0027", "0.9400 ± 0.0030", "0.9445 ± 0.0030"]
    assert [cell.text for cell in shown[5:7]] == ["0.3000", "0.2689"]


@pytest.mark.parametrize("run", [None, str])  # numbers, and texts as of the written tables
def test_a_run_without_impacts_is_in_neither_mean(run):
    records = [record(n_runs=2, theta0_deg=9.9)]
    fitted = [fits(tree) for tree in records]
    restitution = restitution_table(records, fitted).query("run == 1")
    tables = [runs_table(records), populations_table(parameters_table(fitted)), restitution]
    if run:
        tables = [table.astype({"run": run}) if "run" in table else table for table in tables]
    row = restitution_comparison(*tables, BLOCKS).iloc[0]
    assert row["rigid_s"] == pytest.approx(0.268884, abs=1e-6)
    assert row["first_impact_s"] == pytest.approx(0.3)


def test_the_mean_of_runs_is_no_better_known_than_their_scatter_allows():
    records = [record(n_runs=2, theta0_deg=9.9)]
    fitted = [fits(tree) for tree in records]
    runs, populations = runs_table(records), populations_table(parameters_table(fitted))
    restitution = restitution_table(records, fitted)
    apart = restitution["run"].astype(int).map({1: -0.01, 2: 0.01})
    tables = runs, populations, restitution.assign(r=0.94 + apart, r_u=0.003)
    row = restitution_comparison(*tables, BLOCKS).iloc[0]
    both = (0.003**2 + 0.01**2) ** 0.5  # of an impact, and of two runs, ± 0.014 / √2
    assert (row["r_first_u"], row["r_median_u"]) == pytest.approx((both, both))
