"""The harness of the studies: configuration of a campaign of records, and its tables held against truth."""

import json

import numpy as np
import pandas as pd
import pytest

from freerock.config.campaign import load_campaign
from freerock.tables.tidy_tables import R_ENERGY, R_ENERGY_U
from freerock_bench import campaigns, kinds, noises, scattered
from freerock_bench.scattered import KNOWN, make
from freerock_bench.springs import Motion

pytestmark = pytest.mark.usefixtures("springs")

TRUTH = {"k": 2e6, "lambda": 5e7}


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    """A Hunt–Crossley block on Aerstop, guided, whose impacts scatter."""
    path = make(tmp_path_factory.mktemp("records"), 0.01, 5, seed=3, known="rule")
    return {path.stem: path}


@pytest.fixture
def tables(records):
    """What a workflow might say of it: k of run 1 three u too large, else right; λ of run 2 failed."""
    ((test, path),) = records.items()
    truth = np.load(path)
    of = {"test": test, "model": "hunt_crossley"}
    fits = [
        of
        | {"run": run, "parameter": name, "value": float(truth[f"run{run - 1}_{name}"]) * (1 + off)}
        | {"stderr": 1.0, "u_total": 0.01 * float(truth[f"run{run - 1}_{name}"]), "success": success}
        for run, name, off, success in [
            (1, "k", 0.03, True),
            (1, "lambda", 0.01, True),
            (2, "lambda", 0, False),
        ]
    ]
    scatter = of | {"run": 1, "sigma_r": 0.011, "sigma_r_low": 0.009, "sigma_r_high": 0.013}
    status = {1: ("selected", "rejected"), 2: ("also_possible", "selected"), 3: ("rejected", "selected")}
    choice = [
        {
            "test": test,
            "run": run,
            "model": model,
            "status": each,
            "explains": True,
            "minus_two_log": 0.0,
            "reason": "",
        }
        for run, (own, other) in status.items()
        for model, each in (("hunt_crossley", own), ("winkler", other))
    ]
    runs = [
        {"test": test, "run": j + 1, "release_s": float(begins) + 0.005, "verdict": "ok", "reasons": ""}
        for j, begins in enumerate(truth["begins_s"][:2])
    ]
    at, r = (
        float(truth["run0_volts_impacts_s"][1]) - runs[0]["release_s"],
        float(truth["run0_volts_true_r"][1]),
    )
    impact = {"test": test, "run": 1, "source": "experiment", "time_s": at, R_ENERGY: r + 0.01}
    mean = of | {"level": "record", "parameter": "k", "n_runs": 3, "stderr": 1.0, "u_total": 1e4}
    mean |= {"mean": float(truth["mean_k"]), "next_low": 0.0, "next_high": 1.0}
    mean |= {"total95_low": 0.0, "total95_high": 1e9}
    band = {"test": test, "run": 1, "inside": True, "impact_inside": False}
    made = {
        "runs": runs,
        "choice": choice,
        "parameters": fits,
        "restitution": [impact | {R_ENERGY_U: 0.001}],
    }
    paper = of | {"run": 1, "parameter": "k", "value": 1.2 * float(truth["run0_k"])}
    made |= {"populations": [mean], "predictions": [band], "paper": [paper], "epsilon": [scatter]}
    made["reasons"] = [of | {"run": 1, "reason": "pulled_input"}]
    return {name: pd.DataFrame(rows) for name, rows in made.items()}


def inside(frame, parameter):
    return frame.loc[frame["parameter"] == parameter, "inside"].astype(bool).tolist()


def test_tables_are_held_against_the_truth(tables, records):
    frame = campaigns.graded(tables, records, lambda truth: "a case")
    assert list(frame) == campaigns.COLUMNS and set(frame["case"]) == {"a case"}
    assert inside(frame, "k") == [False] and inside(frame, "lambda") == [True]
    assert inside(frame, "σ_r") == [True]
    assert inside(frame, "true law first") == [True, False, False]
    assert inside(frame, "true law in the set") == [True, True, False]
    assert inside(frame, "named alone, wrongly") == [False, False, True]
    assert frame.query("parameter == 'verdict ok'")["note"].tolist() == ["ok pulled_input", "ok", "missed"]
    assert inside(frame, "run is used") == [True, True, False]
    assert inside(frame, "r of an impact") == [False]
    assert inside(frame, "mean k") == [True] and inside(frame, "next k") == [False]
    assert inside(frame, "left-out |θ_n|") == [True]
    assert inside(frame, "left-out impacts") == [False]
    assert "| k | 0 % of 1, 3 % |" in campaigns.markdown(frame)
    assert "| k by the paper's objective | 1, 20 % |" in campaigns.markdown(frame)


def test_the_campaign_that_is_written_is_read(records, tmp_path, monkeypatch):
    campaigns._write(tmp_path, records)
    monkeypatch.chdir(tmp_path)
    ((test, _),) = records.items()
    stated = json.loads((tmp_path / "config/campaigns/bench.yaml").read_text())
    assert stated["blocks"][f"block_{test}"]["uncertainty"]["height_m"] == KNOWN["rule"]["height_m"]
    assert (
        stated["lasers"][f"laser_{test}"]["uncertainty"]["scale_fraction"] == KNOWN["rule"]["scale_fraction"]
    )
    assert [each for each in load_campaign(tmp_path / "config/campaigns/bench.yaml").records] != []
    before = (tmp_path / f"raw/bench/{test}.csv").stat().st_mtime_ns
    campaigns._write(tmp_path, records)
    assert (tmp_path / f"raw/bench/{test}.csv").stat().st_mtime_ns == before


@pytest.fixture
def cut(monkeypatch):
    """Motions end after two seconds."""
    for study in (kinds, scattered):
        monkeypatch.setattr(study, "Motion", lambda scene, rate_hz: Motion(scene, rate_hz, 2.0))


@pytest.mark.parametrize(
    "name", ["clean, rigid", "three samples lost", "clock 0.2 % fast", "card of 12 bits"]
)
def test_a_record_of_a_kind_is_that_of_its_seed(name, tmp_path, cut):
    one, other = (np.load(kinds.make(tmp_path / each, (name, 0.0))) for each in "ab")
    np.testing.assert_array_equal(one["volts"], other["volts"])
    assert np.isfinite(one["volts"]).all() and np.std(one["volts"][:1000]) < 6e-3
    assert str(one["kind"]) == name and bool(one["clean"]) is kinds.KINDS[name].is_clean


def test_what_a_kind_states_is_in_its_record(tmp_path, cut):
    names = "slow noise", "clock 0.2 % fast", "card of 12 bits"
    plain, fast, coarse = (np.load(kinds.make(tmp_path, (name, 0.0))) for name in names)
    assert abs(float(fast["true_clock"]) - 1 / 1.002) < 3e-4 > abs(float(plain["true_clock"]) - 1)
    levels = np.unique(coarse["volts"])
    assert len(levels) < 4096 and np.diff(levels).min() == pytest.approx(20 / 2**12)


@pytest.mark.parametrize("name", ["white", "200 ms", "1/f", "14 bits, 2 mV"])
def test_a_record_of_a_noise_has_its_size(name, tmp_path, cut):
    record = np.load(noises.make(tmp_path, (name, 0)))
    assert str(record["noise"]) == name
    assert float(record["true_height_m"]) == float(record["stated_height_m"])
    spread = np.std(record["volts"][:4000])
    assert 2e-4 < spread < 8e-3
    slow = np.corrcoef(record["volts"][:3999], record["volts"][1:4000])[0, 1]
    assert (slow > 0.5) == (name in ("200 ms",)) or name == "1/f"


@pytest.mark.parametrize(("size", "n"), [("full", 6 * 14), ("small", 1)])
def test_noises_are_a_study_of_every_noise_and_converter(size, n, tmp_path, monkeypatch):
    monkeypatch.setattr(campaigns, "study", lambda *given: given)
    folder, make, cases, case_of, cores = noises.run(size, tmp_path, 2)
    assert (folder, make, cores, len({*cases})) == (tmp_path, noises.make, 2, n)
    assert all(case_of({"noise": name}) == name for name, _ in cases)
