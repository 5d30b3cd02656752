"""Every path and every name of the package that the documents give is there."""

import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PLACES = [ROOT, ROOT / "src", ROOT / "src/freerock"]
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
SUFFIXES = "py|smk|md|yml|lock|toml|mplstyle|j2|js|rst"
NAMED = re.compile(rf"`([\w.][\w./*{{}},-]*(?:/|\.(?:{SUFFIXES}))|[\w.]+(?:/[\w*.-]+)+)(?:::\w+)?`")
LINKED = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
DOTTED = re.compile(r"\bfreerock(?:_bench)?(?:\.[A-Za-z_]\w*)+\b(?!/)")
MADE = re.compile(  # products, places for a name of your own, names of channels
    r"^(results|raw|logs|ledger)/|^(figures|tables|fits|records)/.*\.(nc|csv|pdf|png|txt|tex|md|\*)$|report\.html"
    r"|NAME|TEST|FOLDER|campaigns/|^site/|^\.snakemake|^/|^group/|^fits/$"
)


def paths(document):
    """Paths named between backticks, and links."""
    text = re.sub(r"^( *)```.*?^\1```", "", document.read_text(encoding="utf-8"), flags=re.M | re.S)
    return set(NAMED.findall(text)), set(LINKED.findall(text))


def is_there(path, places):
    return any(next(place.glob(path), None) for place in places)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_paths_are_there(document):
    named, linked = paths(document)
    gone = {
        path for path in named if not MADE.search(path) and not is_there(path, [*PLACES, document.parent])
    }
    gone |= {path for path in linked if not (document.parent / path).exists()}
    assert not gone


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_names_of_the_package_are_there(document):
    for name in set(DOTTED.findall(document.read_text(encoding="utf-8"))) - {"freerock.log"}:  # a file
        module, _, member = name.rpartition(".")
        assert find_spec(name) if is_module(name) else hasattr(import_module(module), member), name


def is_module(name):
    path = ROOT / "src" / name.replace(".", "/")
    return path.is_dir() or path.with_name(f"{path.name}.py").is_file()


def test_paths_are_found():
    named, linked = paths(ROOT / "docs/architecture.md")
    assert {"models/kernel.py", "workflow/scripts", "records/"} <= named and "records.md" in linked
