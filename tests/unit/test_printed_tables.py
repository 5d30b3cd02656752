import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, fits, record, tidy_tables

from freerock.models.block import Block
from freerock.models.laws import PAPER_MODELS
from freerock.tables.latex import latex
from freerock.tables.populations import populations_table
from freerock.tables.printed_tables import (
    angle_notes,
    printed_tables,
    spread,
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
    assert table.loc["b1", "release_angle_deg"] == pytest.approx(10.15)
    assert table.loc["b1", "n_runs"] == 4
    assert table.loc["b2", "release_angle_deg"] == pytest.approx(np.mean([19.9, 19.8, 19.9]))
    assert math.isnan(table.loc["b3", "release_angle_deg"])
    text = table1_text(table.reset_index(), {"b1": "Configuration #2"})
    assert text["Configuration #2"].tolist() == [
        *("0.28", "0.07", "4", "5.84"),
        *("14.04", "0.1443", "7.140", "0.9118"),  # atan(1/4), √(0.14² + 0.035²), √(3g/4R), 1 − 1.5 sin²α
        *("10", "10.150 ± 0.058"),
    ]
    assert text["b3"].tolist()[-2:] == ["–", "–"]


@pytest.mark.parametrize("p, text", [(0.04, "2.0"), (0.1, "< 5.0")])
def test_a_spread_that_noise_may_make_is_a_bound(p, text):
    row = SimpleNamespace(tau=2.0, tau_high=5.0, mean=100.0, scatter_p=p)
    assert spread(row).text == text


def test_table1_has_no_column_that_no_block_has(datasets):
    blocks = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
    table = table1(datasets[0], blocks, {"b1": 10.0})
    missing = table.assign(release_angle_nominal_deg=np.nan)
    heads = table1_text(table)[""].tolist()
    assert "θ₀ nominal / °" in heads
    assert table1_text(missing)[""].tolist() == [head for head in heads if head != "θ₀ nominal / °"]


@pytest.mark.parametrize(
    ("nominal", "told"),
    [(10.0, False), (8.5, False), (13.0, False), (None, False), (5.0, True), (0.1745, True)],
)
def test_table1_says_where_the_nominal_angle_is_not_the_measured_one(datasets, nominal, told):
    blocks = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
    table = table1(datasets[0], blocks, {"b1": nominal} if nominal else None)
    expected = (
        f"Slender was released at {table['release_angle_deg'][0]:.3g}°, not at the nominal "
        f"{nominal or 0:.3g}°: is release_angle_deg right, and in degrees?"
    )
    assert angle_notes(table, {"b1": "Slender"}) == ([expected] if told else [])


@pytest.mark.parametrize("n_runs, told", [(2, True), (1, False)])
def test_the_plus_minus_of_table1_is_explained_where_it_is_printed(datasets, n_runs, told):
    tree = datasets[0][0]
    runs = [name for name in tree.children if name.startswith("run_")]
    one = tree.copy()
    for name in runs[n_runs:]:
        del one[name]
    tidy = tidy_tables(*datasets)
    first = table1([one], {one.attrs["block"]: Block(0.28, 0.07, 5.84)})
    frames = {"table1": first, "table2": second(tidy["parameters"]), "table3": table3(tidy["epsilon"])}
    printed = printed_tables(frames, "measured")["table1"]
    assert ("±" in printed.text.to_string()) == told
    seen, *scatter = printed.notes
    assert seen == "θ₀: as the sensor shows it, a sinking corner included."
    assert scatter == ["θ₀ recorded: mean; ±: standard deviation between the runs."] * told


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


def test_a_value_below_its_uncertainty_is_not_printed(datasets):
    table = second(parameters_table(datasets[1]), PUBLISHED)
    row = table.index[table["parameter"] == "k"][0]

    def printed(u_total):
        table.loc[row, "u_total"] = u_total
        frames = {"table2": table, "table3": table3(epsilon_table(datasets[1]))}
        blocks = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
        frames["table1"] = table1(datasets[0], blocks)
        found = printed_tables(frames, "measured")["table2"]
        return found.text["Identified"].tolist(), found.notes

    for times, is_told in ((1.01, True), (0.99, False)):
        texts, notes = printed(times * table.loc[row, "mean"])
        assert texts.count("not determined") == is_told
        assert ("Not determined: the standard uncertainty exceeds the value." in notes) is is_told


def test_a_rigid_block_that_stops_too_soon_has_the_value_in_phase_beside(datasets):
    table = second(parameters_table(datasets[1]))
    row = table.index[table["parameter"] == "r"][0]
    table.loc[row, ["success", "mean", "u_total", "tau", "in_phase"]] = [False, 0.0, np.nan, np.nan, 0.95]
    texts = table2_text(table)["Identified"].tolist()
    assert [each for each in texts if "stops" in each] == ["0.00 (stops; in phase 0.950)"]


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


def of_run(test, run, value, success=True):
    known = {"campaign": "c", "block": "b", "foundation": "f", "model": "winkler", "parameter": "k"}
    known |= {"unit": "N m-2", "stderr": 1e-3 * value, "success": success}
    known |= {"given": "", "in_phase": math.nan}
    return known | {"test": test, "run": run, "value": value}


def test_table2_shows_the_mean_of_the_runs_and_how_far_they_differ():
    parameters = pd.DataFrame(
        [
            *(of_run("a", i, value) for i, value in enumerate((100.0, 102.0, 104.0), 1)),
            of_run("a", 4, 500.0, success=False),
            of_run("alone", 1, 90.0),
            *(of_run("alike", i, value) for i, value in enumerate((99.95, 100.0, 100.05), 1)),
            of_run("lost", 1, 7.0, success=False),
        ]
    )
    table = second(parameters)
    assert table["n_runs"].tolist() == [3, 1, 3, 0]
    assert table["success"].tolist() == [True, True, True, False]
    assert table["mean"].tolist() == pytest.approx([np.exp(np.log([100, 102, 104]).mean()), 90, 100, 7])
    assert table["tau"].tolist() == pytest.approx([2.0, math.nan, 0.0, math.nan], abs=0.03, nan_ok=True)
    text = table2_text(table)
    assert text["Identified"].tolist() == [
        "102.0 ± 1.2",
        "90.000 ± 0.090",
        "100.000 ± 0.058",
        "7.00 (failed fit)",
    ]
    assert text["τ / %"].tolist() == ["2.0", "–", "< 0.30", "–"]
    assert text["Next run"].tolist() == ["93 … 112", "–", "99.75 … 100.25", "–"]
    assert text["Runs"].tolist() == ["3", "1", "3", "0"]
    rejected = table2_text(table.assign(rejected=[False, False, True, False]))
    assert rejected["τ / %"].tolist() == ["2.0", "–", "–", "–"]
    assert rejected["Next run"].tolist() == ["93 … 112", "–", "–", "–"]
    one = table2_text(table[table["test"] == "alone"])
    assert list(one) == ["Foundation", "Model", "Parameter", "Identified", "Runs"]


def test_a_parameter_is_undetermined_where_no_run_determines_it():
    def row(test, run, known, success=True):
        given = {"given": "" if known else "undetermined", "stderr": 0.1 if known else math.nan}
        return of_run(test, run, 100.0, success) | given

    known = {"first": (True, False), "last": (False, True), "none": (False, False), "all": (True, True)}
    rows = [row(test, run, each) for test, runs in known.items() for run, each in enumerate(runs, 1)]
    rows += [row("lost", 1, True), row("lost", 2, False) | {"given": "fixed", "success": False}]
    rows += [row("held", 1, True, success=False), row("held", 2, False)]
    table = second(pd.DataFrame(rows)).set_index("test")
    undetermined = dict.fromkeys(("none", "held"), "undetermined")
    assert table["given"].to_dict() == dict.fromkeys((*known, "lost"), "") | undetermined
    assert table["n_runs"].to_dict() == {"first": 1, "last": 1, "none": 2, "all": 2, "lost": 1, "held": 1}
    assert table["success"].all()
    tied = pd.DataFrame(
        [row("tied", 1, True) | {"given": "tied: c"}, row("tied", 2, False), row("nan", 1, True)]
    )
    tied.loc[tied["test"] == "nan", "given"] = np.nan
    assert second(tied).set_index("test")["given"].to_dict() == {"tied": "tied: c", "nan": ""}


def test_table3_has_the_order_of_the_laws_and_ranges_of_three_digits(datasets):
    epsilon = epsilon_table(datasets[1][:1])
    epsilon.loc[(epsilon["model"] == "housner") & (epsilon["run"] == 1), "success"] = False
    epsilon.loc[epsilon["model"] == "winkler", "epsilon_theta"] = [3.757e-6, 3.849e-6]
    text = table3_text(table3(epsilon))
    assert text["Model"].tolist() == ["Housner", "Winkler", "Hunt–Crossley"]
    assert text["Range / %"].tolist() == ["–", "(3.76 … 3.85)·10⁻⁴", "(1.30 … 1.30)·10⁻⁴"]


def test_table1_prints_what_follows_from_a_block_with_four_digits():
    text = table1_text(table1([], {"squat": Block(0.14, 0.07, 3.0)})).set_index("")["squat"]
    assert text[["2h / m", "m / kg", "r (Housner)"]].tolist() == ["0.14", "3", "0.7000"]


def test_table3_prints_percent_and_final_time(datasets):
    table = table3(epsilon_table(datasets[1]), PUBLISHED)
    text = table3_text(table[table["block"] == "b1"])
    assert text.iloc[0].tolist() == ["marble", "Housner", "24.6", "24.6 … 24.6", "2", "15.25", "4.00"]
    assert text["ε_θ / %"].tolist()[:3] == ["24.6", "2.60", "1.30·10⁻⁴"]
    assert text["Published / %"].tolist() == ["15.25", "–", "–", "–", "–", "–"]


def test_several_blocks_stand_under_their_names(datasets):
    text = table3_text(table3(epsilon_table(datasets[1])), {"b2": "Squat block"})
    assert text["Foundation"].tolist()[::7] == ["b1", "Squat block"]
    assert text.iloc[7].tolist() == ["Squat block", *[""] * 5]


def test_second_record_of_a_scene_is_told_apart():
    fitted = [fits(record("first")), fits(record("second"))]
    text = table3_text(table3(epsilon_table(fitted)))
    assert text["Foundation"].tolist() == ["marble (first)", "", "", "marble (second)", "", ""]


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


@pytest.mark.parametrize(
    ("stderr", "given", "success", "told"),
    [
        (0.1, "", True, False),
        (math.nan, "", True, True),
        (math.nan, "fixed", True, False),
        (math.nan, "", False, False),
    ],
)
def test_a_number_without_an_uncertainty_is_explained(datasets, stderr, given, success, told):
    row = of_run("a", 1, 100.0, success) | {"stderr": stderr, "given": given}
    tables = {"table1": table1([], {}), "table2": second(pd.DataFrame([row]))}
    tables |= {"table3": table3(epsilon_table(datasets[1])[:0])}
    notes = printed_tables(tables, "measured")["table2"].notes
    assert any(each.startswith("Without ±") for each in notes) == told
