import json
import re
from dataclasses import replace

import numpy as np
import pytest
from fabricated import campaign, failed_record, fits, record
from fabricated import fit as fabricated_fit
from matplotlib.image import imsave
from reported import BLOCKS, make, settings

from freerock.config.review_log import LOOKED_AT, Change
from freerock.models.block import Block
from freerock.tables.number_text import quantity
from freerock.tables.populations import populations_table
from freerock.tables.printed_tables import PUBLISHED_NOTE, table1_text, table2_text, table3_text
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


def test_heads_of_cards_have_words_where_no_index_can_be(page):
    """On a telephone heads of tables come from the style sheet, which draws no index."""
    assert (
        '::before { content: "discrepancy / %: "; }' in page.html
        and 'data-head="discrepancy / %"' in page.html
    )
    assert 'aria-label="Discrepancy of each law in per cent' in page.html
    assert not re.search(r'(content: |data-head=|aria-label=)"[^"]*(ε_θ|\bt_f\b)', page.html)


def test_the_first_impacts_are_those_on_foundations_that_yield(tmp_path, monkeypatch):
    laws = {"marble": "housner", "mat": "hunt_crossley"}
    trees = [record("b1_marble"), record("b1_mat", foundation="mat")]
    datasets = trees, [fits(tree) for tree in trees]
    assert "In this campaign the mean first impact" in make(tmp_path, datasets).text
    monkeypatch.setattr("freerock.report.page.laws_of_foundations", lambda choice: laws)
    text = make(tmp_path, datasets).text
    assert "On Soft mat the mean first impact" in text and "of 1 record." in text
    assert "On a compliant base the two differ." in text


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


def test_report_shows_what_was_changed_at_the_review_desk(tmp_path):
    tree = record("b1_marble")
    changes = [
        Change("2026-11-01T10:00:00+01:00", "anna", "b1_marble", "", "exclude", "", "2", "fell"),
        Change("2026-11-01T11:00:00+01:00", "anna", "b1_marble", "", "reason", "", HOSTILE, "fell"),
        Change("2026-11-01T12:00:00+01:00", "bert", "b1_marble", "1", LOOKED_AT, "", "yes", ""),
    ]
    page = make(tmp_path, ([tree], [fits(tree)]), by_hand=changes)
    table = page.text.partition("Changes at the review desk, newest first")[2].partition("freerock review")[0]
    assert table.index("11:00:00") < table.index("10:00:00")
    assert table.count("(the CSV holds something else by now)") == 2
    assert "Looked at: 1 of " in table and "runs, by bert." in table
    assert page.html.count("<script>alert") == 0


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


def test_a_number_of_table_2_leads_to_file_samples_and_settings(page):
    body = re.search(r"Table 2\..*?<tbody>(.*?)</tbody>", page.html, re.S)[1]
    row = next(row for row in body.split("<tr>") if "b1_marble" in row and "6.88" in row)
    target = re.search('href="#(record-b1_marble)"', row)[1]
    section = re.search(f'<section class="record" id="{target}">(.*?)</section>', page.html, re.S)[1]
    assert "raw/b1_marble.tdms" in section and "0a1b" in section
    assert "samples 404 to 1200" in section
    assert {"config-blocks-b1", "config-lasers-at_200mm", "config-processing", "config-fits"} <= set(
        re.findall('href="#([^"]*)"', section)
    )


def test_runs_beyond_the_limit_are_told_and_linked(tmp_path, monkeypatch):
    monkeypatch.setattr("freerock.report.page.MOST_CHARTED", 2)
    page = make(tmp_path, campaign())
    assert page.html.count('class="charts"') == 2
    assert "2 of the 9 runs have charts here" in page.text
    assert "No charts here: see the quality page" in page.text


def test_the_records_that_need_a_look_are_listed_and_the_tables_hold_all(tmp_path, monkeypatch):
    monkeypatch.setattr("freerock.report.page.MOST_LISTED", 2)
    page = make(tmp_path, campaign())
    rows = page.html.partition('id="overview"')[2].partition("</table>")[0]
    assert rows.count("<tr>") == 1 + 4  # the failed record, and the three runs of the next
    assert "b1_broken" in rows and "b1_marble" in rows and "b2_mat" not in rows
    assert set(re.findall('id="record-([^"]*)"', page.html)) == {"b1_broken", "b1_marble"}
    for name in ("table2", "table3", "runs", "budget", "restitution_comparison"):
        note = f"Listed: 2 of 5 records, those whose runs most need a look. All: tables/{name}.csv."
        assert note in page.text
        whole = (tmp_path / f"{name}.csv").read_text(encoding="utf-8")
        assert "b2_mat" in whole or name == "budget"
    places = {attrs["id"] for _, attrs in page.tags if "id" in attrs}
    links = {attrs["href"][1:] for _, attrs in page.tags if attrs.get("href", "").startswith("#")}
    assert links <= places
    assert "5 records with 9 free-rocking runs; verdicts: 7 ok, 2 warn, 1 fail." in page.text


def test_a_page_that_lists_every_record_does_not_say_so(page):
    assert "Listed:" not in page.text


def named(tree, test):
    """A dataset as that of another record."""
    other = tree.copy(deep=False)
    other.attrs = tree.attrs | {"test": test}
    return other


def test_a_record_that_is_not_listed_adds_little_to_the_page(tmp_path, monkeypatch):
    monkeypatch.setattr("freerock.report.page.MOST_LISTED", 6)
    monkeypatch.setattr("freerock.report.page.MOST_CHARTED", 1)
    tree = record()
    fitted = fits(tree)

    def size(n):
        trees = [named(tree, f"record_{i:03d}") for i in range(n)]
        make(tmp_path, (trees, [named(fitted, f"record_{i:03d}") for i in range(n)]))
        return (tmp_path / "report.html").stat().st_size

    few, more, most = map(size, (1, 2, 22))
    assert more - few > 4000  # listed
    assert (most - more) / 20 < 100  # of 600 records 60 kB


def test_charts_take_their_looks_from_the_figures(page):
    (styles,) = [json.loads(each) for each in page.scripts if each.startswith('{"mark"')]
    assert styles["mark"] == " – simulated"
    assert styles["lines"]["housner"]["color"] == "#d55e00"
    dashes = [tuple(line["dash"]) for line in styles["lines"].values()]
    assert len(set(dashes[1:])) == len(dashes) - 1


def test_indices_stand_below_the_line_and_in_no_name(tmp_path, monkeypatch):
    def fit(tree, model, *more):
        return replace(fabricated_fit(tree, model, *more), epsilon_holdout=2.0 if model == "housner" else 0.1)

    monkeypatch.setattr("fabricated.fit", fit)
    tree, told = named(record(), "mat_foam"), "Rotation\nε_θ up to t_f. Drawn: run 1 of mat_foam."
    fitted = named(fits(tree), "mat_foam")
    page = make(tmp_path, ([tree], [fitted]), figures=[(told, tmp_path / "image.png")])
    assert "ε<sub>θ</sub> up to t<sub>f</sub>. Drawn: run 1 of mat_foam." in page.html
    assert "Rejected, ε<sub>θ</sub>: " in page.html
    cells = re.findall(r"<td[^>]*>(.*?)</td>", page.html)
    assert not [cell for cell in cells if "ε_θ" in cell]


def test_images_have_size_and_description(page):
    (image,) = [attrs for tag, attrs in page.tags if tag == "img"]
    assert (image["width"], image["height"], image["alt"]) == ("30", "24", "Figure 1. Rotation")


def test_figures_beyond_the_limit_are_linked(tmp_path, monkeypatch):
    monkeypatch.setattr("freerock.report.page.MOST_FIGURES", 0)
    page = make(tmp_path, campaign())
    assert not [tag for tag, _ in page.tags if tag == "img"]
    assert "image.pdf" in page.text


def test_report_says_what_is_simulated(page, tmp_path):
    assert "Simulated records." in page.text
    tree = record("b1_marble", origin="measured")
    measured = make(tmp_path, ([tree], [fits(tree)]), origin="measured")
    assert "imulated" not in measured.text
    assert not any('"mark":" – simulated"' in each for each in measured.scripts)


def test_report_says_which_debonding_rule(page, tmp_path):
    assert "Debonding rule “geometric”" in page.text
    chosen = settings([])["fits"] | {"debonding": "tensionless"}
    other = make(tmp_path, campaign(), fits=chosen).text
    assert "and the foundation pushes" in other
    assert "dashpot may pull" not in other


def test_report_states_tolerance_error_and_sampling(page):
    assert "relative tolerance of 1e-07 to 1e-06" in page.text
    assert "by more than 0.40 % of its standard error" in page.text
    assert "The last step used every valid sample, averaged where that raises no standard error" in page.text


def test_report_shows_nested_provenance(page):
    assert "raw/b1_marble.tdms 0a1b" in page.text
    assert "free.hunt_crossley theta0, t0" in page.text
    assert "state of the code: abc-dirty" in page.text


def test_each_of_two_lasers_leads_to_its_settings(tmp_path):
    trees = campaign()[0]
    lines = [line | {"laser": "at_200mm; at_100mm"} for line in settings(trees)["records"]]
    page = make(tmp_path, campaign(), records=lines)
    places = {attrs["id"] for _, attrs in page.tags if "id" in attrs}
    links = {attrs["href"][1:] for _, attrs in page.tags if attrs.get("href", "").startswith("#")}
    assert {"config-lasers-at_200mm", "config-lasers-at_100mm"} <= links <= places


def test_report_says_how_a_held_angle_is_read(page):
    assert "The release angle was read over the last 1 s of the hold." in page.text


def test_report_says_whose_the_published_values_are(page, tmp_path):
    told = PUBLISHED_NOTE.format(doi="10.1016/j.proeng.2017.09.024")
    assert page.text.count(told) == 1  # below table 2
    assert "Published values: doi" not in make(tmp_path, campaign(), published=None).text


def test_report_tells_how_late_the_first_impact_is(page):
    told = re.search(r"from ([\d.]+) % later to ([\d.]+) % later than .* in (\d) of (\d) records", page.text)
    assert float(told[1]) < 100 * (0.3 / 0.268884 - 1) < float(told[2])
    assert told.groups()[2:] == ("4", "4")
    assert "Where it comes earlier" not in page.text


def test_report_tells_that_a_first_impact_is_early(tmp_path):
    stiff = {name: Block(4 * block.height_m, 4 * block.width_m, 1.0) for name, block in BLOCKS.items()}
    page = make(tmp_path, campaign(), shapes=stiff)
    assert re.search(r"from [\d.]+ % earlier to [\d.]+ % earlier", page.text)
    assert "Where it comes earlier" in page.text


def test_figures_are_numbered_in_the_order_of_the_page(tmp_path):
    given = [(name, tmp_path / f"{name}.png") for name in ("decay", "restitution", "backbone", "models")]
    for _, file in given:
        imsave(file, np.zeros((24, 30, 3)))
    page = make(tmp_path, campaign(), figures=given)
    told = ["Figure 1. models", "Figure 2. restitution", "Figure 3. decay", "Figure 4. backbone"]
    assert re.findall(r"<figcaption>(Figure \d\. \w+)", page.html) == told


def test_fits_of_every_run_are_listed(page):
    assert (
        page.text.count("k = (6.880 ± 0.012)·10⁶ N m⁻²") == page.html.count('class="table wordy fits"') == 7
    )
    assert page.html.count("Rejected, ε<sub>θ</sub>: ") == 7


def test_a_fitted_release_angle_is_printed_in_degrees_as_elsewhere(page):
    angles = re.findall(r"θ₀ = [\d.]+(?: ± [\d.]+)?(\S*)", page.text)
    assert angles and {each.rstrip(";,.") for each in angles} == {"°"}


def test_the_page_says_which_tables_have_numbers(page):
    assert re.findall(r"<figcaption>Table (\d)\.", page.html) == ["1", "2", "3"]
    assert "Table numbers are those of" in page.text


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


def test_a_channel_of_rotations_and_no_mains(tmp_path):
    shipped = settings([])
    sensor = shipped["lasers"]["at_200mm"] | {
        "beam": None,
        "position_m": None,
        "range_m": None,
        "units": "deg",
    }
    processing = shipped["processing"] | {"rotation": shipped["processing"]["rotation"] | {"mains_hz": None}}
    page = make(tmp_path, campaign(), lasers={"at_200mm": sensor}, processing=processing)
    assert "Sensor at_200mm: the channel holds the rotation itself, in deg." in page.text
    assert "mains frequency" not in page.text
    assert "Displacements were converted" not in page.text


def test_a_laser(tmp_path):
    page = make(tmp_path, campaign())
    assert "Laser at_200mm: horizontal beam at 0.2 m, range 0.1 m." in page.text
    assert "Sinusoids at the mains frequency (50 Hz)" in page.text


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


def test_single_runs_have_no_columns_of_how_runs_differ(page, tmp_path):
    one = record(n_runs=1)
    assert "Next run" in page.text
    assert "Next run" not in make(tmp_path, ([one], [fits(one)])).text
