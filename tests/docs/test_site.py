"""The site: built without warnings or the internet, with every page, public name, figure and command."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import freerock
from freerock.cli.subcommands import COMMANDS
from freerock_bench.site import LINK, linked

ROOT = Path(__file__).parents[2]


def build(folder, root=ROOT):
    command = [sys.executable, "-m", "freerock_bench.site", folder]
    return subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    done = build(folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert not done.stderr
    return folder


def test_every_page_is_there(site):
    for page in (ROOT / "docs").rglob("*.md"):
        assert (site / page.relative_to(ROOT / "docs").with_suffix(".html")).is_file()
    for page in (
        "index",
        "configuration",
        "contributing",
        "changelog",
        "gallery",
        "explanation",
        "reference",
    ):
        assert (site / f"{page}.html").is_file()


def test_nothing_is_loaded_from_elsewhere(site):
    loaded = re.compile(r"<(?:script|img|link|iframe)[^>]*?(?:src|href)=\"(?:https?:)?//[^\"]*\"")
    found = {page.name: loaded.findall(page.read_text(encoding="utf-8")) for page in site.rglob("*.html")}
    assert not {page: tags for page, tags in found.items() if tags}


def test_every_public_name_has_its_docstring(site):
    text = "".join(page.read_text(encoding="utf-8") for page in (site / "api").glob("*.html"))
    for name in freerock.__all__:
        path = f"{getattr(freerock, name).__module__}.{name}"
        assert f'id="{path}"' in text, path
    assert "Standard error" in text or "standard error" in text


def test_every_command_answers(site):
    text = (site / "command-line.html").read_text(encoding="utf-8")
    for name in COMMANDS:
        assert f"usage: freerock {name}" in text


def test_the_gallery_shows_every_figure_of_the_pages(site):
    text = (site / "gallery.html").read_text(encoding="utf-8")
    named = set()
    for page in (ROOT / "docs").rglob("*.md"):
        named |= set(re.findall(r"\]\((?:\.\./)?images/([\w.]+)\)", page.read_text(encoding="utf-8")))
    shown = {path for path in named if path.endswith((".png", ".svg"))}
    assert len(shown) > 20
    assert not {name for name in shown if name not in text}


def test_words_are_found(site):
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    for word in ("winkler", "corner", "uncertainti", "coverag"):
        assert word in index


@pytest.mark.parametrize(
    ("link", "source", "page", "expected"),
    [
        ("[a](docs/trust.md#x)", "README.md", "index.md", "[a](trust.md#x)"),
        ("[a](../config/README.md)", "docs/trust.md", "trust.md", "[a](configuration.md)"),
        ("[a](../../config/README.md)", "docs/how-to/plan.md", "how-to/plan.md", "[a](../configuration.md)"),
        ("![a](../images/plan.png)", "docs/how-to/plan.md", "how-to/plan.md", "![a](../images/plan.png)"),
        ("[a](../src/freerock/units.py)", "docs/records.md", "records.md", "a"),
        ("[a](https://spdx.org)", "docs/records.md", "records.md", "[a](https://spdx.org)"),
    ],
)
def test_links_of_the_repository_are_links_of_the_site(link, source, page, expected):
    assert LINK.sub(lambda found: linked(found, source, page), link) == expected


def test_a_broken_link_fails(tmp_path):
    """By the settings of the site, on two pages that are sound but for it."""
    shutil.copy(ROOT / "docs/site/conf.py", tmp_path)
    shutil.copy(ROOT / "docs/site/site.css", tmp_path)
    (tmp_path / "other.md").write_text("# Other\n\n## A heading\n", encoding="utf-8")
    command = [sys.executable, "-m", "sphinx", "-W", "-q", "-b", "dummy", tmp_path, tmp_path / "site"]
    for heading, told in (("a-heading", ""), ("no-such-heading", "no-such-heading")):
        page = f"# Page\n\n[there](other.md#{heading})\n\n```{{toctree}}\nother\n```\n"
        (tmp_path / "index.md").write_text(page, encoding="utf-8")
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (done.returncode != 0) == bool(told) and told in done.stderr, done.stderr
