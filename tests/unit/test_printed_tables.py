import math

import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, fits, record, tidy_tables

from freerock.models.block import Block
from freerock.models.laws import PAPER_MODELS
from freerock.tables.latex import latex
from freerock.tables.populations import populations_table
from freerock.tables.printed_tables import (
    printed_tables,
    table1_text,
    table2_text,
    table3_text,
)
from freerock.tables.restitution_comparison import restitution_comparison
from freerock.tables.summary import table1, table2, table3
from freerock.tables.tidy_tables import epsilon_table, parameters_table

PUBLISHED = {"b1": {"marble": {"housner": {"r": 0.958, "epsilon_theta": 0.1525}}}}


@pytest.fixture(scope="module")
def datasets():
    return campaign()


def test_table1_averages_the_usable_runs(datasets):
    blocks = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98), "b3": Block(1.0, 0.5, 9.0)}
    table = table1(datasets[0], blocks, {"b1": 10.0}).set_index("block")
    assert table.loc["b1", "slenderness"] == pytest.approx(4)
    assert table.loc["b1", "alpha_deg"] == pytest.approx(10.15)
    assert table.loc["b1", "n_runs"] == 4
    assert table.loc["b2", "alpha_deg"] == pytest.approx(np.mean([19.9, 19.8, 19.9]))
    assert math.isnan(table.loc["b3", "alpha_deg"])
    text = table1_text(table.reset_index(), {"b1": "Configuration #2"})
    assert text["Configuration #2"].tolist() == [
        *("0.28", "0.07", "4", "5.84"),
        *("10", "10.150 ± 0.058"),
        *("14.04", "0.1443", "7.140", "0.9118"),  # atan(1/4), √(0.14² + 0.035²), √(3g/4R), 1 − 1.5 sin²θ_cr
    ]
    assert text["b3"].tolist()[4:6] == ["–", "–"]


def test_table2_prints_value_and_published_side_by_side(datasets):
    table = second(parameters_table(datasets[1]), PUBLISHED)
    text = table2_text(table[table["block"] == "b1"], {"marble": "Marble", "mat": "Mat"})
    assert list(text) == [
        "Foundation",
        "Model",
        "Parameter",
        "Identified",
        "τ / %",
        "Next run",
        "Runs",
        "Published",
    ]
    assert text["Foundation"].tolist() == ["Marble", "", "", "", "", "Mat", "", "", "", ""]
    assert text.iloc[0].tolist() == [
        "Marble",
        "Housner",
        "r",
        "0.95700 ± 0.00085",
        "not seen",
        "0.957 … 0.957",
        "2",
        "0.958",
    ]
    assert text.iloc[4].tolist() == [
        "",
        "",
        "λ / (N s m⁻³)",
        "(1.3000 ± 0.0028)·10⁸",
        "not seen",
        "(1.30 … 1.30)·10⁸",
        "2",
        "–",
    ]
    assert text.iloc[5].tolist() == [
        "Mat",
        "Housner",
        "r",
        "0.95700 ± 0.00085",
        "not seen",
        "0.957 … 0.957",
        "2",
        "–",
    ]


def second(parameters, *others):
    return table2(populations_table(parameters), parameters, *others)


def test_tables_of_the_paper_show_its_models_and_none_of_their_rivals():
    tree = record("b1_mat", "b1", "mat")
    rivals = ("housner_width", "winkler_pivoting", "hunt_crossley_pivoting_width")
    some, every = (fits(tree, models=models) for models in (PAPER_MODELS, (*PAPER_MODELS, *rivals)))
    tables, more = tidy_tables([tree], [some]), tidy_tables([tree], [every])
    assert set(more["parameters"]["model"]) == set(more["epsilon"]["model"]) == {*PAPER_MODELS, *rivals}
    pd.testing.assert_frame_equal(second(more["parameters"]), second(tables["parameters"]))
    pd.testing.assert_frame_equal(table3(more["epsilon"]), table3(tables["epsilon"]))
    blocks = {"b1": Block(0.28, 0.07, 5.84)}
    compared = [
        restitution_comparison(each["runs"], each["populations"], each["restitution"], blocks)
        for each in (tables, more)
    ]
    pd.testing.assert_frame_equal(*compared)


def test_table3_prints_percent_and_final_time(datasets):
    table = table3(epsilon_table(datasets[1]), PUBLISHED)
    text = table3_text(table[table["block"] == "b1"])
    assert text.iloc[0].tolist() == ["marble", "Housner", "24.6", "24.6 … 24.6", "2", "15.25", "4.00"]
    assert text["ε_θ / %"].tolist()[:3] == ["24.6", "2.60", "1.30·10⁻⁴"]
    assert text["Published / %"].tolist() == ["15.25", "–", "–", "–", "–", "–"]


def test_no_fit_at_all_makes_empty_tables(datasets):
    nothing = second(parameters_table(datasets[1])[:0])
    assert nothing.empty
    assert list(table2_text(nothing)) == [
        "Foundation",
        "Model",
        "Parameter",
        "Identified",
        "Runs",
    ]
    assert r"\begin{tabular}{@{}lllll@{}}" in latex(table2_text(nothing), "Nothing")
    assert table3(epsilon_table(datasets[1])[:0]).empty


def test_table3_has_the_median_and_the_range_of_the_runs_that_may_be_used(datasets):
    epsilon = epsilon_table(datasets[1])
    epsilon = epsilon[(epsilon["test"] == "b1_marble") & (epsilon["model"] == "winkler")]
    epsilon = pd.concat([epsilon[:1].assign(run=run) for run in range(1, 5)])
    epsilon = epsilon.assign(epsilon_theta=[0.01, 0.04, 0.02, 5.0], success=[True, True, True, False])
    (row,) = table3(epsilon).itertuples()
    assert (row.n_runs, row.epsilon_theta, row.epsilon_low, row.epsilon_high) == (3, 0.02, 0.01, 0.04)
    assert table3_text(table3(epsilon)).iloc[0]["Range / %"] == "1.00 … 4.00"
    (lost,) = table3(epsilon.assign(success=False)).itertuples()
    assert (lost.n_runs, lost.success) == (0, False)
    assert table3_text(table3(epsilon.assign(success=False))).iloc[0]["ε_θ / %"] == "3.00 (failed fit)"


def test_models_that_most_runs_choose_or_reject_are_marked(datasets):
    tidy = tidy_tables(*datasets)
    runs = tidy["parameters"].loc[lambda frame: frame["test"] == "b1_marble", "run"].unique()
    assert len(runs) == 2

    def marked(rejected):
        status = ["rejected" if run in rejected else "selected" for run in runs]
        choice = pd.DataFrame({"test": "b1_marble", "run": runs, "model": "winkler", "status": status})
        numbers = second(tidy["parameters"], None, choice)
        found = numbers, table3(tidy["epsilon"], None, choice)
        for frame in found:
            other = frame[(frame["test"] != "b1_marble") | (frame["model"] != "winkler")]
            assert not other[["rejected", "selected"]].any(axis=None)
        frames = {"table1": table1([], {}), "table2": found[0], "table3": found[1]}
        told = []
        for printed in list(printed_tables(frames, "simulated").values())[1:]:
            told.append([model for model in printed.text["Model"] if model[-1:] in "†‡" and model])
            for mark, note in (("†", "† Rejected by most of the runs"), ("‡", "‡ Selected for most")):
                noted = any(each.startswith(note) for each in printed.notes)
                assert noted == (mark in "".join(told[-1]))
        assert told[0] == told[1]
        return told[0]

    assert marked({runs[0]}) == []
    assert marked(set(runs)) == ["Winkler †"]
    assert marked(set()) == ["Winkler ‡"]
