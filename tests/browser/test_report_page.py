"""The report of the shipped campaign in a browser: Debian's chromium, headless."""

import os
from pathlib import Path

import pytest


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


def test_the_page_fits_a_telephone(page):
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") == 390


def test_no_table_needs_a_sideways_scroll_at_1200_pixels(page):
    page.set_viewport_size({"width": 1200, "height": 900})
    page.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
    wide = """() => [...document.querySelectorAll(".scroll")].filter(each =>
        each.scrollWidth > each.clientWidth + 1).map(each => each.getAttribute("aria-label"))"""
    assert page.evaluate(wide) == []
