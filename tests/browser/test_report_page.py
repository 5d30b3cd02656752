"""The report of the shipped campaign in a browser: Debian's chromium, headless."""

import io
import os
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


def test_tables_sort(page):
    table = page.locator("#overview table").first
    head = table.get_by_role("button", name="Duration / s")
    for sign in (1, -1):
        head.press("Enter")
        column = [float(text) for text in table.locator("tbody td:nth-child(8)").all_inner_texts()]
        assert column == sorted(column, reverse=sign < 0)
    assert head.locator("..").get_attribute("aria-sort") == "descending"


def test_the_page_fits_a_telephone(page):
    page.set_viewport_size({"width": 390, "height": 844})
    opened(page)
    assert page.evaluate("document.documentElement.scrollWidth") == 390


def test_no_table_needs_a_sideways_scroll_at_1200_pixels(page):
    page.set_viewport_size({"width": 1200, "height": 900})
    page.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
    wide = """() => [...document.querySelectorAll(".scroll")].filter(each =>
        each.scrollWidth > each.clientWidth + 1).map(each => each.getAttribute("aria-label"))"""
    assert page.evaluate(wide) == []
