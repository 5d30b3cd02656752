"""The prose of this project: how much of it, how long its sentences are, and what it must not say.

    python -m freerock_bench.prose count              # words, words a sentence and numbers of each page
    python -m freerock_bench.prose count OTHER        # of another checkout
    python -m freerock_bench.prose lint               # docs, docstrings, config help, by proselint, own rules

Written words are those of text and of tables written by hand. Code blocks do not count, nor do tables between
the marks of the bench or of a generator.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
from proselint.registry.checks import Check, types
from proselint.registry.checks.engine import Fancy
from proselint.tools import LintFile

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r"^ *```.*?^ *```$", re.M | re.S)
MADE = re.compile(r"^<!-- ([a-z][\w ]*) -->$.*?^<!-- end\b[\w ]* -->$", re.M | re.S)
COMMENT = re.compile(r"<!--.*?-->", re.S)
HELD = {"CHANGELOG.md": 2500, "README.md": 600}  # most words
HOW_TO, EXPLANATION, PAGES = 400, 2000, 25_000
EXPLANATIONS = ("physics", "signals", "identification", "uncertainty", "trust")
LONGEST = 20.0  # words a sentence, on average of a page

PATTERNS = {
    r"\bis told\b|\bare told\b|\bto be told\b": "'is told': say reported, or name the message",
    r"\b(?:is|are|was|were) asked for\b|\basks? for\b|\basked for\b": "'asks for': say requires",
    r"\bwhat is left\b|\bis left of\b|\bare left of\b": "'what is left': say residual, or remaining",
    r"\bthat of which\b|\bof that which\b|\bthat which\b": "'of that which': name the thing",
    r"(?m)^(?:That|Those) of\b|(?<=[.!?] )(?:That|Those) of\b": "'That of': name the thing",
    r"\bit is said\b|\bis said of\b|\bsays so\b|\bsay so\b": "'says so': say reports this",
    r"\bsaid and never done\b|\bnothing is said\b": "name who says what",
    r"\bhow sure\b": "'how sure': say uncertainty",
    r"\bworked out\b": "'worked out': say computed",
    r"\bmade up for\b|\bmakes up for\b": "'makes up for': say compensates",
    r"\bleft out\b(?= where)": "'left out where': say omitted if",
}
CHECKS = [
    Check(types.ExistenceSimple(pattern), Fancy(), path=f"freerock.{number}", message=message)
    for number, (pattern, message) in enumerate(PATTERNS.items())
]


def prose(text: str) -> str:
    """The text of a page without code blocks, made tables and comments."""
    return COMMENT.sub("", FENCE.sub("", MADE.sub("", text)))


def written(text: str) -> list[str]:
    """The written words of a page."""
    return [word for word in re.sub(r"[|]", " ", prose(text)).split() if re.search(r"\w", word)]


def sentences(text: str) -> list[list[str]]:
    """The words of each sentence of running text and lists; tables and headings hold none."""
    paragraphs: list[str] = []
    for block in re.split(r"\n\s*\n|\n(?= *(?:[-*]|\d+\.) )", prose(text)):
        if not re.match(r"\s*(?:[|#!]|Source:)", block):
            block = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", block)
            paragraphs.append(re.sub(r"^\s*(?:[-*]|\d+\.) ", "", " ".join(block.split())))
    split = re.compile(r"(?<=[.!?]) +(?=[A-Z`*(ΔθσεΛλ\d])|(?<=[.!?]\*\*) +")
    found = [words(each) for paragraph in paragraphs for each in split.split(paragraph)]
    return [each for each in found if len(each) > 2]


def words(text: str) -> list[str]:
    """Words, of which a code span is one."""
    return [each for each in re.sub(r"`[^`]*`", "code", text).split() if re.search(r"[^\W_]", each)]


def numbers(text: str) -> int:
    """Numbers in the written part of a page."""
    return len(re.findall(r"(?<![\w.])\d[\d.,]*(?:e-?\d+)?", prose(text)))


def pages(root: Path) -> dict[str, str]:
    """Every written page of a checkout, by its path."""
    paths = [root / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")]
    paths += sorted((root / "docs").rglob("*.md"))
    return {path.relative_to(root).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def count(root: Path) -> None:
    """Print words as `wc` has them, written words, words a sentence and numbers of each page."""
    rows = {page: row_of(text) for page, text in pages(root).items()}
    columns = ["words", "written", "in sentences", "sentences", "numbers"]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
    table.loc["docs, all"] = table[table.index.str.startswith("docs/")].sum()
    table["words a sentence"] = (table["in sentences"] / table["sentences"].clip(lower=1)).round(1)
    print(table.to_string())


def row_of(text: str) -> tuple[int, ...]:
    """Words, written words, words in sentences, sentences, numbers."""
    said = sentences(text)
    return len(text.split()), len(written(text)), sum(map(len, said)), len(said), numbers(text)


def docstrings(root: Path) -> Iterator[tuple[Path, int, str]]:
    """Path, line and text of each docstring of the package."""
    for path in sorted((root / "src/freerock").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                text = ast.get_docstring(node, clean=False)
                if text:
                    yield path, node.body[0].lineno, text


def lint(root: Path) -> list[str]:
    """What the rules find: where, what; the length of pages and of sentences too."""
    found: list[str] = []
    for page, text in pages(root).items():
        kept = text if page != "CONTRIBUTING.md" else text.partition("| before | after |")[0]
        for part in (MADE, FENCE, COMMENT):
            kept = part.sub(lambda match: "\n" * match[0].count("\n"), kept)
        found += against_rules(page, 1, kept)
        found += too_long(page, text)
    found += against_rules("config/README.md", 1, (root / "config/README.md").read_text(encoding="utf-8"))
    for path, line, text in docstrings(root):
        found += against_rules(path.relative_to(root).as_posix(), line, text)
    total = sum(len(written(text)) for page, text in pages(root).items() if page.startswith("docs/"))
    return [*found, *([f"docs: {total} written words, at most {PAGES}"] if total > PAGES else [])]


def against_rules(name: str, first_line: int, text: str) -> Iterator[str]:
    """Every match of the rules in a text."""
    file = LintFile(source=name, content=text)
    for check in CHECKS:
        for result in check.check_with_flags(file.content):
            line = file.content[: result.span[0] + 1].count("\n") + first_line - 1
            yield f"{name}:{line}: {result.message}"


def too_long(page: str, text: str) -> Iterator[str]:
    """Pages and sentences that are too long."""
    stem = Path(page).stem
    most = HELD.get(page, EXPLANATION if stem in EXPLANATIONS else HOW_TO if "how-to/" in page else None)
    if most and len(written(text)) > most:
        yield f"{page}: {len(written(text))} written words, at most {most}"
    said = sentences(text)
    mean = sum(map(len, said)) / max(len(said), 1)
    if mean > LONGEST:
        yield f"{page}: {mean:.1f} words a sentence, at most {LONGEST:g}"


def main() -> int:
    """Count or lint."""
    if sys.argv[1:2] == ["lint"]:
        found = lint(ROOT)
        print(*found, sep="\n", end="\n" if found else "")
        return bool(found)
    count(Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
