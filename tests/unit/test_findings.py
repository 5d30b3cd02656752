"""The five lines of findings, of made-up campaigns: true sentences, and every number found again."""

import re
from types import SimpleNamespace

import pandas as pd
import pytest
from evidence import NAMED, REJECTED, paper, scene
from fabricated import campaign, failed_record, fits, record
from found_again import found_again
from reported import half_explained, make, tables_of

from freerock.report.findings import Finding, _of_records, _unexplained, findings, laws_of_foundations
from freerock.report.key_figure import key_run
from freerock.report.limitations import limits
from freerock.report.numbers import KNOWN, Number, Tables, listed, plain
from freerock.selection.allowed_hypotheses import NOT_TRIED
from freerock.tables.csvfile import read_csv, write_csv

LAW = {"hunt_crossley"}
LABELS = {"b1": "Slender", "b2": "Squat", "marble": "Marble", "mat": "Soft mat"}


def told(folder, datasets):
    """The findings as texts by their heads, after all their numbers have been found again."""
    names = tables_of(folder, datasets)
    found = findings({name: read_csv(folder / f"{name}.csv") for name in names}, LABELS)
    found_again(found, folder, LABELS)
    return {each.head: " ".join(map(plain, each.sentences)) for each in found}


def single(models=("housner", "winkler", "hunt_crossley"), **options):
    one = record(n_runs=1, **options)
    return [one], [fits(one, models=models)]


def test_a_campaign_with_failures(tmp_path):
    text = told(tmp_path, campaign())
    assert text["Tested"].startswith(
        "9 simulated runs in 5 records: Slender and Squat on Marble and Soft mat"
    )
    assert (
        "1 record failed and 2 runs were left out by hand; what follows does not rest on that."
        in text["Tested"]
    )
    assert text["Explained by"].startswith("Hunt–Crossley explains all 7 runs")
    assert "Housner (" in text["Explained by"]
    assert "Marble: k = (6.8800 ± 0.0060)·10⁶ N m⁻² and λ = " in text["Parameters"]
    assert text["Foundation"].count(" rocks longest on ") == 2
    assert text["Foundation"].endswith(" on Soft mat. Each time ends where the motion is lost in the noise.")
    tables = {name: read_csv(tmp_path / f"{name}.csv") for name in tables_of(tmp_path, campaign())}
    choice = tables["choice"]
    choice.loc[choice["foundation"] == "mat", "explains"] = False
    assert "Foundation" not in {each.head for each in findings(tables, LABELS)}
    assert text["Foundation"].startswith("Slender (h/b = 4.00) rocks longest on ")
    assert re.match(
        r"Marble, from the other runs of a record \(1 averaged\): ε_θ ≤ [\d.]+ %\. "
        r"Marble, from another block \(1 averaged\): ε_θ ≤ [\d.]+ % for Slender and [\d.]+ % for Squat\.",
        text["Predicted"],
    )
    assert "Not tested" not in text["Shared by blocks"]
    assert "2 blocks" in text["Shared by blocks"]
    assert "simulated" in text["Not to be concluded"]


def test_laws_that_were_fitted_and_rejected_are_listed(tmp_path):
    names = tables_of(tmp_path, campaign())
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    choice, candidates = frames["choice"], frames["candidates"]
    own = candidates["model"] == "hunt_crossley"
    rival = candidates[own].assign(model="hunt_crossley_pivoting", n_selected=0, n_explains=0)
    rival = rival.assign(n_rejected=[1, *[0] * (own.sum() - 1)], n_not_fitted=rival["n_runs"])
    rival["n_not_fitted"] -= rival["n_rejected"]
    frames["candidates"] = pd.concat([candidates, rival], ignore_index=True)
    beside = choice[choice["model"] == "hunt_crossley"].assign(
        model="hunt_crossley_pivoting", status="not_fitted", explains=False
    )
    beside.loc[beside.index[0], "status"] = "rejected"
    frames["choice"] = pd.concat([choice, beside], ignore_index=True)
    write_csv(frames["choice"], tmp_path / "choice.csv")
    found = findings(frames, LABELS)
    found_again(found, tmp_path, LABELS)

    def explained():
        (own,) = (each for each in findings(frames, LABELS) if each.head == "Explained by")
        return " ".join(map(plain, own.sentences))

    assert explained().endswith(" and Hunt–Crossley, pivoting (in 1 run).")
    assert "some fits failed" not in explained()
    first = frames["table3"].index[frames["table3"]["model"] == "housner"][0]
    frames["table3"].loc[first, "n_runs"] -= 1  # of a record with two runs
    assert re.search(r"Housner \([^;]+; some fits failed\)", explained()) and explained().count("some") == 1
    assert "No other law that was fitted explains a run. Rejected (" in explained()
    frames["choice"].loc[frames["choice"]["status"] == "rejected", "explains"] = True
    assert "Of the other laws that were fitted, none does as well with as few parameters." in explained()


def test_a_single_run(tmp_path):
    text = told(tmp_path, single())
    assert text["Tested"].startswith("1 simulated run in 1 record: Slender on Marble, released at 10.1°.")
    assert text["Explained by"].startswith("Hunt–Crossley explains the only run:")
    assert "one record" in text["Parameters"]
    assert "one run does not show the scatter between runs" in text["Parameters"]
    assert "Foundation" not in text
    assert text["Shared by blocks"] == "Not tested: each foundation carried one block only."
    assert "How much runs scatter" in text["Not to be concluded"]


def test_release_angles_are_those_of_the_runs_whatever_their_side(tmp_path):
    tree = record(theta0_deg=-10.0)  # the third run is excluded
    assert ", released at 9.80 to 9.90°." in told(tmp_path, ([tree], [fits(tree)]))["Tested"]


def test_parameters_with_a_sign_keep_it(tmp_path):
    row = {"level": "record", "parameter": "tilt", "unit": "rad"}
    rows = [row | {"test": f"t{i}", "mean": mean} for i, mean in enumerate((-0.005, -0.004, 0, 0.001, 0.002))]
    write_csv(pd.DataFrame(rows), tmp_path / "populations.csv")
    where = {"level": "record", "parameter": "tilt"}
    told = _of_records(Tables({"populations": read_csv(tmp_path / "populations.csv")}), where, {})
    assert plain(told).endswith(" = −0.286 to 0.115°")
    assert found_again([Finding("", [told])], tmp_path, {}) == 2


def test_blocks_rock_longest_where_their_mean_time_is_longest(tmp_path):
    names = tables_of(tmp_path, campaign())
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    times = {("b1_marble", "1"): 5.0, ("b1_marble", "2"): 1.0, ("b1_mat", "1"): 4.0, ("b1_mat", "2"): 4.0}
    keys = zip(frames["runs"]["test"], frames["runs"]["run"], strict=True)
    frames["runs"]["duration_s"] = [times.get(key, 3.0) for key in keys]
    (found,) = (each for each in findings(frames, LABELS) if each.head == "Foundation")
    first = "Slender (h/b = 4.00) rocks longest on Soft mat: 4.00 s and 1.00 to 5.00 s on Marble."
    assert plain(found.sentences[0]) == first


@pytest.mark.parametrize("n, law", [(1, ""), (2, "winkler")])
def test_a_law_is_quoted_where_it_explains_most_of_the_runs(n, law):
    rows = [{"test": "t1", "run": i, "foundation": "marble", "model": "winkler"} for i in range(3)]
    choice = pd.DataFrame(rows).assign(status="selected", explains=[i < n for i in range(3)])
    assert laws_of_foundations(choice) == {"marble": law}


def test_no_law_explains_any_run(tmp_path):
    tree = record()
    text = told(tmp_path, ([tree], [fits(tree, models=("housner", "winkler"))]))
    assert text["Explained by"].startswith("No law explains any of the 2 runs: the residual exceeds")
    assert "nearest; its parameters then describe the fit alone" in text["Explained by"]
    assert text["Parameters"] == "None on Marble: no law explains most of the runs there."
    assert "which no law explains" in text["Not to be concluded"]
    assert not any("k =" in line for line in text.values())


def test_some_runs_have_no_law(tmp_path):
    trees = [record("b1_marble"), record("b1_mat", foundation="mat")]
    text = told(tmp_path, (trees, [fits(trees[0]), fits(trees[1], models=("housner", "winkler"))]))
    assert text["Explained by"].startswith("Hunt–Crossley explains 2 of 4 runs")
    assert "No law explains the others" in text["Explained by"]
    assert "Marble: k = " in text["Parameters"]
    assert "None on Soft mat: no law explains most of the runs there." in text["Parameters"]


def test_parameters_are_those_of_the_records_that_the_law_explains(tmp_path):
    found = findings(half_explained(tmp_path), LABELS)
    found_again(found, tmp_path, LABELS)
    text = {each.head: " ".join(map(plain, each.sentences)) for each in found}["Parameters"]
    assert text.startswith("Marble: k = (6.8800 ± 0.0085)·10⁶ N m⁻² and λ = ")
    assert "(Hunt–Crossley, one record)" in text


def test_a_parameter_that_unexplained_records_alone_have_is_not_told(tmp_path):
    """A tilt that was widened on a record that no law explains has a row over the foundation."""
    frames = half_explained(tmp_path)
    populations = frames["populations"]
    of_k = populations[(populations["level"] == "record") & (populations["parameter"] == "k")]
    unexplained = frames["choice"].loc[~frames["choice"]["explains"].astype(bool), "test"]
    tilt = of_k[of_k["test"].isin(unexplained)].iloc[:1].assign(parameter="tilt", unit="rad")
    law = populations[populations["level"] == "record"].drop_duplicates("parameter")
    whole = pd.concat([law, tilt]).assign(level="foundation", test="", block="", model="hunt_crossley")
    frames["populations"] = pd.concat([populations, tilt, whole], ignore_index=True)
    text = {each.head: " ".join(map(plain, each.sentences)) for each in findings(frames, LABELS)}
    assert text["Parameters"].startswith("Marble: k = ") and "of each record" not in text["Parameters"]


def test_measured_records(tmp_path):
    text = told(tmp_path, single(origin="measured"))
    assert text["Tested"].startswith("1 measured run in 1 record")
    assert not any("imulated" in line for line in text.values())


def test_every_record_failed(tmp_path):
    broken = failed_record()
    text = told(tmp_path, ([broken], [fits(broken)]))
    assert text["Tested"] == "No run could be used: 1 simulated record of Slender on Marble."
    assert text["Explained by"] == "No law was fitted to any run."
    assert text["Parameters"] == "None, as no run was fitted."
    assert "k" not in text["Not to be concluded"].split()


def test_two_laws_that_the_data_cant_tell_apart(tmp_path):
    tree = record()
    names = tables_of(tmp_path, ([tree], [fits(tree)]))
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    choice = frames["choice"]
    choice.loc[choice["model"] == "housner", "status"] = "also_possible"
    text = {each.head: " ".join(map(plain, each.sentences)) for each in findings(frames, LABELS)}
    assert "The data can't tell it from Housner in 2 runs." in text["Explained by"]
    assert "That the foundation yields" in text["Not to be concluded"]


def test_widths_of_several_records_of_a_block_have_no_mean(tmp_path):
    trees = [record("first"), record("second")]
    fitted = [fits(tree, models=("housner", "hunt_crossley_width")) for tree in trees]
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in tables_of(tmp_path, (trees, fitted))}
    text = {each.head: " ".join(map(plain, each.sentences)) for each in findings(frames, LABELS)}
    widths = r"; of each record its own 2b = 0\.066\d+ ± [\d.]+ m \(first\) and 0.* m \(second\)"
    assert re.search(widths + ", 94.3 % of the block's width", text["Parameters"])


def test_widths_of_several_blocks_have_no_mean(tmp_path):
    trees = [record("b1_marble"), record("b2_marble", "b2")]
    datasets = trees, [fits(tree, models=("housner", "hunt_crossley_width")) for tree in trees]
    names = tables_of(tmp_path, datasets)
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    of_b2 = (frames["populations"]["test"] == "b2_marble") & (frames["populations"]["parameter"] == "width")
    assert of_b2.sum() == 1
    frames["populations"].loc[of_b2, "mean"] = 0.0321
    text = {each.head: " ".join(map(plain, each.sentences)) for each in findings(frames, LABELS)}
    assert (
        "(Hunt–Crossley, width free, mean of 2 records); of each record its own 2b = " in text["Parameters"]
    )
    each = r"2b = 0\.06600\d* ± [\d.]+ m \(Slender\) and 0\.03210\d* ± [\d.]+ m \(Squat\), "
    assert re.search(each + r"45\.9 to 94\.3 % of the block's width\.", text["Parameters"])


def test_blocks_that_do_not_share_a_foundation_have_each_its_own_parameters(tmp_path, monkeypatch):
    names = tables_of(tmp_path, campaign())
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    frames["foundations"]["shared"] = [False] * len(frames["foundations"])
    text = {each.head: " ".join(map(plain, each.sentences)) for each in findings(frames, LABELS)}
    each = r"k = \(6\.[\d]+ ± [\d.]+\)·10⁶ N m⁻² \(Slender\) and \(6\.[\d]+ ± [\d.]+\)·10⁶ N m⁻² \(Squat\)"
    assert re.search(f"Marble: {each}", text["Parameters"]) and "2 records" in text["Parameters"]
    assert "2 blocks do not share k and λ" in text["Shared by blocks"]
    assert "That parameters found with one block hold for another" in text["Not to be concluded"]
    monkeypatch.setattr("freerock.report.findings.MOST", 1)
    text = {each.head: " ".join(map(plain, each.sentences)) for each in findings(frames, LABELS)}
    assert re.search(
        r"Marble: k = 6\.\d+·10⁶( to 6\.\d+·10⁶)? N m⁻² .* \(Hunt–Crossley, range over 2 records\)",
        text["Parameters"],
    )


def test_the_page_begins_with_the_findings_and_says_where_each_number_stands(tmp_path):
    page = make(tmp_path, campaign())
    first = page.html.partition('<section id="findings"')[2].partition("</section>")[0]
    assert first.count("<dt>") == 7
    assert 'title="tables/populations.csv: value of mean' in first
    assert '<a class="button" href="#look">' in first
    doubtful = first.partition('<ul class="doubtful">')[2].partition("</ul>")[0]
    assert doubtful.count("<li>") == 1 and "the file is truncated" in doubtful
    assert page.html.index('id="findings"') < page.html.index("<table")
    assert "<svg" in first
    assert first.count(" (selected)</span>") == 1 and "Hunt–Crossley (selected)" in first


def test_both_chances_are_told_and_one_near_one_is_a_bound_below_it(tmp_path):
    names = tables_of(tmp_path, campaign())
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    seen = {"f_p": 0.9987, "inputs_p": 0.048, "shared": True, "visible_percent": 5.0}
    frames["foundations"] = frames["foundations"].assign(**seen)
    write_csv(frames["foundations"], tmp_path / "foundations.csv")
    found = findings(frames, LABELS)
    found_again(found, tmp_path, LABELS)
    (shared,) = [each.sentences for each in found if each.head == "Shared by blocks"]
    chances = " (by scatter, p > 0.99; by means and inputs, p = 0.048); "
    assert chances in plain(shared[0]) and plain(shared[0]).endswith(" would show in four of five campaigns.")


def test_of_a_rigid_law_r_is_the_restitution_where_it_is_not_rejected(tmp_path, monkeypatch):
    monkeypatch.setattr("freerock.report.limitations.MOST", 9)
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in tables_of(tmp_path, campaign())}
    known = Tables(frames)
    alone, beside = (" ".join(map(plain, limits(known, quoted))) for quoted in (LAW, {*LAW, "housner"}))
    assert "is the restitution of an impact: the fit" in alone
    assert "is the restitution of an impact where that law is rejected: the fit" in beside


def limited(*runs, untried=()):
    """What must not be concluded from the runs of one record, on a foundation that Hunt–Crossley explains."""
    choice, _ = scene(*runs)
    choice.loc[choice["model"].isin(untried), "reason"] = f"{NOT_TRIED}no reason"
    runs = pd.DataFrame({"origin": ["measured"]})
    foundations = pd.DataFrame({"model": [], "shared": []})
    return " ".join(map(plain, limits(Tables(runs=runs, choice=choice, foundations=foundations), LAW)))


def test_the_scatter_of_runs_is_unknown_of_a_record_with_one_alone():
    run = paper(hunt_crossley_pivoting=REJECTED) | {"hunt_crossley": NAMED}
    assert "How much runs scatter" in limited(run) and "scatter" not in limited(run, run)


def test_k_may_be_another_where_no_fit_was_tried_whose_base_moves_sideways():
    run = paper() | {"hunt_crossley": NAMED}
    assert "sideways" not in limited(run)  # a quick fit rules it out
    assert "sideways" in limited(run, untried=["hunt_crossley_pivoting"])


@pytest.mark.parametrize("doubtful", ["warn", "fail"])
def test_the_first_figure_shows_a_run_without_a_warning(doubtful):
    runs = pd.DataFrame({"test": "t", "run": ["1", "2"], "block": "b", "foundation": "f"})
    assert key_run(runs.assign(verdict=[doubtful, "ok"]), runs, {"b": {"f"}}) == ("t", "2")


@pytest.mark.parametrize("n, text", [(1, "a"), (2, "a and b"), (3, "a, b and c")])
def test_items_are_listed(n, text):
    assert plain(listed([(each,) for each in "abc"[:n]])) == text


def test_a_number_knows_its_rows(tmp_path):
    tables_of(tmp_path, campaign())
    known = Tables({"runs": read_csv(tmp_path / "runs.csv")})
    assert known.count("runs", {"run": KNOWN}).text == "9"
    assert known.count("runs", {}, "test").source == "tables/runs.csv: distinct of test"


def test_the_two_laws_that_come_nearest_most_often_are_named():
    lost = [SimpleNamespace(model=model) for model in ("winkler", "housner", "winkler", "housner", "general")]
    text = plain([each for sentence in _unexplained(lost, Number("5", "runs", {})) for each in sentence])
    assert "Winkler and Housner come nearest; their parameters then" in text and "any of the 5 runs" in text
