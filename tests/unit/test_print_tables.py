"""Tables printed from the CSV files say what the datasets say: ten digits are enough."""

import pytest
from fabricated import campaign
from reported import tables_of

from freerock.jobs.print_tables import print_tables
from freerock.report.printed import printed_tables
from freerock.tables.csvfile import read_csv, write_csv
from freerock.tables.latex import numbers_tex
from freerock.tables.markdown import markdown

LABELS = {"b1": "Slender", "mat": "Soft mat"}


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    return tables_of(tmp_path_factory.mktemp("tables"), campaign())


def test_printed_tables_are_those_of_the_datasets(tables, tmp_path):
    names = ("runs", "epsilon", "choice", "populations", "restitution")
    files = {name: tmp_path / f"{name}.csv" for name in (*names, "table1", "table2", "table3")}
    for name, file in files.items():
        write_csv(tables[name], file)
    print_tables(files, tmp_path, origin="simulated", doi="10.1/2", labels=LABELS)
    for name, table in printed_tables(tables, "simulated", doi="10.1/2", labels=LABELS).items():
        expected = markdown(table.text, table.caption, table.notes)
        assert (tmp_path / f"{name}.md").read_text(encoding="utf-8") == expected
        assert "Soft mat" in expected or name == "table1"
    read = tables | {name: read_csv(file) for name, file in files.items()}  # a digit may lie at one half
    assert (tmp_path / "numbers.tex").read_text(encoding="utf-8") == numbers_tex(read)
