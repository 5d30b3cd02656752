"""Ground motions, ensembles of responses, probability of overturning."""

import math

import numpy as np
import pandas as pd
import pytest
from scipy.special import ndtr
from scipy.stats import binomtest

from freerock.errors import FreerockError
from freerock.jobs.make_responses import SCENE, fragility_table, known_laws, make_responses
from freerock.models.block import GRAVITY, Block
from freerock.report.tables import overturning as overturning_table
from freerock.response.draws import KnownParameter, drawn
from freerock.response.ensemble import respond
from freerock.response.fragility import GROUPS, _counted, fit_lognormal, fragility
from freerock.response.motions import Accelerogram, ground_motions_in, read_motion

BLOCK = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
AT2 = """\
PEER NGA STRONG MOTION DATABASE RECORD
SOMEWHERE, STATION 1, 90
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=   {n}, DT=   .0100 SEC,
{values}
"""


def shaken(seed, peak_g, seconds=20.0, step=0.01, band=(0.5, 5.0)):
    """Sines of a band [Hz] under an envelope."""
    draw, t = np.random.default_rng(seed), np.arange(0, seconds, step)
    waves = [np.sin(2 * np.pi * f * t + draw.uniform(0, 2 * np.pi)) for f in draw.uniform(*band, 12)]
    a = np.sum(waves, axis=0) * np.exp(-(((t - 6) / 4) ** 2))
    return Accelerogram(f"motion_{seed}", t, a / np.abs(a).max() * peak_g * GRAVITY)


def test_a_motion_is_read_as_at2_and_as_a_table(tmp_path):
    values = np.round(0.3 * np.sin(np.arange(40) / 3), 5)
    rows = "\n".join(" ".join(f"{v:.5E}" for v in row) for row in values.reshape(-1, 5))
    (tmp_path / "a.AT2").write_text(AT2.format(n=40, values=rows))
    table = "\n".join(f"{0.01 * i:.2f},{v * GRAVITY:.9f}" for i, v in enumerate(values))
    (tmp_path / "b.csv").write_text(f"time [s],acceleration [m/s²]\n{table}\n")
    (tmp_path / "notes.pdf").write_text("no motion")
    motions, wrong = ground_motions_in(tmp_path)
    assert wrong == []
    assert [each.name for each in motions] == ["a", "b"]
    for each in motions:
        assert each.acceleration == pytest.approx(values * GRAVITY, abs=1e-7)
        assert each.time_s == pytest.approx(0.01 * np.arange(40))
    assert motions[0].pga == pytest.approx(np.abs(values).max() * GRAVITY)


def test_peak_velocity_is_that_of_a_sine():
    t = np.arange(0, 1.0005, 0.001)
    motion = Accelerogram("sine", t, 2.0 * np.sin(2 * np.pi * t))
    assert motion.pgv == pytest.approx(2 * 2.0 / (2 * np.pi), rel=1e-5)


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("a.at2", AT2.format(n=6, values="1 2 3 4 5"), "has 5 samples and states NPTS= 6"),
        ("a.at2", AT2.format(n=2, values="0.1 x"), "a.at2:5: 'x' is not a number"),
        ("a.at2", AT2.format(n=2, values="0.1 0.2").replace("NPTS", "N"), "states no NPTS and DT"),
        ("a.at2", AT2.format(n=2, values="0.1 0.2").replace("OF G", "OF CM"), "does not state UNITS OF G"),
        ("a.csv", "acceleration [g]\n0.1\n0.2\n0.15\n0.3\n", "time"),
        ("a.csv", "time [s],acceleration\n0,0.1\n0.01,0.2\n0.02,0.1\n0.03,0.1\n", "states no unit"),
        ("a.csv", "time [s],acceleration [mm]\n0,0.1\n0.01,0.2\n0.02,0.1\n0.03,0.1\n", "no unit of an accel"),
        ("a.csv", "time [s],a [g]\n0,0.1\n0.01,nan\n0.02,0.1\n0.03,0.1\n", "no numbers, the first at 0.01 s"),
        ("a.csv", "time [s],a [g],b [g]\n0,0.1,1\n0.01,0.2,1\n0.02,0.1,2\n", "keep one acceleration"),
        ("a.csv", "time [s],a [g]\n0,98.1\n0.01,-981\n0.02,50\n0.03,1\n", "reaches 981 g"),
        ("a.csv", "time [s],a [g]\n0,0.1\n1,0.2\n2,0.1\n3,0.2\n", "sampled every 1 s"),
    ],
)
def test_a_bad_motion_is_one_line(tmp_path, name, text, told):
    (tmp_path / name).write_text(text)
    motions, (wrong,) = ground_motions_in(tmp_path)
    assert motions == []
    assert told in str(wrong)
    assert "\n" not in str(wrong)
    with pytest.raises(FreerockError):
        read_motion(tmp_path / name)


def test_no_motion_is_said(tmp_path):
    assert "holds no ground motion" in str(ground_motions_in(tmp_path)[1][0])
    assert "no such folder" in str(ground_motions_in(tmp_path / "elsewhere")[1][0])


def test_a_rigid_block_stays_below_the_acceleration_that_lifts_it_and_falls_under_a_long_pulse():
    """Half a sine of a, long against 1/p, overturns above g b/h (1 + ...): here at twice g tan θ_cr."""
    t = np.arange(0, 6, 0.005)
    half = np.sin(np.pi * np.clip((t - 3) / 1.5, 0.0, 1.0))  # the motion is followed to its end
    table = respond(
        "housner", BLOCK, [{"r": 0.9}], [Accelerogram("pulse", t, half * GRAVITY * 0.25)], [0.99, 2.0]
    )
    assert table["max_theta_ratio"][0] == 0.0
    assert table["overturned"].tolist() == [0.0, 1.0]


def test_an_ensemble_is_the_same_whatever_the_batches_and_tolerances_agree_as_ensembles():
    laws = [(dict(zip(SCENE, ("c", "t", "b", "f", "hunt_crossley"), strict=True)), HC)]
    motions = [shaken(i, 0.45) for i in range(8)]
    blocks = {"b": {"height_m": 0.28, "width_m": 0.07, "mass_kg": 5.84}}
    whole = make_responses(laws, blocks, motions, (0.8, 1.2), 5)
    parts = [make_responses(laws, blocks, motions[i : i + 3], (0.8, 1.2), 5) for i in (0, 3, 6)]
    pd.testing.assert_frame_equal(whole, pd.concat(parts, ignore_index=True))
    finer = respond("hunt_crossley", BLOCK, drawn("hunt_crossley", HC, 5), motions, (0.8, 1.2), rtol=1e-8)
    assert whole["overturned"].mean() == pytest.approx(finer["overturned"].mean(), abs=0.08)


HC = {"k": KnownParameter(6.9e6, 2e5), "lambda": KnownParameter(1.3e8, 5e6)}


@pytest.mark.slow
def test_each_draw_answers_each_motion():
    motions = [shaken(i, 0.5, band=(3.0, 9.0)) for i in range(4)]
    for model, known in (("housner", {"r": KnownParameter(0.93, 0.01)}), ("hunt_crossley", HC)):
        table = respond(model, BLOCK, drawn(model, known, 10), motions)
        assert len(table) == 40
        assert table["overturned"].mean() < 0.9  # most are followed to the end


def test_draws_begin_with_the_means_and_have_their_spread():
    sets = drawn("hunt_crossley", HC, 4000, seed=3)
    assert sets[0] == {"k": 6.9e6, "lambda": 1.3e8}
    assert np.std([np.log(each["k"]) for each in sets]) == pytest.approx(2e5 / 6.9e6, rel=0.05)
    assert sets == drawn("hunt_crossley", HC, 4000, seed=3)
    with pytest.raises(FreerockError, match="lambda is missing"):
        drawn("hunt_crossley", {"k": HC["k"]}, 2)


@pytest.mark.slow
def test_a_lognormal_is_found_and_its_interval_holds_the_truth(monkeypatch):
    """Sixteen sets of falls by a known curve, five responses to each of 40 motions that share their luck."""
    monkeypatch.setattr("freerock.response.fragility.RESAMPLES", 40)
    hits, median, beta = 0, 0.4, 0.35
    for seed in range(16):
        draw = np.random.default_rng(seed)
        x = np.geomspace(0.1, 1.5, 40)[:, None] * np.ones(5)
        fell = (draw.uniform(size=40)[:, None] < ndtr(np.log(x / median) / beta)).astype(float)
        table = pd.DataFrame({"pga_g": x.ravel(), "overturned": fell.ravel()})
        table["motion"] = np.repeat([f"m{i}" for i in range(40)], 5)
        found = fragility(table)
        hits += found.low.median <= median <= found.high.median
        assert found.counted["n"].sum() == 200
    assert hits >= 14
    many = np.random.default_rng(1).uniform(0.1, 1.5, 40000)
    fell = (np.random.default_rng(2).uniform(size=many.size) < ndtr(np.log(many / median) / beta)).astype(
        float
    )
    assert fit_lognormal(many, fell) == pytest.approx((median, beta), rel=0.02)


def test_a_block_that_never_falls_has_a_share_and_no_curve():
    laws = [(dict(zip(SCENE, ("c", "t", "b", "f", "housner"), strict=True)), {"r": KnownParameter(0.9)})]
    blocks = {"b": {"height_m": 0.28, "width_m": 0.07, "mass_kg": 5.84}}
    table = fragility_table(make_responses(laws, blocks, [shaken(1, 0.1)], (1.0,), 3))
    assert set(table["kind"]) == {"none"}
    assert table["probability"].tolist() == [0.0, 0.0]
    assert table["n"].tolist() == [3, 3]


def test_a_record_without_a_law_has_a_row_that_says_so():
    """Absence would read as safety."""
    scene = dict(zip(SCENE, ("c", "01", "b", "f", "housner"), strict=True))
    blocks = {"b": {"height_m": 0.28, "width_m": 0.07, "mass_kg": 5.84}}
    records = [
        {"campaign": "c", "test": test, "block": "b", "foundation": "f"} for test in ("00", "01", "02")
    ]
    responses = make_responses([(scene, {"r": KnownParameter(0.9)})], blocks, [shaken(1, 0.1)], (1.0,), 3)
    table = fragility_table(responses, records)
    assert table["test"].tolist() == ["01", "01", "00", "02"]
    assert table["kind"].tolist() == ["none", "none", "no_law", "no_law"]
    assert table.loc[2:, ["model", "probability", "median"]].isna().all(axis=None)
    nothing = fragility_table(make_responses([], {}, [], (1.0,), 1), records)
    assert nothing["test"].tolist() == ["00", "01", "02"] and set(nothing["kind"]) == {"no_law"}

    shown = overturning_table(table, {})
    assert [[cell.text for cell in row[3:7]] for row in shown.rows[2:]] == [
        ["no law", "–", "not known", ""]
    ] * 2
    assert "whether its block overturns is not known" in shown.notes[-1]
    assert len(overturning_table(table[:2], {}).notes) == 1


def test_the_law_that_most_runs_name_is_taken_with_the_spread_of_the_next_run():
    choice = pd.DataFrame(
        {
            "test": ["a", "a", "a", "b"],
            "model": ["winkler", "housner", "housner", "housner"],
            "status": ["selected", "selected", "selected", "rejected"],
            "explains": [True, True, True, False],
        }
    )
    row = {
        "campaign": "c",
        "level": "record",
        "test": "a",
        "block": "x",
        "foundation": "f",
        "model": "housner",
    }
    row |= {"parameter": "r", "mean": 0.93, "u_total": 0.003, "tau": 0.004}
    ((scene, known),) = known_laws(choice, pd.DataFrame([row]))
    assert (scene["test"], scene["model"]) == ("a", "housner")
    assert known["r"] == KnownParameter(0.93, math.hypot(0.003, 0.004))
    ((_, known),) = known_laws(choice, pd.DataFrame([row]), "mean")
    assert known["r"].u == 0.003
    assert make_responses([], {}, [], (1.0,), 1).empty


def test_the_intervals_of_shares_are_wilsons():
    """Against scipy's, group by group."""
    n = 12
    x = np.exp(np.linspace(-1, 1, n * GROUPS))
    fell = (np.random.default_rng(1).uniform(size=x.size) < np.linspace(0, 1, x.size)).astype(float)
    counted = _counted(x, fell, np.arange(x.size))
    assert len(counted) == GROUPS
    for i, row in enumerate(counted.itertuples()):
        k = int(fell[n * i : n * (i + 1)].sum())
        ends = binomtest(k, n).proportion_ci(method="wilson")
        assert (row.probability, row.n) == (pytest.approx(k / n), n)
        assert (row.low, row.high) == (pytest.approx(ends.low, abs=1e-9), pytest.approx(ends.high, abs=1e-9))
