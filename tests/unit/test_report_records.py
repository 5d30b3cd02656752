from fabricated import campaign

from freerock.report.records import charted
from freerock.tables.tidy import runs_table


def test_charts_are_for_the_worst_runs_then_for_the_first_of_each_record():
    runs = runs_table(campaign()[0])
    assert charted(runs, 1) == {("b1_marble", 3)}
    some = charted(runs, 4)
    assert {("b1_marble", 3), ("b1_mat", 3), ("b1_marble", 1), ("b1_mat", 1)} == some
    assert len(charted(runs, 100)) == 9
