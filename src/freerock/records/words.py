"""Words that loggers write in headings, cells and dates, from `words.toml` beside this file."""

import tomllib
from pathlib import Path

WORDS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
HEADINGS = {name: frozenset(words.split()) for name, words in WORDS["headings"].items()}
MONTHS = {
    name: n for n, names in enumerate(WORDS["dates"]["months"].split(), start=1) for name in names.split("|")
}


def by_word(part: str) -> dict[str, str]:
    """The key of each word in a part of the file."""
    return {word: key for key, words in WORDS[part].items() for word in words.split()}


SECOND_UNITS = {unit: float(size) for unit, size in by_word("seconds").items()}
HERTZ = {"": 1.0} | {unit: float(size) for unit, size in by_word("hertz").items()}
