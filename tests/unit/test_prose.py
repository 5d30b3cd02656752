"""The linter of the prose finds what it must, and nothing in this project; counts of a known text."""

import re

import pytest

from freerock_bench import prose

PAGE = """# Heading of four words

One sentence has five words. Another one, with `a code span`, has about nine 12.5 words.

| a | table |
|---|---|
| two | 7 |

```sh
not counted at all
```

<!-- scores -->

| 1 | 2 | 3 |

<!-- end of scores -->
"""


def test_the_project_keeps_its_rules():
    assert prose.lint(prose.ROOT) == []


@pytest.mark.parametrize(
    "text",
    [
        "Where no swing is seen this is told.",
        "The data ask for another width.",
        "What is left is noise.",
        "It depends on k. That of a pivoting block is later.",
        "The fit says so.",
    ],
)
def test_bad_patterns_are_found(text):
    (found,) = prose.against_rules("page.md", 1, f"A good first line.\n{text}")
    assert found.startswith("page.md:2: ")


def test_plain_text_is_clean():
    text = "The data require another width. The first impact of a pivoting block is later."
    assert list(prose.against_rules("page.md", 1, text)) == []


def test_counts():
    assert [len(each) for each in prose.sentences(PAGE)] == [5, 9]
    assert len(prose.written(PAGE)) == 4 + 5 + 11 + 4
    assert prose.numbers(PAGE) == 2


def test_long_pages_and_long_sentences_are_found():
    assert list(prose.too_long("README.md", "word " * 601)) != []
    assert list(prose.too_long("docs/how-to/x.md", "Five words are no novel. " * 81)) != []
    (found,) = prose.too_long("docs/other.md", "word " * 25 + ".")
    assert "25.0 words a sentence" in found


def test_docstrings_are_read():
    found = {path.name for path, _, _ in prose.docstrings(prose.ROOT)}
    assert {"fit.py", "kernel.py"} <= found


def test_made_tables_do_not_count():
    page = (prose.ROOT / "docs/validation.md").read_text(encoding="utf-8")
    assert "MuJoCo's box with friction" in page
    assert "MuJoCo's box with friction" not in prose.prose(page)


def test_every_mark_has_its_end():
    for path in (prose.ROOT / "docs").rglob("*.md"):
        ends = re.findall(r"^<!-- end\b.* -->$", path.read_text(encoding="utf-8"), re.M)
        assert len(ends) == len(prose.MADE.findall(path.read_text(encoding="utf-8"))), path.name
