"""freerock simulate: scenes on a moving ground, virtual records, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from laboratory import QUOTED_LAWS

from freerock.cli import subcommands as cli
from freerock.models.block import Block
from freerock.models.ground import accelerogram, pulse
from freerock.models.laws import Rules
from freerock.models.simulate import simulate
from freerock.records.read import read_record

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENE = """\
block: {height_m: 0.28, width_m: 0.07, mass_kg: 5.84}
models: {housner: {r: 0.9}}
release_angle_deg: 5
duration_s: 1
"""
LASER = "laser: {beam: horizontal, position_m: 0.2, range_m: 0.1}\n"
VOLTS = "the virtual laser has volts and a range; give range_m, leave units out"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(text, *arguments):
    Path("scene.yaml").write_text(text)
    return cli.main(["simulate", "scene.yaml", *arguments])


def test_the_shake_table_is_the_simulation_of_the_models(here, capsys):
    assert cli.main(["simulate", str(EXAMPLES / "shake_table.yaml")]) == 0
    out = capsys.readouterr().out
    assert "housner: at_rest, largest angle 2.0" in out
    assert "hunt_crossley: completed, largest angle 11." in out
    frame = pd.read_csv("results/simulate/shake_table.csv")
    assert set(frame["origin"]) == {"simulated"}
    ground, block = pulse("sine", 0.25, x=3.0, start_s=0.5), Block(0.28, 0.07, 5.84)
    assert np.allclose(frame["ground_x_m_s2"], ground(frame["time_s"])[0], atol=1e-9)
    for model, parameters in (("housner", {"r": 0.958}), ("hunt_crossley", {"k": 6.88e6, "lambda": 1.3e8})):
        theta = simulate(model, block, parameters, frame["time_s"].values, base_excitation=ground).theta
        assert np.allclose(frame[f"theta_deg_{model}"], np.degrees(theta), atol=1e-8)
    assert {path.name for path in Path("results/simulate").iterdir()} == {
        *("shake_table.csv", "shake_table.pdf", "shake_table.png")
    }


def test_ground_from_a_file(here):
    time = np.arange(0, 0.3, 0.01)
    table = pd.DataFrame({"time_s": time, "x_m_s2": 3 * np.sin(25 * time)})
    table.to_csv("ground.csv", index=False)
    assert run(SCENE.replace("release_angle_deg: 5", "ground: {file: ground.csv}")) == 0
    frame = pd.read_csv("results/simulate/scene.csv")
    ground = accelerogram(time, table["x_m_s2"])
    theta = simulate(
        "housner", Block(0.28, 0.07, 5.84), {"r": 0.9}, frame["time_s"].values, base_excitation=ground
    ).theta
    assert np.allclose(frame["theta_deg_housner"], np.degrees(theta), atol=1e-8)
    assert np.abs(theta).max() > 0.001


def test_a_scene_of_a_pivoting_block(here):
    law = {"k": 6.88e6, "lambda": 1.3e8}
    text = SCENE.replace("housner: {r: 0.9}", "hunt_crossley: {k: 6.88e+6, lambda: 1.3e+8}")
    assert run(text + "kinematics: pivoting\n") == 0
    frame = pd.read_csv("results/simulate/scene.csv")
    block, time, rules = Block(0.28, 0.07, 5.84), frame["time_s"].values, Rules(kinematics="pivoting")
    theta = simulate("hunt_crossley", block, law, time, theta0=math.radians(5), rules=rules).theta
    assert np.allclose(frame["theta_deg_hunt_crossley"], np.degrees(theta), atol=1e-8)
    assert run(text + LASER + "kinematics: pivoting\n", "--into", "record") == 0
    assert run(text + LASER, "--into", "guided") == 0
    assert Path("record/scene.tdms").read_bytes() != Path("guided/scene.tdms").read_bytes()


def test_a_virtual_record_of_a_bed_that_relaxes(here):
    text = SCENE.replace("housner: {r: 0.9}", "viscoelastic: {k: 7.e+6, c: 5.e+4, tau: 0.01}")
    assert run(text + LASER, "--into", "record") == 0
    assert read_record("record/scene.tdms")


def test_a_virtual_record_is_a_record_file_the_same_each_time(here):
    for folder in ("one", "two"):
        assert run(SCENE + LASER, "--into", folder) == 0
    assert Path("one/scene.tdms").read_bytes() == Path("two/scene.tdms").read_bytes()
    record = read_record("one/scene.tdms")
    assert (list(record.data_vars), record.attrs["sampling_rate_hz"]) == (["laser"], 1000)
    assert run(SCENE + LASER.replace("0.1}", "0.1, seed: 5}"), "--into", "two") == 0
    assert Path("one/scene.tdms").read_bytes() != Path("two/scene.tdms").read_bytes()


MISTAKES = {
    "unknown model": (
        ("housner: {", "hausner: {"),
        f"scene.yaml:2: models.hausner: 'hausner' is not {QUOTED_LAWS}; did you mean 'housner'?",
    ),
    "incomplete model": (
        ("housner: {r: 0.9}", "winkler: {k: 1.e+6}"),
        "scene.yaml:2: models: winkler has no c; give c or leave winkler out",
    ),
    "energy from nothing": (
        ("0.9", "1.1"),
        "scene.yaml:2: models: r = 1.1 is above 1; give r up to 1",
    ),
    "pulse and file": (
        ("release_angle_deg: 5", "ground: {pulse: {period_s: 1}, file: a.csv}"),
        "scene.yaml:3: ground.file: has both a pulse and a file; keep one of the two",
    ),
    "neither": (
        ("release_angle_deg: 5", "ground: {}"),
        "scene.yaml:3: ground.file: has neither a pulse nor a file; give one of the two",
    ),
    "record on a moving ground": (
        ("duration_s: 1\n", "duration_s: 1\nground: {pulse: {period_s: 1}}\n" + LASER),
        "scene.yaml:6: laser: a record cannot have a ground motion; remove ground, or laser",
    ),
    "record of two models": (
        ("r: 0.9}}\n", "r: 0.9}, winkler: {k: 1.e+6, c: 1.e+3}}\n" + LASER),
        "scene.yaml:3: laser: a record needs exactly one model; keep one of the models",
    ),
    "record of no release": (
        ("release_angle_deg: 5\n", LASER),
        "scene.yaml:3: laser: no block is released; give release_angle_deg",
    ),
    "record of rotations": (
        ("duration_s: 1\n", "duration_s: 1\nlaser: {units: deg}\n"),
        f"scene.yaml:5: laser: {VOLTS}",
    ),
    "record of milliamperes": (
        ("duration_s: 1\n", "duration_s: 1\n" + LASER.replace("0.1}", "0.1, units: mA}")),
        f"scene.yaml:5: laser: {VOLTS}",
    ),
    "record by a calibration table": (
        ("duration_s: 1\n", "duration_s: 1\n" + LASER.replace("range_m: 0.1", "calibration: c.csv")),
        f"scene.yaml:5: laser: {VOLTS}",
    ),
    "no ground file": (
        ("release_angle_deg: 5", "ground: {file: none.csv}"),
        "none.csv: can't be read (none.csv not found.); give a CSV file with columns time_s, x_m_s2, z_m_s2",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_reported_in_one_line(here, capsys, mistake):
    (old, new), line = MISTAKES[mistake]
    text = SCENE.replace(old, new)
    assert text != SCENE
    assert run(text) == 1
    assert capsys.readouterr().err == f"{line}\n"


def test_an_empty_ground_file(here, capsys):
    Path("ground.csv").write_text("")
    assert run(SCENE.replace("release_angle_deg: 5", "ground: {file: ground.csv}")) == 1
    assert capsys.readouterr().err.startswith("ground.csv: can't be read (")


def test_a_ground_file_of_other_columns(here, capsys):
    Path("ground.csv").write_text("t,x_m_s2\n0,0\n1,1\n")
    assert run(SCENE.replace("release_angle_deg: 5", "ground: {file: ground.csv}")) == 1
    assert capsys.readouterr().err == (
        "ground.csv: has no column time_s; head its columns time_s, x_m_s2, z_m_s2\n"
    )
