"""Words that loggers write in headings, cells and dates, from `words.toml` beside this file."""

import tomllib
from pathlib import Path

WORDS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
HEADINGS = {name: frozenset(words.split()) for name, words in WORDS["headings"].items()}
SECOND_UNITS = {unit: float(size) for size, units in WORDS["seconds"].items() for unit in units.split()}
MONTHS = {
    name: n for n, names in enumerate(WORDS["dates"]["months"].split(), start=1) for name in names.split("|")
}
