"""Two analyses side by side."""

import json

import pytest
from fabricated import campaign, tidy_tables

from freerock.cli import subcommands as cli
from freerock.cli.compare_command import compare_results
from freerock.tables.csvfile import write_csv

pytestmark = pytest.mark.slow

RECORDS = [{"test": test, "file": f"{test}.tdms"} for test in ("b1_marble", "b1_mat", "b2_marble", "b2_mat")]


@pytest.fixture(scope="module")
def tables():
    return tidy_tables(*campaign())


def write(folder, tables, checksum="0a", **config):
    for name, frame in tables.items():
        write_csv(frame, folder / f"tables/{name}.csv")
    made_by = {
        "inputs": {f"raw/{each['file']}": checksum for each in RECORDS},
        "config": {"records": RECORDS, "fits": {"debonding": "geometric"}} | config,
        "software": {"numpy": "2.0"},
    }
    (folder / "provenance.json").write_text(json.dumps(made_by))
    return folder


@pytest.fixture
def a(tmp_path, tables):
    return write(tmp_path / "a", tables)


def changed(tables, factor):
    """Tables whose first r is multiplied."""
    frame = tables["parameters"].copy()
    first = frame.index[(frame["model"] == "housner") & (frame["run"] == 1)][0]
    frame.loc[first, "value"] *= factor
    return tables | {"parameters": frame}


def test_the_same_analysis_is_the_same(a):
    parameters, others = compare_results(a, a)
    assert set(parameters["verdict"]) == {"identical"} and others == []


@pytest.mark.parametrize(("shift", "verdict"), [(0.9, "within"), (-1.1, "changed")])
def test_more_than_one_standard_error_is_a_change(a, tables, tmp_path, shift, verdict):
    """r = 0.957 ± 0.0012."""
    b = write(tmp_path / "b", changed(tables, 1 + shift * 0.0012 / 0.957))
    row = compare_results(a, b)[0].query("verdict != 'identical'").iloc[0]
    assert (row["model"], row["parameter"], row["verdict"]) == ("housner", "r", verdict)
    assert row["ratio"] == pytest.approx(shift, rel=1e-3)


def test_choices_verdicts_inputs_and_settings_that_differ(a, tables, tmp_path, capsys):
    choice, runs = tables["choice"].copy(), tables["runs"].copy()
    choice.loc[choice.index[choice["status"] == "selected"][0], "model"] = "winkler"
    runs.loc[1, "verdict"] = "warn"
    fewer = tables["parameters"].query("model != 'winkler' or test != 'b1_marble'")
    other = {"choice": choice, "runs": runs, "parameters": fewer}
    b = write(tmp_path / "b", tables | other, "1b", fits={"debonding": "tensionless"}, summary="")
    parameters, others = compare_results(a, b)
    assert set(parameters["verdict"]) == {"identical", "only a"}
    assert set(others) == {
        ("b1_marble, run 1: model", "hunt_crossley", "winkler"),
        ("b1_marble, run 2: verdict", "ok", "warn"),
        ("config.fits.debonding", "geometric", "tensionless"),
        *((f"inputs.raw/{each['file']}", "0a", "1b") for each in RECORDS),
    }
    assert cli.main(["compare", str(a), str(b), "--csv", str(tmp_path / "c.csv")]) == 0
    assert "only a" in capsys.readouterr().out
    assert len((tmp_path / "c.csv").read_text().splitlines()) == len(tables["parameters"]) + 1


@pytest.mark.parametrize("lost", ["provenance.json", "tables/parameters.csv"])
def test_a_folder_without_results_is_reported(a, lost, capsys):
    (a / lost).unlink()
    assert cli.main(["compare", str(a), str(a)]) == 1
    assert capsys.readouterr().err.endswith("; name the results of a campaign, as results/NAME\n")
