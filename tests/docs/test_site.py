"""The site: built without warnings or the internet."""

import inspect
import re
from pathlib import Path

import pytest

import freerock
from freerock_bench.site import build

ROOT = Path(__file__).parents[2]


def test_the_site_has_every_page_and_name_and_loads_nothing_from_elsewhere(tmp_path):
    assert build(tmp_path) == 0
    for page in (ROOT / "docs").rglob("*.md"):
        assert (tmp_path / page.relative_to(ROOT / "docs").with_suffix(".html")).is_file()
    text = "".join(page.read_text(encoding="utf-8") for page in (tmp_path / "api").glob("*.html"))
    for name in freerock.__all__:
        assert f'id="{getattr(freerock, name).__module__}.{name}"' in text, name
    rows = set(re.findall(r'<a id="(\w+)"', (tmp_path / "evidence.html").read_text(encoding="utf-8")))
    link = re.compile(r'<a href="evidence\.html#(\w+)">')
    cited = [link.findall(page.read_text(encoding="utf-8")) for page in tmp_path.glob("*.html")]
    assert rows and {name for names in cited for name in names} <= rows
    loaded = re.compile(r"<(?:script|img|link|iframe)[^>]*?(?:src|href)=\"(?:https?:)?//[^\"]*\"")
    for page in tmp_path.rglob("*.html"):
        assert not loaded.findall(page.read_text(encoding="utf-8")), page


def test_the_python_of_the_readme_is_that_of_the_page_that_runs():
    shown = (ROOT / "README.md").read_text(encoding="utf-8").partition("```python\n")[2].partition("```")[0]
    runs = (ROOT / "docs/how-to/python.md").read_text(encoding="utf-8")
    lines = shown.splitlines()
    assert len(lines) == 8 and all(f">>> {line}\n" in runs for line in lines)


@pytest.mark.parametrize("name", freerock.__all__)
def test_a_public_function_shows_an_example(name):
    each = getattr(freerock, name)
    assert inspect.isclass(each) or ">>>" in inspect.getdoc(each)
