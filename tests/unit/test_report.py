"""The report: its first screen, tables as in the CSV, reasons, methods; nothing from outside."""

import json
import math
import re

import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, failed_record, fits, record
from reported import PUBLISHED, make, tables_of

from freerock.config.review_log import Change
from freerock.models.block import Block
from freerock.report.found import printed_summary
from freerock.report.limitations import limits
from freerock.report.methods import REFERENCES
from freerock.report.printed import AGAINST, OF_BLOCKS, TRUTH, printed_tables
from freerock.report.runs import printed_runs, printed_tests
from freerock.tables.number_text import percent, quantity
from freerock.tables.paper import table1

HOSTILE = "<script>alert(1)</script>&\"'"
LABELS = {"b1": "Slender", "b2": "Squat", "marble": "Marble", "mat": "Soft mat"}
ENTRY = re.compile(r"@(?:article|book|misc)\{(\w+),\n(?:  \w+ = \{.+\},\n)+\}\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def page(folder):
    return make(folder, campaign())


@pytest.fixture(scope="module")
def tables(folder, page):
    return tables_of(folder, campaign())


def test_the_first_screen_has_each_foundation_with_law_parameters_and_epsilon(page, tables):
    summary = tables["summary"].set_index("foundation").loc["marble"]
    first = page.text.partition("Table 1.")[0]
    assert page.text.index("Limits.") < page.text.index("Table 1.") < page.text.index("Runs and verdicts")
    assert "Hunt–Crossley, 4 of 4 runs" in first
    assert f"k = {quantity(summary['k'], summary['k_u'])} N m⁻²" in first.replace("\N{NO-BREAK SPACE}", " ")
    laws = {"housner": "Housner", "winkler": "Winkler", "hunt_crossley": "Hunt–Crossley"}
    epsilon = ", ".join(f"{label} {percent(summary[f'epsilon_{law}'])}" for law, label in laws.items())
    printed = printed_summary(tables["summary"], tables["runs"], LABELS).text
    told = " | ".join(printed["Marble"]).replace("\N{NO-BREAK SPACE}", " ")
    assert epsilon in told and epsilon in page.text.replace("\N{NO-BREAK SPACE}", " ")
    assert not {"None", "nan"} & {*page.text.split()}
    assert (
        summary["longest"] == "b1 b2"
        and math.isnan(summary["half_band"])
        and "Slender, Squat" in printed["Marble"].tolist()
    )
    assert "The records are simulated: real blocks" in first


def test_the_first_screen_says_how_long_blocks_rock_and_has_the_numbers_of_table_2(tables):
    runs, summary = tables["runs"], tables["summary"].copy()
    usable = runs[(runs["verdict"] != "fail") & ~runs["excluded"] & (runs["foundation"] == "mat")]
    seconds = usable.groupby("block")["duration_s"].median()
    printed = printed_summary(summary, runs, LABELS).text.set_index("Foundation")["Soft mat"]
    assert printed.iloc[0] == f"Slender: {quantity(seconds['b1'])}; Squat: {quantity(seconds['b2'])}"
    second = printed_tables(tables, "simulated", labels=LABELS)["table2"].text
    of_law = second[second.iloc[:, 0] == "Hunt–Crossley"]["Soft mat"].iloc[-1]
    for cell in of_law.split(", "):
        assert cell in printed["Parameters"].replace("\N{NO-BREAK SPACE}", " ")
    summary["sigma_r"] = summary["sigma_r_u"] = 0.0
    summary["n_runs"] = summary["n_selected"] = 1
    many = pd.concat([runs.assign(block=f"b{i}") for i in range(5)])
    printed = printed_summary(summary, many, LABELS).text.set_index("Foundation")["Soft mat"]
    assert printed["Scatter of impacts σ_r / %"] == "none found" and "; blocks: " in printed.iloc[0]
    assert printed["Selected law"] == "Hunt–Crossley, 1 of 1 run"


def test_only_a_block_on_two_foundations_can_rock_longer_on_one(tables):
    runs, head = tables["runs"], "Blocks that rock longest on it"
    printed = printed_summary(tables["summary"], runs, LABELS).text.set_index("Foundation").loc[head]
    assert printed.to_dict() == {"Marble": "Slender, Squat", "Soft mat": "none"}
    apart = runs[(runs["block"] == "b1") == (runs["foundation"] == "marble")]
    summary = tables["summary"].assign(longest=[math.nan, "b2"])
    printed = printed_summary(summary, apart, LABELS).text.set_index("Foundation").loc[head]
    assert printed["Marble"] == "–"


def test_no_run_needs_a_look_only_where_that_is_so(tmp_path, page):
    assert re.search("\\d needs? a look", page.text) and "No run needs a look" not in page.text
    tree = record(n_runs=1)
    assert "No run needs a look" in make(tmp_path, ([tree], [fits(tree)])).text


def test_printed_numbers_are_those_of_the_tables(tables):
    printed = printed_tables(tables, "simulated", doi="10.1/2", labels=LABELS)
    third, second = printed["table3"].text, printed["table2"].text
    row = tables["table3"].query("block == 'b1' and foundation == 'marble' and model == 'housner'").iloc[0]
    (cell,) = third[third.iloc[:, 0] == "Housner"]["Marble"].head(1)
    assert cell == f"{quantity(100 * row['epsilon_theta'])} [15.25]"
    k = tables["table2"].query("foundation == 'mat' and parameter == 'k'")
    of_law = second[second.iloc[:, 0] == "Winkler"]["Soft mat"].tolist()
    paper = k.query("model == 'winkler' and block == 'b1'").iloc[0]
    assert of_law[0].split(", ")[0] == f"k̄ = {quantity(paper['paper'])}" and of_law[-1] == "rejected"
    over = k[k["block"].isna() & (k["model"] == "hunt_crossley")].iloc[0]
    last = second.iloc[-1]["Soft mat"].split(", ")[0]
    assert last == f"k = {quantity(over['mean'], over['u_total'])}"
    head = second.iloc[:, 0].tolist().index("Slender, paper's procedure")
    assert (
        second.iloc[head + 1]["Marble"].endswith(" [0.958]") and "[" not in second.iloc[head + 1]["Soft mat"]
    )
    impacts = printed["restitution"].text
    first = tables["restitution"].query("test == 'b1_marble' and run == '1' and impact == 1")
    seen, hunt = (first[first["source"] == each].iloc[0] for each in ("experiment", "hunt_crossley"))
    told = impacts.iloc[1]
    assert told["Simulated record"] == quantity(seen["r"], seen["r_u"])
    assert told["Hunt–Crossley"] == f"{hunt['r']:.3f}"
    assert printed["table1"].text.set_index("").loc["α / °", "Slender"] == "10"
    assert printed["table1"].text.set_index("").loc["θ_cr / °", "Slender"] == "14.04"


@pytest.mark.parametrize("reason", ["hold_unseen", "braked"])
def test_table_1_has_the_mean_angle_of_runs_that_were_held_and_u_of_shared_inputs_does_not_shrink(reason):
    one, two = record(), record()
    one["run_1"].attrs["reasons"] = json.dumps([["warn", reason, "why", None, None, "", ""]])
    blocks = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
    frame = table1([one, two], blocks).set_index("block")
    own, noise = frame.loc["b1"], np.degrees(1e-4)
    assert own["n_runs"] == 3 and own["alpha_deg"] == pytest.approx((10.2 + 10.1 + 10.2) / 3)
    shared = math.sqrt(0.02**2 - noise**2)
    assert own["alpha_u_deg"] == pytest.approx(math.hypot(shared, noise / math.sqrt(3)))
    assert own["alpha_std_deg"] == pytest.approx(np.std([10.2, 10.1, 10.2], ddof=1))
    assert frame.loc["b2", ["alpha_deg", "alpha_u_deg", "alpha_std_deg"]].isna().all()


def test_the_note_of_table_1_explains_what_stands_in_it(tables):
    def printed(frame):
        return printed_tables(tables | {"table1": frame}, "measured", labels=LABELS)["table1"]

    whole = printed(tables["table1"])
    row = tables["table1"].set_index("block").loc["b1"]
    cells = whole.text.set_index("")["Slender"]
    assert cells["α recorded / °"] == quantity(row["alpha_deg"], row["alpha_u_deg"])
    assert all(each in whole.notes[0] for each in OF_BLOCKS.values())
    unheld = printed(tables["table1"].assign(alpha_deg=math.nan, alpha_u_deg=math.nan))
    assert "±" in whole.notes[0] and "±" not in unheld.notes[0]


def test_table_2_has_each_block_by_the_papers_procedure_and_the_mean_of_a_foundation(tables):
    table = tables["table2"]
    assert set(table.query("parameter == 'r'")["block"]) == {"b1", "b2"}
    own = table.fillna({"block": "all"}).query("foundation == 'mat' and parameter == 'c'").set_index("block")
    over = tables["populations"].query(
        "level == 'foundation' and foundation == 'mat' and model == 'winkler' and parameter == 'c'"
    )
    assert own.loc["all", "mean"] == over["mean"].item() and own.loc["all", "n_records"] == 2
    assert own.loc["all", "rejected"] and math.isnan(own.loc["all", "paper"])
    fits = tables["paper"].query(
        "foundation == 'mat' and block == 'b1' and model == 'winkler' and parameter == 'c'"
    )
    assert own.loc["b1", "paper"] == fits["value"].median()
    assert PUBLISHED["b1"]["marble"]["housner"]["r"] in table["published"].tolist()


def test_a_fit_of_the_paper_that_is_no_likeness_is_marked(tables):
    table = tables["table2"].copy()
    far = (table["model"] == "housner") & (table["block"] == "b1") & (table["foundation"] == "marble")
    table.loc[far, "epsilon_theta"] = 0.79
    stops = (table["parameter"] == "r") & (table["block"] == "b2") & (table["foundation"] == "marble")
    table.loc[stops, "paper"] = 0.00286
    apart = (table["model"] == "winkler") & (table["block"] == "b1") & (table["foundation"] == "marble")
    table.loc[apart & (table["parameter"] == "k"), "paper_high"] *= 2.1
    printed = printed_tables(tables | {"table2": table}, "simulated", labels=LABELS)["table2"]
    assert printed.text["Marble"][1] == "no fit † [0.958]" and "⁶ ‡, c = " in printed.text["Marble"][2]
    own = {*printed.text[printed.text.iloc[:, 0].str.startswith("Housner")]["Marble"]}
    assert {text.partition(" [")[0] for text in own} == {"no fit †", "rejected"}
    assert not any("±" in text for text in own)  # whose mean says nothing
    assert "†: ε_θ above 50 %, or r < 0.01" in printed.notes[0] and "‡: runs differ" in printed.notes[0]


def test_notes_say_that_records_were_made_with_the_published_values_and_where_laws_change_places(tables):
    second, third = (tables[name].copy() for name in ("table2", "table3"))
    first = (second["block"] == "b1") & (second["foundation"] == "mat") & (second["parameter"] == "k")
    second.loc[first & (second["model"] == "hunt_crossley"), "published"] = 6.88e6

    def notes(name, origin):
        frames = tables | {"table2": second, "table3": third}
        return " ".join(printed_tables(frames, origin, doi="10.1/2", labels=LABELS)[name].notes)

    assert TRUTH in notes("table2", "simulated") and TRUTH not in notes("table2", "measured")
    assert "Median of the runs" in notes("table2", "measured") and "§" not in notes("table3", "simulated")
    winkler = (third["block"] == "b1") & (third["foundation"] == "mat") & (third["model"] == "winkler")
    third.loc[winkler, "epsilon_theta"] = 1e-3
    third.loc[third["model"] == "hunt_crossley", "epsilon_theta"] = 2e-3
    marked = printed_tables(tables | {"table3": third}, "simulated", labels=LABELS)["table3"]
    assert marked.text.stack().str.endswith("§").sum() == 1 and AGAINST in marked.notes[0]
    assert marked.text.set_index(marked.text.columns[0]).loc["Winkler", "Soft mat"].iloc[0] == "0.100 §"
    second.loc[second["model"] == "hunt_crossley", "rejected"] = True
    third["n_runs"] = second["n_runs"] = 1
    assert TRUTH not in notes("table2", "simulated")
    assert all(notes(name, "simulated").startswith("One run of each block") for name in ("table2", "table3"))


def test_heads_are_the_names_of_blocks_as_they_are(tables):
    named = printed_tables(tables, "simulated", labels=LABELS | {"b1": "block1"})
    for name in ("table2", "table3"):
        heads = named[name].text.iloc[:, 0]
        assert heads.str.startswith("block1").sum() == 1 and not heads.str.startswith("Block1").any()
    one = tables["table2"].query("block == 'b1' or block.isna()")
    heads = printed_tables(tables | {"table2": one}, "simulated", labels=LABELS)["table2"].text.iloc[:, 0]
    assert {"Paper's procedure", "Inputs and impacts free"} <= {*heads}


def test_candidates_stand_once_for_runs_that_are_alike(tables):
    choice, runs = tables["choice"], tables["runs"]
    text = printed_tests(choice, runs).text.query("Record == 'b1_marble'")
    assert text["Runs"].tolist() == ["1, 2"] * 3 and "p (prediction)" not in text
    one = choice["test"].eq("b1_marble") & choice["run"].astype(str).eq("2") & choice["model"].eq("winkler")
    text = printed_tests(choice.assign(p_prediction=np.where(one, 0.2, np.nan)), runs).text
    own = text.query("Record == 'b1_marble' and Candidate == 'Winkler'")
    assert sorted(zip(own["p (prediction)"], own["Runs"], strict=True)) == [("0.20", "2"), ("–", "1")]


def test_a_zero_crossing_is_called_no_impact(tables):
    runs = tables["runs"].assign(n_impacts=54)
    told = printed_runs(runs, tables["choice"], LABELS, len(runs)).text
    assert {*told["Zero crossings"]} == {"–", "54 (4 with r)"} and "Impacts" not in told


def test_every_run_stands_with_its_verdict_and_reasons(page):
    assert "the block slid & turned <1°" in page.text
    assert "the file is truncated; record it again" in page.text
    assert "1 record could not be processed" in page.text
    assert '<span class="excluded">b1_marble, run 3' in page.html


def test_a_campaign_whose_records_all_failed_has_its_report(tmp_path):
    lost = failed_record()
    page = make(tmp_path, ([lost], [fits(lost)]))
    assert "No run was fitted: nothing is known of the foundations." in page.text
    assert "the file is truncated; record it again" in page.text


def test_the_report_needs_nothing_from_outside_and_runs_nothing(page):
    assert not [tag for tag, _ in page.tags if tag in ("link", "iframe", "script")]
    sources = [attrs[key] for _, attrs in page.tags for key in ("src", "href") if key in attrs]
    assert sources and all(
        re.match(r"#|data:image/png;base64,|figures/qc\.png$|image\.pdf$", source) for source in sources
    )
    (policy,) = [attrs["content"] for _, attrs in page.tags if attrs.get("http-equiv")]
    assert policy.startswith("default-src 'none'")
    assert len(page.text.split()) < 5000


def test_whatever_files_and_notes_hold_is_escaped(tmp_path):
    tree = record("b1_marble")
    tree["run_1"].attrs["reasons"] = json.dumps([["ok", "hostile", HOSTILE]])
    line = dict.fromkeys(("file", "laser", "note", "reason"), HOSTILE)
    line |= {"test": "b1_marble", "block": "b1", "foundation": "marble"}
    label = {"b1": {"label": HOSTILE, "height_m": 0.28}}
    changes = {"title": HOSTILE, "summary": HOSTILE, "records": [line], "blocks": label, "license": HOSTILE}
    page = make(tmp_path, ([tree], [fits(tree)]), figures=[(HOSTILE, tmp_path / "image.png")], **changes)
    assert page.html.count("<script>alert") == 0
    assert page.text.count("alert(1)") > 5


def test_what_was_changed_at_the_desk_is_told(tmp_path):
    tree = record("b1_marble")
    change = Change("2026-01-01 10:00", "Ann", "ann", "b1_marble", "exclude", "", "2", "wobbled")
    page = make(tmp_path, ([tree], [fits(tree)]), by_hand=[change])
    assert "wobbled (the CSV holds something else by now)" in page.text


def test_what_is_cited_has_its_entry_and_no_more(folder, page):
    text, bib = ((folder / f"methods.{suffix}").read_text(encoding="utf-8") for suffix in ("md", "bib"))
    cited = set(re.findall(r"@(\w+)", text.rpartition("\n\n")[0]))
    assert cited == set(ENTRY.findall(bib))
    assert {"newville2014", "spanos2017", "housner1963"} <= cited
    for key, known in REFERENCES.items():
        assert ENTRY.fullmatch(known.entry) and re.fullmatch(r"10\.\d{4,9}/\S+", known.doi), key
    assert "sampled at 950 Hz" in text and "Gravity: 9.81 m/s²." in text


def test_durations_are_not_compared_where_blocks_were_released_from_unlike_angles(tables):
    runs, others = tables["runs"].copy(), (tables["choice"], tables["populations"], {})
    assert not any("rock longest" in each for each in limits(runs, *others))
    runs.loc[runs["foundation"] == "mat", "theta0_deg"] *= 1.3
    assert any("rock longest" in each for each in limits(runs, *others))


@pytest.mark.parametrize(("off", "told"), [(1.0, 0), (1.3, 1)])
def test_a_k_that_depends_on_which_possible_law_is_meant_is_told(tables, off, told):
    choice, means = tables["choice"].copy(), tables["populations"].copy()
    choice["status"] = choice["model"].map({"winkler": "selected", "hunt_crossley": "also_possible"})
    is_k = (means["parameter"] == "k") & (means["foundation"] == "mat")
    means.loc[is_k, ["mean", "u_total"]] = 1e6, 1e5
    means.loc[is_k & (means["model"] == "hunt_crossley"), "mean"] *= off
    found = [each for each in limits(tables["runs"], choice, means, {"mat": "Mat"}) if "Mat: k" in each]
    assert len(found) == told and all("30 %" in each for each in found)
