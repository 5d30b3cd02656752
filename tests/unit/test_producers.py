"""The rule that makes a file is the same whether it is looked up by name or by pattern."""

import pytest
from snakemake.io import IOFile
from snakemake.output_index import OutputIndex
from snakemake.pathvars import Pathvars

from freerock.jobs.producers import ByName


class Rule:
    """What an index asks of a rule of Snakemake: its products, and whether they match a file."""

    pathvars = Pathvars()

    def __init__(self, name, *products):
        self.name, self._products = name, [IOFile(each, rule=self) for each in products]

    def products(self):
        return self._products

    def is_producer(self, file):
        return any(each.match(file) for each in self._products)

    def __repr__(self):
        return self.name


RULES = [
    Rule("record_one", "results/a/records/t1.nc", "results/a/records/t10.nc"),
    Rule("record_two", "results/a/records/t2.nc"),
    Rule("same", "results/a/records/t2.nc", "results/a/records/t+.nc"),
    Rule(
        "figure", r"results/{campaign,\w+}/figures/{figure}.png", r"results/{campaign}/figures/{figure}.csv"
    ),
    Rule("quality_one", "results/a/figures/qc_t1.png", "results/a/figures/qc_t1.csv"),
    Rule("mixed", "results/{campaign}/table.csv", "results/{campaign}/table.md"),
    Rule("target"),
]
FILES = ["results/a/records/t1.nc", "results/a/records/t10.nc", "results/a/records/t2.nc"]
FILES += [
    "results/a/records/t+.nc",
    "results/a/records/tt.nc",
    "results/a/records/t1.ncx",
    "results/a/records/t",
]
FILES += [
    "results/a/figures/qc_t1.png",
    "results/a/figures/qc_t2.png",
    "results/b/table.csv",
    "results/b/c/table.csv",
    "",
]


@pytest.mark.parametrize("file", FILES)
def test_producers_are_those_that_snakemake_finds(file):
    assert ByName(RULES).match_producers(file) == OutputIndex(RULES).match_producers(file)


def test_a_name_that_two_rules_make_and_one_of_a_pattern_too_is_ambiguous():
    index = ByName(RULES)
    assert {rule.name for rule in index.match_producers("results/a/records/t2.nc")} == {"record_two", "same"}
    assert {rule.name for rule in index.match_producers("results/a/figures/qc_t1.png")} == {
        "figure",
        "quality_one",
    }
    assert index.match_producers("results/a/records/t3.nc") == set()
