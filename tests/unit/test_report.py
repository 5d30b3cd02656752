import base64
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from fabricated import campaign, failed_record, fits, record
from matplotlib.image import imsave

from freerock.config.campaign import load_campaign
from freerock.models.block import Block
from freerock.report.charts import BINS, MISSING, packed, run_curves
from freerock.report.page import write_report
from freerock.report.records import charted
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.paper import PUBLISHED_NOTE
from freerock.tables.restitution import restitution_comparison
from freerock.tables.summary import table1, table2, table3
from freerock.tables.tidy import parameters_table, restitution_table, runs_table, tidy_tables

BLOCKS = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
VOID = {"img", "meta", "br", "hr", "link", "input"}
SHIPPED = Path(__file__).parents[2] / "config/campaigns/palermo_virtual.yaml"
HOSTILE = "<script>alert(1)</script>&\"'"


class Outline(HTMLParser):
    """Tags, attributes and text of a page; complains about tags that do not pair."""

    def __init__(self, html):
        super().__init__()
        self.html, self.open, self.tags, self.words, self.scripts = html, [], [], [], []
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID and not self.get_starttag_text().endswith("/>"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ["script"]:
            self.scripts.append(data)
        elif self.open[-1:] != ["style"]:
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def settings(trees, **changes):
    """The shipped campaign's section, for made-up records."""
    config = load_campaign(SHIPPED).model_dump(mode="json")
    shape = {"height_m": 0.28, "width_m": 0.07, "mass_kg": 5.84, "release_angle_deg": 10.0}
    names = [tree.attrs["test"] for tree in trees]
    line = dict.fromkeys(("channel", "exclude", "override", "reason", "note"), "") | {"laser": "at_200mm"}
    config |= {
        "title": "Marble & <mats>",
        "summary": "Two blocks.",
        "raw": "raw",
        "blocks": {"b1": {**shape, "label": "Slender"}, "b2": {**shape, "label": "Squat"}},
        "foundations": {"marble": {"label": "Marble"}, "mat": {"label": "Soft mat"}},
        "records": [line | {"test": test, "file": f"{test}.tdms"} for test in names],
    }
    return config | changes


def make(folder, datasets, *, shapes=BLOCKS, figures=None, **changes):
    records, fitted = datasets
    pairs = {pair[0].attrs["test"]: pair for pair in zip(records, fitted, strict=True)}
    image = folder / "image.png"
    imsave(image, np.zeros((24, 30, 3)))
    tidy = tidy_tables(records, fitted)
    frames = {name: tidy[name] for name in ("runs", "choice")}
    known = (tidy[name] for name in ("runs", "parameters", "restitution"))
    frames["restitution_comparison"] = restitution_comparison(*known, shapes)
    frames |= {"table1": table1(records, shapes), "table2": table2(tidy["parameters"])}
    frames["table3"] = table3(tidy["epsilon"])
    for name, frame in frames.items():
        write_csv(frame, folder / f"{name}.csv")
    write_report(
        folder / "report.html",
        provenance={
            "inputs": {"raw/b1_marble.tdms": "0a1b"},
            "config": settings(records, **changes),
            "software": {"numpy": "2.0"},
            "git": "abc-dirty",
        },
        tables={name: read_csv(folder / f"{name}.csv") for name in frames},
        blocks=shapes,
        opened=lambda test, samples: pairs[test],
        figures=[("Figure 2", image)] if figures is None else figures,
        pages={records[0].attrs["test"]: folder / "figures/qc.png"},
    )
    return Outline((folder / "report.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return make(tmp_path_factory.mktemp("report"), campaign())


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
    line = dict.fromkeys(("file", "laser", "note", "reason"), HOSTILE) | {"test": "b1_marble"}
    label = {"b1": {"label": HOSTILE, "height_m": 0.28}}
    changes = {"title": HOSTILE, "summary": HOSTILE, "records": [line], "blocks": label, "license": HOSTILE}
    page = make(tmp_path, ([tree], [fits(tree)]), figures=[(HOSTILE, tmp_path / "image.png")], **changes)
    assert page.html.count("<script>alert") == 0
    assert page.text.count("alert(1)") > 8


def test_report_shows_every_run_with_verdict_and_reasons(page):
    assert "5 records with 9 free-rocking runs; verdicts: 7 ok, 2 warn, 1 fail." in page.text
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
    assert len(tables) == 6
    for row in "".join(tables).split("<tr>")[1:]:
        assert re.search('href="#(run|record|config)-', row)


def test_a_number_of_table_2_leads_to_file_samples_and_settings(page):
    (row,) = re.findall(r"<tr>(?:(?!</tr>).)*b1_marble(?:(?!</tr>).)*0.9570 ± 0.0012.*?</tr>", page.html)[:1]
    target = re.search('href="#(record-b1_marble)"', row)[1]
    section = re.search(f'<section class="record" id="{target}">(.*?)</section>', page.html, re.S)[1]
    assert "raw/b1_marble.tdms" in section and "0a1b" in section
    assert "samples 404 to 1200" in section
    assert {"config-blocks-b1", "config-lasers-at_200mm", "config-processing", "config-fits"} <= set(
        re.findall('href="#([^"]*)"', section)
    )


def test_curves_of_a_run_hold_its_highest_and_lowest_angle():
    tree = record()
    run = fits(tree)["run_1"]
    curves = run_curves(tree, 1, run)
    whole = np.frombuffer(base64.b64decode(curves["theta"]["measured"]["data"]), "<i2").astype(float)
    theta = np.where(whole == MISSING, np.nan, whole) * curves["theta"]["measured"]["scale"]
    measured = np.degrees(run["theta"].values)
    assert len(theta) <= 2 * BINS
    assert np.nanmax(theta) == pytest.approx(np.nanmax(measured), abs=1e-3)
    assert np.nanmin(theta) == pytest.approx(np.nanmin(measured), abs=1e-3)
    assert (
        list(curves["theta"]) == list(curves["rate"]) == ["measured", "housner", "winkler", "hunt_crossley"]
    )
    assert [len(each) for each in curves["impacts"].values()] == [4] * 4
    assert curves["impacts"]["measured"][0][:2] == pytest.approx([0.3, 0.94])


def test_rate_of_a_model_is_the_derivative_of_its_angle():
    tree = record()
    run = fits(tree)["run_1"]
    rate = run_curves(tree, 1, run)["rate"]["housner"]
    peak = np.abs(np.frombuffer(base64.b64decode(rate["data"]), "<i2")).max() * rate["scale"]
    model = np.degrees(np.gradient(run["housner"]["theta_model"].values, run["time"].values))
    assert peak == pytest.approx(np.abs(model).max(), rel=0.02)


def test_a_run_without_fits_has_its_measured_curve_alone():
    assert list(run_curves(record(), 3)["theta"]) == ["measured"]


def test_packing_keeps_gaps_and_five_digits():
    values = np.array([1.0, np.nan, -20.0, 0.001])
    got = packed(values)
    whole = np.frombuffer(base64.b64decode(got["data"]), "<i2")
    assert whole[1] == MISSING
    np.testing.assert_allclose(whole[[0, 2, 3]] * got["scale"], values[[0, 2, 3]], atol=20 / 32000)
    assert packed(np.zeros(2))["scale"] == 1.0


def test_charts_are_for_the_worst_runs_then_for_the_first_of_each_record():
    runs = runs_table(campaign()[0])
    assert charted(runs, 1) == {("b1_marble", 3)}
    some = charted(runs, 4)
    assert {("b1_marble", 3), ("b1_mat", 3), ("b1_marble", 1), ("b1_mat", 1)} == some
    assert len(charted(runs, 100)) == 9


def test_runs_beyond_the_limit_are_told_and_linked(tmp_path, monkeypatch):
    monkeypatch.setattr("freerock.report.page.MOST_CHARTED", 2)
    page = make(tmp_path, campaign())
    assert page.html.count('class="charts"') == 2
    assert "2 of the 9 runs have charts here" in page.text
    assert "No charts here: see the quality page" in page.text


def test_charts_take_their_looks_from_the_figures(page):
    (styles,) = [json.loads(each) for each in page.scripts if each.startswith('{"mark"')]
    assert styles["mark"] == " – simulated"
    assert styles["lines"]["housner"]["color"] == "#d55e00"
    dashes = [tuple(line["dash"]) for line in styles["lines"].values()]
    assert len(set(dashes[1:])) == len(dashes) - 1


def test_images_have_size_and_description(page):
    (image,) = [attrs for tag, attrs in page.tags if tag == "img"]
    assert (image["width"], image["height"], image["alt"]) == ("30", "24", "Figure 2")


def test_figures_beyond_the_limit_are_linked(tmp_path, monkeypatch):
    monkeypatch.setattr("freerock.report.page.MOST_FIGURES", 0)
    page = make(tmp_path, campaign())
    assert not [tag for tag, _ in page.tags if tag == "img"]
    assert "image.pdf" in page.text


def test_report_says_what_is_simulated(page, tmp_path):
    assert "Simulated records." in page.text
    measured = make(tmp_path, campaign(), origin="measured")
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
    assert "every valid sample of θ(t)" in page.text


def test_report_shows_nested_provenance(page):
    assert "raw/b1_marble.tdms 0a1b" in page.text
    assert "free.hunt_crossley theta0, t0" in page.text
    assert "git abc-dirty" in page.text
    assert "state of the code: abc-dirty" in page.text


def test_first_impact_is_compared_with_that_of_a_rigid_block():
    records = [record(n_runs=1, theta0_deg=9.9)]
    fitted = [fits(tree) for tree in records]
    tables = (runs_table(records), parameters_table(fitted), restitution_table(records, fitted))
    row = restitution_comparison(*tables, BLOCKS).iloc[0]
    assert row["rigid_s"] == pytest.approx(0.268884, abs=1e-6)  # quarter period of this block from 10°
    assert row["first_impact_s"] == pytest.approx(0.3)
    assert row["r_fitted"] == pytest.approx(0.957)
    assert (row["r_first"], row["r_median"]) == pytest.approx((0.94, 0.9445))
    assert (row["r_low"], row["r_high"]) == pytest.approx((0.94, 0.949))


@pytest.mark.parametrize("run", [None, str])  # numbers, and texts as of the written tables
def test_a_run_without_impacts_is_in_neither_mean(run):
    records = [record(n_runs=2, theta0_deg=9.9)]
    fitted = [fits(tree) for tree in records]
    restitution = restitution_table(records, fitted).query("run == 1")
    tables = [runs_table(records), parameters_table(fitted), restitution]
    if run:
        tables = [table.astype({"run": run}) for table in tables]
    row = restitution_comparison(*tables, BLOCKS).iloc[0]
    assert row["rigid_s"] == pytest.approx(0.268884, abs=1e-6)
    assert row["first_impact_s"] == pytest.approx(0.3)


def test_each_of_two_lasers_leads_to_its_settings(tmp_path):
    trees = campaign()[0]
    lines = [line | {"laser": "at_200mm; at_100mm"} for line in settings(trees)["records"]]
    page = make(tmp_path, campaign(), records=lines)
    places = {attrs["id"] for _, attrs in page.tags if "id" in attrs}
    links = {attrs["href"][1:] for _, attrs in page.tags if attrs.get("href", "").startswith("#")}
    assert {"config-lasers-at_200mm", "config-lasers-at_100mm"} <= links <= places


def test_report_says_how_a_held_angle_is_read(page):
    assert "held at an angle, read over the last 1 s, is let go" in page.text


def test_report_says_whose_the_published_values_are(page, tmp_path):
    told = PUBLISHED_NOTE.format(doi="10.1016/j.proeng.2017.09.024")
    assert page.text.count(told) == 2
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


def test_fits_of_every_run_are_listed(page):
    assert page.html.count("<td>closed form</td>") == 4 + 7
    assert page.text.count("k = (6.880 ± 0.012)·10⁶ N m⁻²") == 2 * (4 + 7)


def test_report_of_a_campaign_in_which_every_record_failed(tmp_path):
    broken = failed_record()
    page = make(tmp_path, ([broken], [fits(broken)]))
    assert "1 record with 0 free-rocking runs; verdicts: 1 fail." in page.text
    assert not re.search(r"\bnan\b", page.text)


def test_same_report_same_bytes_and_nothing_half_written(tmp_path):
    make(tmp_path, campaign())
    first = (tmp_path / "report.html").read_bytes()
    make(tmp_path, campaign())
    assert (tmp_path / "report.html").read_bytes() == first
    with pytest.raises(FileNotFoundError):
        make(tmp_path, campaign(), figures=[("Missing", tmp_path / "missing.png")])
    assert (tmp_path / "report.html").read_bytes() == first
