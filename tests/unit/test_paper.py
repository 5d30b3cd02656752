import math

import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, fits, record

from freerock.figures import models, restitution
from freerock.models.block import Block
from freerock.models.laws import PAPER_MODELS
from freerock.tables.latex import latex
from freerock.tables.paper import angle_notes, printed_tables, table1_text, table2_text, table3_text
from freerock.tables.restitution import restitution_comparison
from freerock.tables.summary import table1, table2, table3
from freerock.tables.tidy import epsilon_table, parameters_table, tidy_tables

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
    assert text["Configuration #2"].tolist() == ["0.28", "0.07", "4", "5.84", "10", "10.150 ± 0.058"]
    assert text["b3"].tolist()[-2:] == ["–", "–"]


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


def test_table2_prints_value_and_published_side_by_side(datasets):
    table = table2(parameters_table(datasets[1]), PUBLISHED)
    text = table2_text(table[table["block"] == "b1"], {"marble": "Marble", "mat": "Mat"})
    assert list(text) == ["Foundation", "Model", "Parameter", "Identified", "Run by run", "Published"]
    assert text["Foundation"].tolist() == ["Marble", "", "", "", "", "Mat", "", "", "", ""]
    assert text.iloc[0].tolist() == ["Marble", "Housner", "r", "0.9570 ± 0.0012", "0.957", "0.958"]
    assert text.iloc[4].tolist() == ["", "", "λ / (N s m⁻³)", "(1.3000 ± 0.0040)·10⁸", "1.30·10⁸", "–"]
    assert text.iloc[5].tolist() == ["Mat", "Housner", "r", "0.9570 ± 0.0012", "0.957", "–"]


def test_tables_and_figures_of_the_paper_show_its_models_and_none_of_their_rivals():
    tree = record("b1_mat", "b1", "mat")
    rivals = ("housner_width", "winkler_pivoting", "hunt_crossley_pivoting_width")
    some, every = (fits(tree, models=models) for models in (PAPER_MODELS, (*PAPER_MODELS, *rivals)))
    tables, more = tidy_tables([tree], [some]), tidy_tables([tree], [every])
    assert set(more["parameters"]["model"]) == set(more["epsilon"]["model"]) == {*PAPER_MODELS, *rivals}
    pd.testing.assert_frame_equal(table2(more["parameters"]), table2(tables["parameters"]))
    pd.testing.assert_frame_equal(table3(more["epsilon"]), table3(tables["epsilon"]))
    blocks = {"b1": Block(0.28, 0.07, 5.84)}
    compared = [
        restitution_comparison(each["runs"], each["parameters"], each["restitution"], blocks)
        for each in (tables, more)
    ]
    pd.testing.assert_frame_equal(*compared)
    drawn = models.draw([every], "simulated")[1]
    assert set(drawn["source"]) == {"measured", *PAPER_MODELS}
    found = restitution.draw(more["runs"], more["restitution"], more["epsilon"], blocks, "simulated")[1]
    assert set(found["source"]) == {"experiment", *PAPER_MODELS}


def test_table2_shows_how_far_runs_differ():
    def rows(test, run, value):
        known = {"block": "b", "foundation": "f", "model": "winkler", "parameter": "k", "unit": "N m-2"}
        return known | {"test": test, "run": run, "value": value, "stderr": 1.0, "success": True}

    parameters = pd.DataFrame(
        [
            rows("a", 1, 100.0),
            rows("a", 2, 120.0),
            rows("a", 3, 140.0),
            rows("a", "pooled", 119.0),
            rows("alone", 1, 90.0),
            rows("alone", "pooled", 90.0),
        ]
    )
    parameters.loc[2, "success"] = False
    table = table2(parameters)
    assert table["run_mean"].tolist() == [110.0, 90.0]
    assert table["run_scatter"].tolist() == pytest.approx([math.sqrt(200), math.nan], nan_ok=True)
    assert table2_text(table)["Run by run"].tolist() == ["110 ± 14", "–"]
    assert "Run by run" not in table2_text(table[1:])


def test_table3_prints_percent_and_final_time(datasets):
    table = table3(epsilon_table(datasets[1]), PUBLISHED)
    text = table3_text(table[table["block"] == "b1"])
    assert text.iloc[0].tolist() == ["marble", "Housner", "24.6", "15.25", "4.00"]
    assert text["ε_θ / %"].tolist()[:3] == ["24.6", "2.60", "1.30·10⁻⁴"]
    assert text["Published / %"].tolist() == ["15.25", "–", "–", "–", "–", "–"]


def test_several_blocks_stand_under_their_names(datasets):
    text = table3_text(table3(epsilon_table(datasets[1])), {"b2": "Squat block"})
    assert text["Foundation"].tolist()[::7] == ["b1", "Squat block"]
    assert text.iloc[7].tolist() == ["Squat block", "", "", "", ""]


def test_second_record_of_a_scene_is_told_apart():
    fitted = [fits(record("first")), fits(record("second"))]
    text = table3_text(table3(epsilon_table(fitted)))
    assert text["Foundation"].tolist() == ["marble (first)", "", "", "marble (second)", "", ""]


def test_a_record_without_joint_fits_shows_the_fits_of_each_run(datasets):
    tidy = tidy_tables(*datasets)
    parameters = tidy["parameters"]
    one = (parameters["test"] == "b1_marble") & (parameters["run"] == "pooled")
    second = table2(parameters[~one])
    assert set(second.loc[second["test"] == "b1_marble", "run"]) == set(
        parameters.loc[(parameters["test"] == "b1_marble") & ~one, "run"]
    )
    assert set(second.loc[second["test"] != "b1_marble", "run"]) == {"pooled"}
    own = second["run"] != "pooled"
    assert second.loc[own, ["run_mean", "run_scatter"]].isna().all(axis=None)
    key = ["test", "run", "model", "parameter"]
    of_runs = parameters.set_index(key)["value"]
    assert second[own].set_index(key)["value"].to_dict().items() <= of_runs.to_dict().items()
    printed = table2_text(second)["Foundation"].tolist()
    assert "marble (b1_marble, run 1)" in printed and "mat" in printed


def test_without_joint_fits_the_tables_are_run_by_run(datasets):
    tidy = tidy_tables(*datasets)
    alone = {name: tidy[name][tidy[name]["run"] != "pooled"] for name in ("parameters", "epsilon")}
    frames = {
        "table1": table1([], {}),
        "table2": table2(alone["parameters"]),
        "table3": table3(alone["epsilon"]),
    }
    printed = printed_tables(frames, "simulated")
    assert list(printed["table2"].text) == ["Foundation", "Model", "Parameter", "Identified", "Published"]
    assert list(printed["table3"].text) == ["Foundation", "Model", "ε_θ / %", "Published / %", "t_f / s"]
    assert printed["table2"].caption == "Identified parameters, run by run"
    nothing = table2(alone["parameters"][:0])
    assert nothing.empty and list(table2_text(nothing)) == list(printed["table2"].text)
    assert r"\begin{tabular}{lllll}" in latex(table2_text(nothing), "Nothing")


def test_models_that_most_runs_reject_or_ask_for_are_marked(datasets):
    tidy = tidy_tables(*datasets)
    runs = tidy["parameters"].loc[lambda frame: frame["test"] == "b1_marble", "run"].unique()
    numbers = [run for run in runs if run != "pooled"]
    assert len(numbers) == 2

    def marked(rejected, joint=True):
        status = ["rejected" if run in rejected else "selected" for run in runs]
        choice = pd.DataFrame({"test": "b1_marble", "run": runs, "model": "winkler", "status": status})
        kept = {
            name: tidy[name][joint | (tidy[name]["run"] != "pooled")] for name in ("parameters", "epsilon")
        }
        second, third = table2(kept["parameters"], None, choice), table3(kept["epsilon"], None, choice)
        for frame in (second, third):
            other = frame[(frame["test"] != "b1_marble") | (frame["model"] != "winkler")]
            assert not other["rejected"].any()
        frames = {"table1": table1([], {}), "table2": second, "table3": third}
        for printed in list(printed_tables(frames, "simulated").values())[1:]:
            told = [model for model in printed.text["Model"] if model.endswith("†")]
            assert told == ["Winkler †"] * second.loc[second["rejected"], "run"].nunique()
            chosen = [model for model in printed.text["Model"] if model.endswith("‡")]
            assert chosen == ["Winkler ‡"] * second.loc[second["selected"], "run"].nunique()
            assert any(note.startswith("‡ The one chosen") for note in printed.notes) == bool(chosen)
            assert any(note.startswith("† Rejected by most of the runs") for note in printed.notes) == bool(
                told
            )
        assert not (second["rejected"] & second["selected"]).any()
        return tuple(set(second.loc[second[status], "run"]) for status in ("rejected", "selected"))

    assert marked({"pooled", numbers[0]}) == (set(), set())
    assert marked(set(numbers)) == ({"pooled"}, set())
    assert marked({"pooled"}) == (set(), {"pooled"})
    assert marked(set(numbers[1:]), joint=False) == (set(numbers[1:]), set(numbers[:1]))
