"""The campaign beside a publication: what agrees, what does not, every number found again."""

import pytest
from fabricated import fits, record
from found_again import found_again
from reported import tables_of

from freerock.report.beside_published import beside_published
from freerock.report.findings import Finding
from freerock.report.numbers import plain
from freerock.tables.csvfile import read_csv, write_csv

LABELS = {"b1": "Slender", "b2": "Squat", "marble": "Marble", "mat": "Soft mat"}
SQUAT = record("b2_marble", "b2", n_runs=1)
NAMES = ("runs", "foundations", "restitution_comparison", "table2", "table3")


@pytest.fixture
def beside(tmp_path):
    """Sentences for published parameters, discrepancies and durations of one block on two foundations."""

    marble, mat = record("b1_marble", n_runs=1), record("b1_mat", foundation="mat", n_runs=1)

    def told(parameters, epsilon, longest, durations=(4.0, 2.0), unsure=1.0, trees=(marble, mat)):
        tables_of(tmp_path, (trees, [fits(tree) for tree in trees]))
        tables = {name: read_csv(tmp_path / f"{name}.csv") for name in NAMES}
        on_marble = tables["table2"]["foundation"] == "marble"
        for name, value in parameters.items():
            rows = on_marble & (tables["table2"]["model"] + "_" + tables["table2"]["parameter"] == name)
            tables["table2"].loc[rows, "published"] = value
        tables["table2"]["u_total"] *= unsure
        on_marble = tables["table3"]["foundation"] == "marble"
        for model, value in epsilon.items():
            tables["table3"].loc[on_marble & (tables["table3"]["model"] == model), "published"] = value
        tables["table3"]["selected"] = tables["table3"]["model"] == "hunt_crossley"
        tables["runs"]["duration_s"] = durations
        compared = tables["restitution_comparison"]
        compared["r_first"] = compared["foundation"].map({"marble": 0.94, "mat": 0.9})
        for name, frame in tables.items():
            write_csv(frame, tmp_path / f"{name}.csv")
        tables = {name: read_csv(tmp_path / f"{name}.csv") for name in NAMES}
        found = beside_published(tables, longest, LABELS)
        assert found_again([Finding("", found.agrees), Finding("", found.differs)], tmp_path, LABELS) > 0
        return [" ".join(map(plain, each)) for each in found]

    return told


def test_parameters_agree_to_within_a_tenth_and_r_by_what_an_impact_takes(beside):
    agrees, differs = beside({"hunt_crossley_k": 6.5e6, "winkler_k": 6e6, "housner_r": 0.95}, {}, {})
    assert agrees.startswith("The records are simulated: agreement with the law that made them tests")
    assert "alone. Within a tenth of the published value (in brackets): Hunt–Crossley k on Marble" in agrees
    assert "Hunt–Crossley k on Marble (6.880 ± 0.012)·10⁶ N m⁻² [6.50·10⁶ N m⁻²]" in agrees
    assert differs.startswith(
        "More than a tenth off the published value (in brackets; r by its difference from one"
    )
    assert "Winkler (rejected) k on Marble" in differs
    assert "Housner (rejected) r on Marble 0.9570 ± 0.0012 [0.950]" in differs  # 4.3 against 5 %


def test_why_a_rejected_law_proves_nothing_is_said_once(beside):
    agrees, differs = beside({"winkler_k": 6e6, "housner_r": 0.957}, {}, {})
    assert "(rejected)" in agrees and "(rejected)" in differs
    assert f"{agrees} {differs}".count("Parameters of a rejected law depend on") == 1


def test_what_is_too_uncertain_neither_agrees_nor_differs(beside):
    off, unknown = "More than a tenth off the", "off but within two standard uncertainties of the published"
    for unsure, size in ((1.0, off), (29.3, off), (1000.0, unknown)):  # 73, 2.5 and 0.07 of them apart
        agrees, differs = beside({"winkler_k": 6e6}, {}, {}, unsure=unsure)
        assert size in differs and "Winkler (rejected) k on Marble" in differs and not agrees


def test_discrepancies_rank_the_laws(beside):
    agrees, differs = beside({}, {"housner": 0.15, "winkler": 0.02, "hunt_crossley": 0.01}, {})
    ranked = "ε_θ ranks the laws as published on Marble: Hunt–Crossley < Winkler < Housner."
    assert agrees == ranked
    assert "ranks" not in "".join(beside({}, {"housner": 0.15}, {}))  # alone
    assert "Hunt–Crossley 1.30·10⁻⁴ % [1.00 %]; a simulated record leaves noise alone" in differs
    assert "Housner 24.6 % [15.00 %] and Winkler 2.60 % [2.00 %]; it depends on the final time" in differs


def test_a_published_discrepancy_has_the_decimals_of_the_table(beside):
    assert "Housner 24.6 % [15.25 %]" in beside({}, {"housner": 0.1525}, {})[1]


@pytest.mark.parametrize(
    "other, names", [(record("second", n_runs=1), ("first", "second")), (SQUAT, ("Slender", "Squat"))]
)
def test_of_several_published_on_a_foundation_each_is_named(beside, other, names):
    published = {"hunt_crossley_k": 6.88e6}, {"housner": 0.15, "winkler": 0.02}
    agrees, differs = beside(*published, {}, trees=[record("first", n_runs=1), other], durations=4.0)
    k = "(6.880 ± 0.012)·10⁶ N m⁻² [6.88·10⁶ N m⁻²]"
    assert " and ".join(f"Hunt–Crossley k for {name} on Marble {k}" for name in names) in agrees
    ranked = " and ".join(f"for {name} on Marble" for name in names)
    assert f"ε_θ ranks the laws as published {ranked}: Winkler < Housner." in agrees
    assert f"ε_θ for {names[1]} on Marble [published]: " in differs


def test_a_block_rocks_longest_as_published(beside):
    agrees, differs = beside({"hunt_crossley_k": 6.88e6}, {}, {"b1": "marble"})
    assert "Slender rocks longest on Marble, as published." in agrees
    assert differs == ""


def test_a_block_rocks_longest_elsewhere_and_why(beside):
    agrees, differs = beside({}, {}, {"b1": "mat"})
    assert agrees == ""
    assert differs.startswith(
        "Slender rocks longest on Marble (4.00 s; 2.00 s on Soft mat), in the publication on"
    )
    assert "its first impact keeps r = 0.940 of the angular rate on Marble, 0.900 on Soft mat." in differs


def test_runs_that_are_left_out_or_failed_say_nothing_of_where_a_block_rocks_longest(beside):
    trees = [record("b1_marble"), record("b1_mat", foundation="mat")]  # the third runs are excluded
    durations = (4.0, 3.0, 0.1, 2.0, 2.0, 99.0)
    differs = beside({}, {}, {"b1": "mat"}, durations, trees=trees)[1]
    assert "Slender rocks longest on Marble (3.00 to 4.00 s; 2.00 s on Soft mat)" in differs


def test_a_block_on_one_foundation_rocks_nowhere_longest(beside):
    told = beside({"hunt_crossley_k": 6.88e6}, {}, {"b1": "marble"}, 4.0, trees=[record("b1_marble")])
    assert "longest" not in "".join(told)
