import json
import math
import re
import shutil
import subprocess

import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, failed_record, fits, record
from hypothesis import given
from hypothesis import strategies as st

from freerock.models.block import Block
from freerock.products.groups import usable_runs
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.latex import latex, numbers_tex
from freerock.tables.markdown import markdown
from freerock.tables.paper import recovered_text, table1_text, table2_text, table3_text
from freerock.tables.summary import recovered_table, table1, table2, table3
from freerock.tables.text import quantity
from freerock.tables.tidy import epsilon_table, parameters_table, restitution_table, runs_table, tidy_tables

PUBLISHED = {"b1": {"marble": {"housner": {"r": 0.958, "epsilon_theta": 0.1525}}}}


@pytest.fixture(scope="module")
def datasets():
    return campaign()


def test_runs_have_the_columns_of_the_contract(datasets):
    assert ",".join(runs_table(datasets[0])) == (
        "campaign,test,run,block,foundation,origin,theta0_deg,release_s,duration_s,n_impacts,sigma_theta_deg,"
        "verdict,reasons,excluded"
    )


def test_runs_in_degrees_and_seconds(datasets):
    row = runs_table(datasets[0]).iloc[1]
    assert (row["test"], row["run"], row["origin"], row["n_impacts"]) == ("b1_marble", 2, "simulated", 4)
    assert row["theta0_deg"] == pytest.approx(10.2)
    assert (row["release_s"], row["duration_s"]) == pytest.approx((8.0, 4.0))
    assert row["sigma_theta_deg"] == pytest.approx(0.01)


def test_models_that_could_not_be_fitted_are_told_in_the_rows_of_their_runs():
    records = [record(), record("b2_marble")]
    one, other = map(fits, records)
    missed = [[1, "winkler not fitted: too short; hold longer"], ["pooled", "winkler not fitted: so"]]
    one.attrs["not_fitted"] = json.dumps(missed)
    unforeseen = json.dumps([[None, "unforeseen: ZeroDivisionError"]])
    other.attrs |= {"verdict": "fail", "not_fitted": unforeseen}
    for number in (1, 2):
        del other[f"run_{number}"]
    runs = runs_table(records, [one, other])
    told = list(zip(runs["test"], runs["run"], runs["verdict"], runs["reasons"], strict=True))
    joint = "all runs: winkler not fitted: so"
    left_out = "excluded: the block slid & turned <1°"
    assert told == [
        ("b1_marble", 1, "warn", f"winkler not fitted: too short, hold longer; {joint}"),
        ("b1_marble", 2, "warn", joint),
        ("b1_marble", 3, "warn", left_out),
        ("b2_marble", 1, "fail", "not fitted: unforeseen: ZeroDivisionError"),
        ("b2_marble", 2, "fail", "not fitted: unforeseen: ZeroDivisionError"),
        ("b2_marble", 3, "warn", left_out),
    ]


def test_excluded_runs_and_failed_records_stay_in_the_table(datasets):
    runs = runs_table(datasets[0])
    excluded = runs[(runs["test"] == "b1_marble") & (runs["run"] == 3)]
    assert "slid" in excluded["reasons"].item()
    assert set(runs.loc[runs["excluded"], "run"]) == {3}
    failed = runs[runs["test"] == "b1_broken"]
    assert failed["run"].isna().all()
    assert failed["verdict"].item() == "fail"
    assert "truncated" in failed["reasons"].item()


def test_usable_runs_are_neither_excluded_nor_failed():
    tree = record()
    assert list(usable_runs(tree)) == [1, 2]
    tree["run_1"].attrs["verdict"] = "fail"
    assert list(usable_runs(tree)) == [2]


def test_runs_are_ordered_by_number():
    assert runs_table([record(n_runs=11)])["run"].tolist() == list(range(1, 12))


def test_parameters_per_run_and_pooled(datasets):
    table = parameters_table(datasets[1])
    assert ",".join(table) == (
        "campaign,test,run,block,foundation,model,parameter,value,stderr,ci95_low,ci95_high,unit,success"
    )
    own = table[(table["test"] == "b1_marble") & (table["model"] == "hunt_crossley")]
    assert own["run"].tolist() == [1] * 3 + [2] * 3 + ["pooled"] * 4
    assert own["parameter"].tolist()[-4:] == ["k", "lambda", "theta0_1", "theta0_2"]
    assert own["unit"].tolist()[-4:] == ["N m-2", "N s m-3", "rad", "rad"]
    assert own["value"].tolist()[:2] == [6.88e6, 1.30e8]
    assert set(table2(table)["parameter"]) == {"r", "k", "c", "lambda"}


def test_epsilon_selects_the_lowest_bic_of_the_successful_fits(datasets):
    table = epsilon_table(datasets[1])
    assert ",".join(table) == (
        "campaign,test,run,block,foundation,model,epsilon_theta,final_time_s,epsilon_holdout,n_parameters,"
        "aic,bic,selected,success"
    )
    assert set(table[table["selected"]]["model"]) == {"hunt_crossley"}
    assert table.groupby(["test", "run"])["selected"].sum().eq(1).all()

    table = epsilon_table([fits(record(), failed=["hunt_crossley"])])
    assert set(table[table["selected"]]["model"]) == {"winkler"}


def test_restitution_of_experiment_and_models_since_release(datasets):
    table = restitution_table(*datasets)
    assert ",".join(table) == (
        "campaign,test,run,source,impact,time_s,r,r_stderr,block,foundation,peak_before_deg"
    )
    first = table[(table["test"] == "b1_marble") & (table["run"] == 2) & (table["impact"] == 1)]
    assert first["r_stderr"].tolist() == [0.002, 0.0, 0.0, 0.0]
    assert first["source"].tolist() == ["experiment", "housner", "winkler", "hunt_crossley"]
    assert first["time_s"].tolist() == pytest.approx([0.3] * 4)
    assert set(table["run"]) == {1, 2, 3}


def test_campaign_without_any_run():
    broken = failed_record()
    records, fitted = [broken], [fits(broken)]
    assert len(runs_table(records)) == 1
    assert parameters_table(fitted).empty
    assert epsilon_table(fitted).empty
    assert restitution_table(records, fitted).empty
    assert table2_text(table2(parameters_table(fitted))).empty
    assert table3_text(table3(epsilon_table(fitted))).empty


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


def test_table2_prints_value_and_published_side_by_side(datasets):
    table = table2(parameters_table(datasets[1]), PUBLISHED)
    text = table2_text(table[table["block"] == "b1"], {"marble": "Marble", "mat": "Mat"})
    assert list(text) == ["Foundation", "Model", "Parameter", "Identified", "Run by run", "Published"]
    assert text["Foundation"].tolist() == ["Marble", "", "", "", "", "Mat", "", "", "", ""]
    assert text.iloc[0].tolist() == ["Marble", "Housner", "r", "0.9570 ± 0.0012", "0.957", "0.958"]
    assert text.iloc[4].tolist() == ["", "", "λ / (N s m⁻³)", "(1.3000 ± 0.0040)·10⁸", "1.30·10⁸", "–"]
    assert text.iloc[5].tolist() == ["Mat", "Housner", "r", "0.9570 ± 0.0012", "0.957", "–"]


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


def test_recovered_compares_runs_with_the_truth(datasets):
    truth = {("b1_marble", 1, "k"): 6.88e6, ("b1_marble", 1, "lambda"): 1.25e8}
    table = recovered_table(parameters_table(datasets[1]), truth)
    assert table["parameter"].tolist() == ["k", "lambda"]
    assert table["inside"].tolist() == [True, False]
    assert table["error_percent"].tolist() == pytest.approx([0.0, 4.0])
    text = recovered_text(table)
    assert text["In 95 %"].tolist() == ["yes", "no"]
    assert text["Identified"].tolist() == ["(6.880 ± 0.012)·10⁶", "(1.3000 ± 0.0040)·10⁸"]


@pytest.mark.parametrize(
    ("value", "stderr", "text"),
    [
        (0.957, 0.0012, "0.9570 ± 0.0012"),
        (6.88e6, 1.2e4, "(6.880 ± 0.012)·10⁶"),
        (6.88e6, math.nan, "6.88·10⁶"),
        (1.30e8, math.nan, "1.30·10⁸"),
        (0.958, math.nan, "0.958"),
        (-0.01234, 0.00098, "−0.01234 ± 0.00098"),
        (10.05, 0.0996, "10.05 ± 0.10"),
        (9.9996, math.nan, "10.0"),
        (4.2e-6, 1e-7, "(4.20 ± 0.10)·10⁻⁶"),
        (0.0, math.nan, "0.00"),
        (3.0, 40.0, "3 ± 40"),
        (math.nan, 0.1, "–"),
        (5.0, 0.0, "5.00"),
    ],
)
def test_quantity(value, stderr, text):
    assert quantity(value, stderr) == text


@given(st.floats(1e-12, 1e12), st.floats(1e-6, 0.5))
def test_quantity_is_off_by_less_than_a_tenth_of_its_uncertainty(value, relative):
    text = quantity(value, value * relative)
    body, _, power = text.partition("·10")
    digits = power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or "0"
    printed, error = (float(part) * 10.0 ** int(digits) for part in body.strip("()").split(" ± "))
    assert abs(printed - value) <= 0.06 * value * relative
    assert error == pytest.approx(value * relative, rel=0.06)


def test_csv_bytes_are_the_same_and_no_temporary_file_stays(tmp_path):
    frame = pd.DataFrame({"x": [1 / 3, np.nan], "y": ["a", "b"]})
    for name in ("one.csv", "two.csv"):
        write_csv(frame, tmp_path / name)
    assert (tmp_path / "one.csv").read_bytes() == b"x,y\n0.3333333333,a\n,b\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.csv", "two.csv"]
    assert (tmp_path / "two.csv").read_bytes() == (tmp_path / "one.csv").read_bytes()


def test_markdown_keeps_its_columns_whatever_the_cells_hold():
    text = markdown(pd.DataFrame({"a": ["1|2"], "b": ["3"]}), "Caption", ["A note."])
    lines = text.splitlines()
    assert lines[2:5] == ["| a | b |", "| --- | --- |", r"| 1\|2 | 3 |"]
    assert lines[-1] == "*A note.*"


def test_latex_translates_every_sign():
    frame = pd.DataFrame({"λ / (N s m⁻³)": ["(6.880 ± 0.012)·10⁶"], "ε_θ / %": ["−1 & _x"]})
    text = latex(frame, "Angles θ₀", ["50 %"])
    assert r"$\lambda$ / (N s m$^{-3}$) & $\varepsilon_\theta$ / \%" in text
    assert r"(6.880 $\pm$ 0.012)$\cdot$10$^{6}$ & $-$1 \& \_x \\" in text
    assert text.isascii()


def test_latex_leaves_names_alone():
    text = latex(pd.DataFrame({"Record": ["wet_felt"], "t_f / s": ["3.20"]}), "Felt")
    assert r"Record & $t_f$ / s \\" in text
    assert r"wet\_felt & 3.20 \\" in text


def test_numbers_are_macros_of_letters_alone(datasets):
    tidy = tidy_tables(*datasets)
    tidy["parameters"].loc[tidy["parameters"]["test"] == "b2_mat", "success"] = False
    lines = numbers_tex(tidy).splitlines()
    assert lines[0].startswith("% The records are simulated")
    names = [re.fullmatch(r"\\newcommand\{\\(fr[a-zA-Z]+)\}\{.+\}", line)[1] for line in lines[1:]]
    assert len(set(names)) == len(names) == 2 + len(tidy["parameters"]) + 2 * len(tidy["epsilon"])
    assert r"\newcommand{\frRuns}{9}" in lines
    assert r"\newcommand{\frBOneMarbleHousnerR}{0.9570 $\pm$ 0.0012}" in lines
    k = r"(6.880 $\pm$ 0.012)$\cdot$10$^{6}$ N m$^{-2}$"
    assert rf"\newcommand{{\frBOneMarbleRunTwoHuntCrossleyK}}{{{k}}}" in lines
    assert r"\newcommand{\frBTwoMatHousnerR}{failed fit}" in lines


def test_names_that_differ_by_signs_alone_get_macros_of_their_own(datasets):
    tidy = tidy_tables(*datasets)
    for frame in (tidy["parameters"], tidy["epsilon"]):
        frame["test"] = frame["test"].replace({"b1_marble": "b_1", "b1_mat": "b1"})
    names = re.findall(r"\\newcommand\{(.*?)\}", numbers_tex(tidy))
    assert len(set(names)) == len(names)
    assert r"\frBOneHousnerRX" in names


def has_latex():
    return (
        shutil.which("pdflatex")
        and not subprocess.run(["kpsewhich", "booktabs.sty"], stdout=subprocess.DEVNULL).returncode
    )


def test_without_joint_fits_the_tables_keep_their_columns(datasets):
    tidy = tidy_tables(*datasets)
    alone = {name: frame[frame["run"] != "pooled"] for name, frame in tidy.items()}
    second = table2_text(table2(alone["parameters"]))
    third = table3_text(table3(alone["epsilon"]))
    assert list(second) == ["Foundation", "Model", "Parameter", "Identified", "Published"]
    assert list(third) == ["Foundation", "Model", "ε_θ / %", "Published / %", "t_f / s"]
    assert second.empty and third.empty
    assert r"\begin{tabular}{lllll}" in latex(second, "Nothing")


@pytest.mark.skipif(not has_latex(), reason="needs pdflatex with booktabs")
def test_latex_compiles_with_booktabs_alone(tmp_path, datasets):
    records, fitted = datasets
    parameters = parameters_table(fitted)
    truth = {("b1_marble", 1, "k"): 6.88e6, ("b1_marble", 1, "lambda"): 1.25e8}
    recovered = recovered_table(parameters, truth)
    blocks = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
    first, second = table1(records, blocks), table2(parameters, PUBLISHED)
    third = table3(epsilon_table(fitted), PUBLISHED)
    labels = {"b1": "Configuration #2", "mat": "Mat 100 % & more"}
    for name, text in (
        ("table1", table1_text(first, labels)),
        ("table2", table2_text(second, labels)),
        ("table3", table3_text(third, labels)),
        ("recovered", recovered_text(recovered)),
        ("empty", table2_text(second[:0])),
    ):
        (tmp_path / f"{name}.tex").write_text(latex(text, "Of θ₀ ± 5 %", ["A note."]), encoding="utf-8")
    names = ("numbers", "table1", "table2", "table3", "recovered", "empty")
    (tmp_path / "numbers.tex").write_text(numbers_tex(tidy_tables(*datasets)), encoding="utf-8")
    inputs = "\n".join(rf"\input{{{name}}}" for name in names) + r"\frBOneMarbleRunTwoHuntCrossleyK"
    (tmp_path / "all.tex").write_text(
        rf"\documentclass{{article}}\usepackage{{booktabs}}\begin{{document}}{inputs}\end{{document}}"
    )
    done = subprocess.run(
        ["pdflatex", "-halt-on-error", "-interaction=nonstopmode", "all.tex"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-2000:]


def test_names_of_digits_stay_names(tmp_path):
    frame = pd.DataFrame({"test": ["001", "02"], "run": [1, 2], "block": ["1", "2"], "r": [0.9, 0.8]})
    write_csv(frame, tmp_path / "names.csv")
    again = read_csv(tmp_path / "names.csv")
    assert again[["test", "run", "block"]].values.tolist() == [["001", "1", "1"], ["02", "2", "2"]]
    assert again["r"].tolist() == [0.9, 0.8]
