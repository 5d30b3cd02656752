"""Tables printed from the CSV files say what the datasets say: ten digits are enough."""

import pytest
from fabricated import campaign, tidy_tables

from freerock.jobs.print_tables import print_recovered, print_tables
from freerock.models.block import Block
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.latex import numbers_tex
from freerock.tables.markdown import markdown
from freerock.tables.printed_tables import printed_recovered, printed_tables
from freerock.tables.summary import recovered_table, table1, table2, table3

LABELS = {"b1": "Slender", "mat": "Soft mat"}


@pytest.fixture(scope="module")
def tables():
    records, fits = campaign()
    blocks = {"b1": Block(0.28, 0.07, 5.84), "b2": Block(0.14, 0.07, 2.98)}
    tidy = tidy_tables(records, fits)
    frames = {"table1": table1(records, blocks), "table2": table2(tidy["populations"], tidy["parameters"])}
    return tidy | frames | {"table3": table3(tidy["epsilon"])}


def test_printed_tables_are_those_of_the_datasets(tables, tmp_path):
    for name, frame in tables.items():
        write_csv(frame, tmp_path / f"{name}.csv")
    names = ("runs", "parameters", "epsilon", "candidates", "populations", "table1", "table2", "table3")
    files = {name: tmp_path / f"{name}.csv" for name in names}
    print_tables(files, tmp_path, origin="simulated", doi="10.1/2", labels=LABELS)
    for name, table in printed_tables(tables, "simulated", doi="10.1/2", labels=LABELS).items():
        expected = markdown(table.text, table.caption, table.notes)
        assert (tmp_path / f"{name}.md").read_text(encoding="utf-8") == expected
        assert "Soft mat" in expected or name == "table1"
    read = tables | {name: read_csv(file) for name, file in files.items()}  # a digit may lie at one half
    assert (tmp_path / "numbers.tex").read_text(encoding="utf-8") == numbers_tex(read)


def test_recovered_values_are_written_in_three_forms(tables, tmp_path):
    write_csv(tables["parameters"], tmp_path / "parameters.csv")
    truth = {("b1_marble", 1, "hunt_crossley", "k"): 6.88e6}
    print_recovered(tmp_path / "parameters.csv", truth, tmp_path / "recovered")
    text = printed_recovered(recovered_table(tables["parameters"], truth)).text
    assert text["Truth"].tolist() == ["6.8800·10⁶"]
    assert "6.8800·10⁶" in (tmp_path / "recovered.md").read_text(encoding="utf-8")
    assert (tmp_path / "recovered.csv").read_text().splitlines()[1].endswith("True,simulated")
    assert (tmp_path / "recovered.tex").exists()
