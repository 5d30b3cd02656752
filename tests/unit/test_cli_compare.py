"""Two analyses side by side."""

import json

import pytest
from fabricated import campaign, tidy_tables

from freerock.cli import subcommands as cli
from freerock.cli.compare_command import compare_results, comparison_text
from freerock.tables.csvfile import write_csv

RECORDS = [{"test": test, "file": f"{test}.tdms"} for test in ("b1_marble", "b1_mat", "b2_marble", "b2_mat")]


@pytest.fixture(scope="module")
def tables():
    return tidy_tables(*campaign())


def write(folder, tables, checksum="0a", **config):
    (folder / "tables").mkdir(parents=True)
    (folder / "logs").mkdir()
    (folder / "logs/fit.log").write_text("of no account")
    for name, frame in tables.items():
        write_csv(frame, folder / f"tables/{name}.csv")
    made_by = {
        "inputs": {f"raw/{each['file']}": checksum for each in RECORDS},
        "config": {"raw": "raw", "records": RECORDS, "fits": {"debonding": "geometric"}} | config,
        "software": {"numpy": "2.0"},
        "git": "abc",
    }
    (folder / "provenance.json").write_text(json.dumps(made_by))
    return folder


@pytest.fixture
def a(tmp_path, tables):
    return write(tmp_path / "a", tables)


def changed(tables, column="value", **factors):
    """Tables whose first parameters are multiplied, those of each model by its factor."""
    frame = tables["parameters"].copy()
    for model, factor in factors.items():
        first = frame.index[(frame["model"] == model) & (frame["run"] == 1)][0]
        frame.loc[first, column] *= factor
    return tables | {"parameters": frame}


def test_the_same_analysis_is_the_same(a):
    found = compare_results(a, a)
    assert set(found.parameters["verdict"]) == {"identical"}
    assert found.outcomes.empty and found.provenance.empty and found.only_a == found.only_b == []
    text = comparison_text(found, a, a)
    assert "Made from the same inputs" in text
    assert "judged" not in text


@pytest.mark.parametrize(
    ("checksum", "shift", "verdict"),
    [("0a", 0.9, "within"), ("0a", 1.1, "changed"), ("1b", 1.1, "within"), ("1b", 2.9, "changed")],
)
def test_a_difference_is_over_the_error_it_can_have(a, tables, tmp_path, checksum, shift, verdict):
    """r = 0.957 ± 0.0012: of the same record 1 standard error is a change, of another 2 · √2."""
    b = write(tmp_path / "b", changed(tables, housner=1 + shift * 0.0012 / 0.957), checksum)
    row = compare_results(a, b).parameters.query("verdict != 'identical'").iloc[0]
    assert (row["model"], row["parameter"], row["verdict"]) == ("housner", "r", verdict)
    assert row["ratio"] == pytest.approx(shift / (1 if checksum == "0a" else 2**0.5), rel=1e-3)
    assert row["same_record"] == (checksum == "0a")


def test_choices_verdicts_and_provenance_that_differ(a, tables, tmp_path):
    choice, runs = tables["choice"].copy(), tables["runs"].copy()
    named = choice.index[choice["status"] == "selected"][0]
    choice.loc[named, "model"], runs.loc[1, "verdict"] = "winkler", "warn"
    b = write(
        tmp_path / "b", tables | {"choice": choice, "runs": runs}, "1b", fits={"debonding": "tensionless"}
    )
    found = compare_results(a, b)
    assert {tuple(row) for row in found.outcomes.values} == {
        ("b1_marble", "1", "model", "hunt_crossley", "winkler"),
        ("b1_marble", "2", "verdict", "ok", "warn"),
    }
    provenance = found.provenance.set_index("what")
    assert list(provenance.loc["config.fits.debonding"]) == ["geometric", "tensionless"]
    assert list(provenance.loc["inputs.raw/b1_mat.tdms"]) == ["0a", "1b"]
    assert len(provenance) == 5
    assert "geometric → tensionless" in comparison_text(found, a, b)


def test_the_command_prints_and_writes_every_parameter(a, tables, tmp_path, capsys):
    b = write(tmp_path / "b", changed(tables, winkler=1.5))
    assert cli.main(["compare", str(a), str(b), "--csv", str(tmp_path / "c.csv")]) == 0
    printed = capsys.readouterr().out
    assert "changed" in printed and "b1_marble" in printed
    assert len((tmp_path / "c.csv").read_text().splitlines()) == len(tables["parameters"]) + 1
