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


def test_discrepancies_rank_the_laws(beside):
    agrees, differs = beside({}, {"housner": 0.15, "winkler": 0.02, "hunt_crossley": 0.01}, {})
    ranked = "ε_θ ranks the laws as published on Marble: Hunt–Crossley < Winkler < Housner."
    assert agrees == ranked
    assert "ranks" not in "".join(beside({}, {"housner": 0.15}, {}))  # alone
    assert "Hunt–Crossley 1.30·10⁻⁴ % [1.00 %]; a simulated record leaves noise alone" in differs
    assert "Housner 24.6 % [15.00 %] and Winkler 2.60 % [2.00 %]; it depends on the final time" in differs
