from fabricated import campaign, fits, record
from reported import make

from freerock.products.groups import runs_of
from freerock.report.records import charted, listed_records
from freerock.tables.number_text import quantity
from freerock.tables.tidy_tables import runs_table


def test_fits_are_listed_with_total_uncertainties(tmp_path):
    tree = record()
    fitted = fits(tree)
    k, u = (float(runs_of(fitted)[1]["hunt_crossley"][name][0]) for name in ("value", "u_total"))
    page = make(tmp_path, ([tree], [fitted])).text
    assert f"k = {quantity(k, u)} N m⁻² ;" in page and "(± without inputs)" in page


def test_charts_are_for_the_worst_runs_then_for_the_first_of_each_record():
    runs = runs_table(campaign()[0])
    excluded = runs["excluded"].astype(bool)
    assert charted(runs, 4) == {(test, 1) for test in ("b1_marble", "b1_mat", "b2_marble", "b2_mat")}
    runs.loc[excluded, "verdict"] = "fail"
    runs.loc[(runs["test"] == "b1_mat") & (runs["run"] == 2), "verdict"] = "warn"
    assert charted(runs, 2) == {("b1_mat", 2), ("b1_marble", 1)}
    assert len(charted(runs, 100)) == 9


def test_the_records_with_the_worst_verdicts_are_listed_first():
    runs = runs_table(campaign()[0])
    runs.loc[runs["test"] == "b2_mat", "verdict"] = "warn"
    tests = ["b1_marble", "b1_mat", "b2_marble", "b2_mat", "b1_broken"]
    assert [sorted(listed_records(runs, n).tests) for n in (1, 2)] == [["b1_broken"], ["b1_broken", "b2_mat"]]
    assert listed_records(runs, 3).tests == {"b1_broken", "b2_mat", "b1_marble"}  # with all of its three runs
    assert listed_records(runs, 5).tests == {"b1_broken", "b2_mat", "b1_marble"}
    assert listed_records(runs, 10).tests == set(tests) and not listed_records(runs, 10).told
    shown = listed_records(runs, 1)
    assert shown.told == "Listed: 1 of 5 records, the one whose runs most need a look."
    assert set(shown.rows(runs)["test"]) == {"b1_broken"}
    assert shown.notes("table2") == [f"{shown.told} All: tables/table2.csv."]
