"""Which rule makes a file: looked up by its name where the rule names it."""

from collections import defaultdict
from collections.abc import Callable
from functools import cache
from typing import Any

from snakemake.output_index import OutputIndex


class ByName:
    """Snakemake's index of what the rules make, which compares a file with patterns, as a table of names.

    The rules of the batches name each file they make. Snakemake would search for each the beginnings of all
    names and then compile a pattern from each name of the rule: a sixth of the time that a plan of
    thousands of records takes. What patterns make of a file is looked up once: several rules ask for it.

    Parameters
    ----------
    rules : list of snakemake.rules.Rule
    """

    def __init__(self, rules: list[Any]) -> None:
        self._of_name: dict[str, set[Any]] = defaultdict(set)
        for rule in filter(_is_named, rules):
            for product in rule.products():
                self._of_name[str(product)].add(rule)
        of_patterns = OutputIndex([rule for rule in rules if not _is_named(rule)])
        self._match: Callable[[str], set[Any]] = cache(of_patterns.match)
        self._producers: Callable[[str], set[Any]] = cache(of_patterns.match_producers)

    def match(self, targetfile: str) -> set[Any]:
        """The rules that may make a file."""
        return self._match(str(targetfile)) | self._of_name.get(str(targetfile), set())

    def match_producers(self, targetfile: str) -> set[Any]:
        """The rules that make a file."""
        return self._producers(str(targetfile)) | self._of_name.get(str(targetfile), set())


def _is_named(rule: Any) -> bool:
    """Whether a rule names all that it makes."""
    return not any("{" in str(product) for product in rule.products())
