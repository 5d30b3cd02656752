"""The report of the shipped campaign in a browser: Debian's chromium, headless."""

import io
import os
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

HOUSNER = (0xD5, 0x5E, 0x00)


@pytest.fixture(scope="session")
def report(request):
    """The report's file; FREEROCK_REPORT names one to try without an analysis."""
    given = os.environ.get("FREEROCK_REPORT")
    return Path(given) if given else request.getfixturevalue("palermo") / "report.html"


@pytest.fixture
def page(browser, report):
    """The report, opened from disk; no request but for the file itself, and no complaint on the console."""
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    requests, complaints = [], []
    page.on("request", lambda request: requests.append(request.url))
    page.on("console", lambda told: complaints.append(told.text) if told.type != "info" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(report.as_uri())
    yield page
    assert [url for url in requests if not url.startswith(("data:", "blob:"))] == [report.as_uri()]
    assert complaints == []
    page.close()


def opened(page, number=0):
    """The section of a run, opened, with its charts drawn."""
    run = page.locator("details.run").nth(number)
    run.locator("summary").click()
    run.locator(".bk-Figure").nth(3).wait_for()
    page.wait_for_function("Bokeh.documents.every(each => each.is_idle)")
    return run


def ink(chart, colour):
    """Pixels of a colour in a chart."""
    image = np.array(Image.open(io.BytesIO(chart.screenshot())).convert("RGB")).astype(int)
    return int((np.abs(image - colour).max(axis=-1) < 30).sum())


def window(run):
    """Time window of a run in its fields [s]."""
    return [float(field.input_value()) for field in run.locator("input[type=number]").all()]


def test_charts_are_drawn_when_a_run_is_opened(page):
    assert page.locator(".bk-Figure").count() == 0
    run = opened(page)
    assert run.locator(".bk-Figure").count() == 4
    assert run.locator("input[type=checkbox]").count() >= 4


def test_a_model_is_switched_off_and_on(page):
    run = opened(page, 6)  # of a block that Housner's model keeps rocking
    motion = run.locator(".motion")
    drawn = ink(motion, HOUSNER)
    assert drawn > 300
    box = run.get_by_role("checkbox", name="Housner")
    box.focus()
    page.keyboard.press("Space")
    page.wait_for_timeout(300)
    assert ink(motion, HOUSNER) == 0
    assert ink(run.locator(".residual"), HOUSNER) == 0
    page.keyboard.press("Space")
    page.wait_for_timeout(300)
    assert ink(motion, HOUSNER) == pytest.approx(drawn, rel=0.05)


def test_a_dragged_box_zooms_all_charts_over_time(page):
    run = opened(page)
    motion, residual = run.locator(".motion"), run.locator(".residual")
    whole, before = window(run), residual.screenshot()
    motion.scroll_into_view_if_needed()
    box = motion.bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.3 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.7 * box["height"], steps=5)
    page.mouse.up()
    page.wait_for_timeout(300)
    start, end = window(run)
    assert whole[0] < start < end < whole[1]
    assert end - start == pytest.approx(0.2 * whole[1], rel=0.3)
    assert residual.screenshot() != before
    run.get_by_role("button", name="whole run").click()
    assert window(run) == whole


def test_the_time_window_is_set_by_keyboard(page):
    run = opened(page)
    end = run.get_by_label("to / s")
    end.fill("1.5")
    end.press("Enter")
    page.wait_for_timeout(200)
    assert window(run) == [0.0, 1.5]
    assert page.url.endswith("report.html")


def test_every_row_of_every_table_leads_to_its_run_or_record(page):
    stray = page.evaluate(
        """() => [...document.querySelectorAll("table.sorts tbody tr")].filter(row => {
            const link = row.querySelector("a[href^='#']");
            return !link || !document.getElementById(link.getAttribute("href").slice(1));
        }).map(row => row.textContent)"""
    )
    assert stray == []
    assert page.locator("table.sorts tbody tr").count() > 80
    page.locator("#overview table").first.locator("tbody tr").nth(4).get_by_role("link").click()
    page.locator("#run-config1_aerstop-2[open] .bk-Figure").first.wait_for()


def test_a_number_of_table_2_is_two_clicks_from_file_samples_and_settings(page):
    table = page.locator("figure.table", has_text="Table 2.")
    table.locator("tr", has_text="Hunt").first.get_by_role("link").click()
    record = page.locator(".record:target")
    assert "raw/palermo_virtual/config1_marble.tdms" in record.inner_text()
    assert len(record.locator("dd.hash").first.inner_text()) == 64
    record.get_by_role("link", name="fits").click()
    assert page.locator("#config-fits dt", has_text="debonding").is_visible()


def test_tables_sort(page):
    table = page.locator("#overview table").first
    head = table.get_by_role("button", name="Duration / s")
    for sign in (1, -1):
        head.press("Enter")
        column = [float(text) for text in table.locator("tbody td:nth-child(8)").all_inner_texts()]
        assert column == sorted(column, reverse=sign < 0)
    assert head.locator("..").get_attribute("aria-sort") == "descending"


WORDS = "element => element.innerText.trim().split(/\\s+/).length"


def test_the_page_is_read_in_one_sitting(page):
    """At most 3 000 words before the appendix and 8 000 in all, with the details of all runs opened."""
    page.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
    words = page.locator("body").evaluate(WORDS)
    assert words - page.locator("#appendix").evaluate(WORDS) < 3000 and words < 8000
    assert page.locator("main > section:not(#appendix) figure.table").count() <= 6


def test_the_page_fits_a_telephone(page):
    page.set_viewport_size({"width": 390, "height": 844})
    opened(page)
    assert page.evaluate("document.documentElement.scrollWidth") == 390


SIDEWAYS = """element => [element, ...element.querySelectorAll(".scroll")].filter(each =>
    each.scrollWidth > each.clientWidth + 1 || each.getBoundingClientRect().right > innerWidth).length"""


@pytest.mark.parametrize("width", [1280, 390])
def test_findings_key_figure_and_table_2_need_no_sideways_scroll(page, width):
    page.set_viewport_size({"width": width, "height": 900})
    findings = page.locator("#findings")
    assert findings.locator("dt").count() == 7
    assert findings.locator("svg.key").bounding_box()["width"] > 0.85 * min(width, 500)
    table = page.locator("figure.table", has_text="Table 2.")
    assert findings.evaluate(SIDEWAYS) == table.evaluate(SIDEWAYS) == 0
    assert table.get_by_text("·10⁶", exact=False).first.is_visible()


def test_no_table_needs_a_sideways_scroll_at_1200_pixels(page):
    page.set_viewport_size({"width": 1200, "height": 900})
    page.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
    wide = """() => [...document.querySelectorAll(".scroll")].filter(each =>
        each.scrollWidth > each.clientWidth + 1).map(each => each.getAttribute("aria-label"))"""
    assert page.evaluate(wide) == []


def test_the_first_screen_holds_the_findings_and_the_figure(page):
    assert page.locator("#findings .verdicts").bounding_box()["y"] < 900
    box = page.locator("#findings svg.key").bounding_box()
    assert box["y"] + box["height"] < 900


def test_a_print_has_eight_pages_before_the_appendix_and_cuts_no_table(page):
    page.add_style_tag(content="#appendix { display: none; }")
    printed = page.pdf(prefer_css_page_size=True)
    assert 3 < len(re.findall(rb"/Type\s*/Page\b", printed)) <= 8
    page.set_viewport_size({"width": 680, "height": 900})  # of a sheet of A4 without its margins, 18 cm
    page.emulate_media(media="print")
    wide = page.locator("main > section table").evaluate_all(
        "tables => tables.filter(each => each.scrollWidth > 681).map(each => each.scrollWidth)"
    )
    assert wide == []
