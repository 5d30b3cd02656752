import json
import re

import pytest
from fabricated import campaign, failed_record, fits, record
from reported import BLOCKS, make

from freerock.tables.number_text import quantity
from freerock.tables.populations import populations_table
from freerock.tables.printed_tables import table1_text, table2_text, table3_text
from freerock.tables.summary import table1, table2, table3
from freerock.tables.tidy_tables import choice_table, epsilon_table, parameters_table

HOSTILE = "<script>alert(1)</script>&\"'"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return make(tmp_path_factory.mktemp("report"), campaign())


def test_the_evidence_knows_the_fits_that_may_not_be_used(tmp_path, monkeypatch):
    seen, tree = [], record()
    monkeypatch.setattr("freerock.report.page.scenes_of", lambda *given: seen.append(given[-1]) or [])
    make(tmp_path, ([tree], [fits(tree, failed=("winkler",))]))
    assert seen == [{("b1_marble", run, "winkler") for run in "12"}]


def test_report_needs_nothing_from_outside(page):
    assert not [tag for tag, _ in page.tags if tag in ("link", "iframe")]
    assert not [attrs for tag, attrs in page.tags if tag == "script" and "src" in attrs]
    sources = [attrs[key] for _, attrs in page.tags for key in ("src", "href") if key in attrs]
    assert sources
    assert all(
        re.match(r"#|data:image/png;base64,|figures/qc\.png$|image\.pdf$", source) for source in sources
    )
    (policy,) = [attrs["content"] for _, attrs in page.tags if attrs.get("http-equiv")]
    assert policy.startswith("default-src 'none'")


def test_report_escapes_whatever_files_and_notes_hold(tmp_path):
    tree = record("b1_marble")
    tree["run_1"].attrs["reasons"] = json.dumps([["ok", "hostile", HOSTILE]])
    line = dict.fromkeys(("file", "laser", "note", "reason"), HOSTILE)
    line |= {"test": "b1_marble", "block": "b1", "foundation": "marble"}
    label = {"b1": {"label": HOSTILE, "height_m": 0.28}}
    changes = {"title": HOSTILE, "summary": HOSTILE, "records": [line], "blocks": label, "license": HOSTILE}
    page = make(tmp_path, ([tree], [fits(tree)]), figures=[(HOSTILE, tmp_path / "image.png")], **changes)
    assert page.html.count("<script>alert") == 0
    assert page.text.count("alert(1)") > 8


def test_report_shows_every_run_with_verdict_and_reasons(page):
    assert "5 records with 9 free-rocking runs; verdicts: 7 ok, 2 warn, 1 fail." in page.text
    assert re.search(r'<span class="excluded">\w+, excluded</span>', page.html)
    assert not re.search(r'class="(ok|warn)">\w+, excluded', page.html)
    assert "4 zero crossings, 4 with r" in page.text
    assert "1 record could not be processed" in page.text
    assert "the block slid & turned <1°" in page.text
    assert "the file is truncated; record it again" in page.text
    assert "Soft mat" in page.text


def test_every_row_of_every_table_leads_to_its_run_or_record(page):
    places = {attrs["id"] for _, attrs in page.tags if "id" in attrs}
    links = {attrs["href"][1:] for _, attrs in page.tags if attrs.get("href", "").startswith("#")}
    assert links <= places
    assert {"run-b1_marble-1", "run-b1_marble-2", "run-b1_marble-3", "record-b1_broken"} <= links
    tables = re.findall(r'<table class="sorts">.*?<tbody>(.*?)</tbody>', page.html, re.S)
    assert len(tables) == 9
    for row in "".join(tables).split("<tr>")[1:]:
        assert re.search('href="#(run|record|config|evidence)-', row)


def test_report_of_a_campaign_in_which_every_record_failed(tmp_path):
    broken = failed_record()
    page = make(tmp_path, ([broken], [fits(broken)]))
    assert "1 record with 0 free-rocking runs; verdicts: 1 fail." in page.text
    assert not re.search(r"\bnan\b", page.text)
    assert (
        "Table 2. Identified parameters, record by record, of the model selected for it: none." in page.text
    )
    assert "Uncertainty budget: none." in page.text
    assert not re.search(r"<tbody>\s*</tbody>", page.html)


def test_same_report_same_bytes_and_nothing_half_written(tmp_path):
    make(tmp_path, campaign())
    first = (tmp_path / "report.html").read_bytes()
    make(tmp_path, campaign())
    assert (tmp_path / "report.html").read_bytes() == first
    with pytest.raises(FileNotFoundError):
        make(tmp_path, campaign(), figures=[("Missing", tmp_path / "missing.png")])
    assert (tmp_path / "report.html").read_bytes() == first


def test_numbers_of_the_report_are_those_of_the_printed_tables(page):
    records, fitted = campaign()
    parameters, epsilon, choice = parameters_table(fitted), epsilon_table(fitted), choice_table(fitted)
    every = table2(populations_table(parameters), parameters, choice=choice)
    for caption, text, head in (
        ("Table 2.", table2_text(every[every["selected"]]), "Identified"),
        ("Table 3.", table3_text(table3(epsilon, choice=choice)), "ε_θ / %"),
        ("Parameters of other laws", table2_text(every[~every["selected"]]), "Identified"),
    ):
        body = re.search(rf"{caption}.*?<tbody>(.*?)</tbody>", page.html, re.S)[1]
        rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in body.split("<tr>")[1:]]
        printed = [cell for cell in text[head] if cell]
        column = 3 + [name for name in text if name != "Foundation"].index(head)
        assert [row[column] for row in rows] == printed
    body = re.search(r"Discrepancy ε.*? of each law.*?<tbody>(.*?)</tbody>", page.html, re.S)[1]
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row)[3:] for row in body.split("<tr>")[1:]]
    third = table3(epsilon, choice=choice)
    assert len(rows) == third["test"].nunique()
    medians = [quantity(100 * each) for each in third["epsilon_theta"]]
    assert [re.sub(r" [†[].*", "", cell) for row in rows for cell in row] == medians
    block = re.search(r"Table 1..*?<tbody>(.*?)</tbody>", page.html, re.S)[1].split("<tr>")[1]
    cells = [re.sub("<.*?>", "", cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", block)]
    assert cells[1:-1] == table1_text(table1(records, BLOCKS))["b1"].tolist()
