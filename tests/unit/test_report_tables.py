"""Tables of the report: what the budget of a foundation holds."""

import pandas as pd
from fabricated import fits, record
from reported import half_explained, tables_of

from freerock.columns import columns_of
from freerock.report.tables import budget
from freerock.tables.csvfile import read_csv

LABELS = {"b1": "Slender", "b2": "Squat", "marble": "Marble"}


def means(frames):
    """Foundation, law and parameter of each row of a budget."""
    rows = budget(frames["budget"], frames["choice"], LABELS).rows
    return [[cell.text.partition(" /")[0] for cell in row[:3]] for row in rows]


def test_the_budget_is_of_the_law_that_explains_the_runs_of_a_record(tmp_path):
    assert means(half_explained(tmp_path)) == [
        ["Marble, b1_marble", "Hunt–Crossley", "k"],
        ["Marble, b1_marble", "Hunt–Crossley", "λ"],
        ["Marble", "Winkler", "k"],
        ["Marble", "Winkler", "c"],
    ]


def test_a_mean_over_records_stands_for_those_of_the_records(tmp_path):
    trees = [record("b1_marble"), record("b2_marble", "b2", n_runs=1)]
    names = tables_of(tmp_path, (trees, [fits(tree) for tree in trees]))
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    assert means(frames) == [["Marble", "Hunt–Crossley", "k"], ["Marble", "Hunt–Crossley", "λ"]]


def test_shares_from_one_per_cent_are_told_and_what_nobody_stated():
    parts = [
        ("runs", "marble", None, 70.0),
        ("levelled_deg", "laser", 1, 0.4),
        ("height_m", "b1", 0, 20.0),
        ("width_m", "b1", 1, 7.0),
        ("scale_fraction", "laser", 1, 2.6),
    ]
    frame = pd.DataFrame(parts, columns=["input", "input_owner", "input_stated", "share_percent"])
    mean = {"level": "foundation", "foundation": "marble", "model": "winkler", "parameter": "k"}
    frame = frame.assign(**mean, unit="N m-2", mean=6e6, u_total=6e4).reindex(columns=columns_of("budget"))
    choice = pd.DataFrame([mean | {"test": "b1_marble", "status": "selected"}])
    (row,) = budget(frame, choice, LABELS).rows
    assert [cell.text for cell in row[3:]] == [
        "(6.000 ± 0.060)·10⁶",
        "1.0",
        "runs 70 %; height of Slender 20 % (d); width of Slender 7 %; scale of laser 3 %",
    ]
