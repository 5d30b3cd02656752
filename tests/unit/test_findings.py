"""The five lines of findings, of made-up campaigns: true sentences, and every number found again."""

import re

from fabricated import campaign, failed_record, fits, record
from found_again import found_again
from reported import make, tables_of

from freerock.report.findings import findings
from freerock.report.numbers import plain
from freerock.tables.csvfile import read_csv

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
    assert "2 records" in text["Shared by blocks"]
    assert "simulated" in text["Not to be concluded"]


def test_a_single_run(tmp_path):
    text = told(tmp_path, single())
    assert text["Tested"].startswith("1 simulated run in 1 record: Slender on Marble, released at 10.1°.")
    assert text["Explained by"].startswith("Hunt–Crossley explains the only run:")
    assert "one record" in text["Parameters"]
    assert "one run does not show the scatter between runs" in text["Parameters"]
    assert "Foundation" not in text
    assert text["Shared by blocks"] == "Not tested: each foundation carried one block only."
    assert "How much runs scatter" in text["Not to be concluded"]


def test_blocks_rock_longest_where_their_mean_time_is_longest(tmp_path):
    names = tables_of(tmp_path, campaign())
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    times = {("b1_marble", "1"): 5.0, ("b1_marble", "2"): 1.0, ("b1_mat", "1"): 4.0, ("b1_mat", "2"): 4.0}
    keys = zip(frames["runs"]["test"], frames["runs"]["run"], strict=True)
    frames["runs"]["duration_s"] = [times.get(key, 3.0) for key in keys]
    (found,) = (each for each in findings(frames, LABELS) if each.head == "Foundation")
    first = "Slender (h/b = 4.00) rocks longest on Soft mat: 4.00 s and 1.00 to 5.00 s on Marble."
    assert plain(found.sentences[0]) == first


def test_every_record_failed(tmp_path):
    broken = failed_record()
    text = told(tmp_path, ([broken], [fits(broken)]))
    assert text["Tested"] == "No run could be used: 1 simulated record of Slender on Marble."
    assert text["Explained by"] == "No law was fitted to any run."
    assert text["Parameters"] == "None, as no run was fitted."
    assert "k" not in text["Not to be concluded"].split()


def test_blocks_that_do_not_share_a_foundation_have_each_its_own_parameters(tmp_path, monkeypatch):
    names = tables_of(tmp_path, campaign())
    frames = {name: read_csv(tmp_path / f"{name}.csv") for name in names}
    frames["foundations"]["transfers"] = [False] * len(frames["foundations"])
    text = {each.head: " ".join(map(plain, each.sentences)) for each in findings(frames, LABELS)}
    each = r"k = \(6\.[\d]+ ± [\d.]+\)·10⁶ N m⁻² \(Slender\) and \(6\.[\d]+ ± [\d.]+\)·10⁶ N m⁻² \(Squat\)"
    assert re.search(f"Marble: {each}", text["Parameters"]) and "2 records" in text["Parameters"]
    assert "does not transfer to another block" in text["Shared by blocks"]
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
