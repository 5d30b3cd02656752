import pytest
from fabricated import campaign

from freerock.tables.recovered import recovered_table, recovered_text
from freerock.tables.tidy import parameters_table


def test_recovered_compares_runs_with_the_truth():
    truth = {("b1_marble", 1, "hunt_crossley", name): v for name, v in (("k", 6.88e6), ("lambda", 1.25e8))}
    table = recovered_table(parameters_table(campaign()[1]), truth)
    assert table["parameter"].tolist() == ["k", "lambda"]
    assert table["inside"].tolist() == [True, False]
    assert table["error_percent"].tolist() == pytest.approx([0.0, 4.0])
    text = recovered_text(table)
    assert text["In 95 %"].tolist() == ["yes", "no"]
    assert text["Identified"].tolist() == ["(6.880 ± 0.012)·10⁶", "(1.3000 ± 0.0040)·10⁸"]
