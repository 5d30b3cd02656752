"""What the methods cite: the entries of references.bib, each below a line on how a text calls it."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

_ENTRY = re.compile(r"^Cited as (.+)\n(@(?:article|book)\{(\w+),\n(?:  .+\n)+\}\n)", re.M)


class Reference(NamedTuple):
    """A publication: how a text calls it, by authors and year, and its entry in BibTeX."""

    short: str
    entry: str

    @property
    def doi(self) -> str:
        """Its DOI."""
        return self.entry.partition("  doi = {")[2].partition("}")[0]


_FILE = Path(__file__).with_suffix(".bib").read_text(encoding="utf-8")
REFERENCES = {key: Reference(short, entry) for short, entry, key in _ENTRY.findall(_FILE)}
assert len(REFERENCES) == _FILE.count("\n@"), "references.bib: an entry was passed over"


def bibtex(keys: Iterable[str]) -> str:
    """The entries of some references.

    Parameters
    ----------
    keys : iterable of str
        Of `REFERENCES`.
    """
    return "\n".join(REFERENCES[key].entry for key in keys)
