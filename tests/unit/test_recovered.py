import pytest
from fabricated import campaign

from freerock.tables.paper import recovered_table
from freerock.tables.printed import printed_recovered
from freerock.tables.tidy_tables import parameters_table


def test_recovered_compares_runs_with_the_truth():
    truth = {("b1_marble", 1, "hunt_crossley", name): v for name, v in (("k", 6.88e6), ("lambda", 1.25e8))}
    table = recovered_table(parameters_table(campaign()[1]), truth)
    assert table["parameter"].tolist() == ["k", "lambda"]
    assert table["inside"].tolist() == [True, False]
    assert table["error_percent"].tolist() == pytest.approx([0.0, 4.0])
    truth["b1_marble", 1, "hunt_crossley", "k"] = 6.92e6  # beyond the noise, within the total uncertainty
    table = recovered_table(parameters_table(campaign()[1]), truth)
    assert table["inside"].tolist() == [True, False]
    printed = printed_recovered(table)
    assert printed.text["In 1.96 u"].tolist() == ["yes", "no"]
    assert printed.text["Identified"].tolist() == ["(6.880 ± 0.027)·10⁶", "(1.3000 ± 0.0089)·10⁸"]
    assert "total standard uncertainty" in printed.notes[0] and "1 of 2 inside 1.96 u." in printed.notes[0]
