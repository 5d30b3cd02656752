"""Settings of all tests, and the shipped campaign, analysed once for those that look at its products."""

import gc
import os
import shutil
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # as in the workflow's jobs; before numpy is imported

import pytest
from hypothesis import settings
from small_campaign import BLOCKS, MAT, ROOT, check_out, once

settings.register_profile("same every time", deadline=None, derandomize=True, max_examples=30)
settings.load_profile("same every time")

gc.disable()  # until all is collected: nothing of it is garbage, and looking takes a quarter of the time

SLOW = ("workflow", "browser", "docs", "bench", "cluster")  # folders: Snakemake, browsers, commands, studies


def pytest_itemcollected(item):
    """Mark what `make quick` leaves out."""
    inside = item.path.parent.name if item.path.is_relative_to(Path(__file__).parent) else ""
    if inside in SLOW:
        item.add_marker(pytest.mark.slow)


def pytest_collection_modifyitems(items):
    """Files with long tests first, so that of several processes none waits at the end."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return  # one process takes the files as they are named
    long = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in long)


def pytest_collection_finish():
    """What is there now stays; Python need not look through it again."""
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def palermo(tmp_path_factory):
    """The results of the shipped campaign, from record files to report."""

    def analyse(folder):
        checkout = check_out(folder)
        shutil.rmtree(checkout / "config")
        for part in ("config", "raw"):
            shutil.copytree(ROOT / part, checkout / part)
        for part in ("results/palermo_virtual", ".snakemake/metadata"):
            if (ROOT / part).is_dir():  # by `make`; what is of other code or settings is made again
                shutil.copytree(ROOT / part, checkout / part)
        done = checkout.snakemake()
        assert done.returncode == 0, done.stdout + done.stderr

    return once(tmp_path_factory, "palermo", analyse) / "results/palermo_virtual"


@pytest.fixture(scope="session")
def springs(tmp_path_factory):
    """The bench's second simulator, compiled by one process of this run of the tests and loaded by others."""
    from freerock_bench.springs import Motion, Scene

    scene = Scene(BLOCKS["squat"][0], MAT, True, 0.1)
    once(tmp_path_factory, "springs", lambda folder: Motion(scene, 1000.0, 0.01))


@pytest.fixture(scope="module")
def browser():
    """Debian's chromium, headless; skips where there is none."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if not chromium:
        pytest.skip("no chromium here: apt-get install chromium")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()
