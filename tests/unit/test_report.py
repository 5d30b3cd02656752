import re
from html.parser import HTMLParser

import numpy as np
import pytest
from fabricated import campaign, failed_record, fits, record
from matplotlib.image import imsave

from freerock.models.block import Block
from freerock.report import fit_settings, restitution_comparison, write_report
from freerock.tables import (
    choice_table,
    epsilon_table,
    parameters_table,
    read_csv,
    restitution_table,
    runs_table,
    table2,
    table2_text,
    write_csv,
)

BLOCKS = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
VOID = {"img", "meta", "br", "hr", "link", "input"}


class Outline(HTMLParser):
    """Tags, attributes and text of a page; complains about tags that do not pair."""

    def __init__(self, html):
        super().__init__()
        self.html, self.open, self.tags, self.words = html, [], [], []
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
        if self.open[-1:] != ["style"]:
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def make(folder, datasets, **changes):
    records, fitted = datasets
    image = folder / "image.png"
    imsave(image, np.zeros((24, 30, 3)))
    parameters = parameters_table(fitted)
    table = table2(parameters)
    frames = {
        "runs": runs_table(records),
        "parameters": parameters,
        "epsilon": epsilon_table(fitted),
        "choice": choice_table(fitted),
        "restitution": restitution_table(records, fitted),
    }
    for name, frame in frames.items():
        write_csv(frame, folder / f"{name}.csv")
        frames[name] = read_csv(folder / f"{name}.csv")
    given = {
        "title": "Marble & <mats>",
        "summary": "Two blocks.",
        "origin": "simulated",
        **frames,
        "fits": fitted,
        "blocks": BLOCKS,
        "tables": [("Table 2", table2_text(table), ["A note."])] if len(table) else [],
        "figures": [("Figure 2", image)],
        "pages": {records[0].attrs["test"]: image},
        "labels": {"mat": "Soft mat"},
        "provenance": {
            "inputs": {"raw/b1.tdms": "0a1b"},
            "config": {"fits": ["r", 1.5], "empty": "", "records": [{"test": "b1"}]},
        },
    }
    write_report(folder / "report.html", **given | changes)
    return Outline((folder / "report.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return make(tmp_path_factory.mktemp("report"), campaign())


def test_report_needs_nothing_from_outside(page):
    assert not [tag for tag, _ in page.tags if tag in ("script", "link", "iframe")]
    sources = [attrs[key] for _, attrs in page.tags for key in ("src", "href") if key in attrs]
    assert sources
    assert all(re.match(r"#|data:image/png;base64,", source) for source in sources)
    assert "url(" not in page.html


def test_report_escapes_what_it_is_given(page):
    assert "Marble & <mats>" in page.text
    assert not [tag for tag, _ in page.tags if tag == "mats"]


def test_report_shows_every_run_with_verdict_and_reasons(page):
    assert "5 records with 9 free-rocking runs; verdicts: 7 ok, 2 warn, 1 fail." in page.text
    assert "1 record could not be processed" in page.text
    assert "the block slid & turned <1°" in page.text
    assert "the file is truncated; record it again" in page.text
    assert "Soft mat" in page.text


def test_links_lead_to_a_place_on_the_page(page):
    places = {attrs["id"] for _, attrs in page.tags if "id" in attrs}
    links = {attrs["href"][1:] for _, attrs in page.tags if attrs.get("href", "").startswith("#")}
    assert links <= places
    assert {"qc-b1_marble-1", "qc-b1_marble-2", "qc-b1_marble-3"} <= links


def test_images_have_size_and_description(page):
    images = [attrs for tag, attrs in page.tags if tag in ("img", "image")]
    assert len(images) == 2
    assert all((image["width"], image["height"]) == ("30", "24") for image in images)
    described = [attrs for tag, attrs in page.tags if tag == "img" or attrs.get("role") == "img"]
    assert all(attrs.get("alt") or attrs.get("aria-label") for attrs in described)


def test_each_run_shows_its_own_part_of_the_stacked_pages(page):
    windows = [attrs["viewbox"] for _, attrs in page.tags if "viewbox" in attrs]
    assert windows == ["0 0 30 8", "0 8 30 8", "0 16 30 8"]


def test_report_says_what_is_simulated(page, tmp_path):
    assert "Simulated records." in page.text
    assert "imulated" not in make(tmp_path, campaign(), origin="measured").text


def test_report_says_which_debonding_rule(page, tmp_path):
    assert "Debonding rule “geometric”" in page.text
    other = make(tmp_path, campaign(), debonding="tensionless").text
    assert "and the foundation pushes" in other
    assert "dashpot may pull" not in other


def test_report_states_tolerance_error_and_sampling(page):
    assert "relative tolerance of 1e-07 to 1e-06" in page.text
    assert "by more than 0.40 % of its standard error" in page.text
    assert "every valid sample of θ(t)" in page.text


def test_report_shows_nested_provenance(page):
    assert "raw/b1.tdms 0a1b" in page.text
    assert "config fits r, 1.5 records.1.test b1" in page.text


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


def test_report_tells_how_late_the_first_impact_is(page):
    told = re.search(r"from ([\d.]+) % later to ([\d.]+) % later than .* in (\d) of (\d) records", page.text)
    assert float(told[1]) < 100 * (0.3 / 0.268884 - 1) < float(told[2])
    assert told.groups()[2:] == ("4", "4")
    assert "Where it comes earlier" not in page.text


def test_report_tells_that_a_first_impact_is_early(tmp_path):
    stiff = {name: Block(4 * block.height_m, 4 * block.width_m, 1.0) for name, block in BLOCKS.items()}
    page = make(tmp_path, campaign(), blocks=stiff)
    assert re.search(r"from [\d.]+ % earlier to [\d.]+ % earlier", page.text)
    assert "Where it comes earlier" in page.text


def test_settings_of_every_fit_are_listed():
    settings = fit_settings([fits(record(n_runs=2))])
    assert len(settings) == 9
    assert settings.groupby("model")["rtol"].first()["hunt_crossley"] == 1e-7


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
