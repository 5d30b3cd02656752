"""Rivals before a test: against fits of noisy runs, and what a campaign says of them."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from freerock.config.keys_of_plan import SensorSection
from freerock.errors import FreerockError
from freerock.figures.plan_pages import draw_rivals
from freerock.figures.style import save
from freerock.identification.fit import fit_run
from freerock.models.laws import LAWS, PAPER_MODELS
from freerock.planning.plan import CASE_COLUMNS, RIVALS, Choices, Setup, plan, plan_rivals
from freerock.planning.rivals import Rival, best_rival, expected_motion, rivals_of
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.sensor import Laser
from freerock.runs.motion import Motion
from freerock.tables.plan_text import _sentence, rivals_text
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS

CONFIG1, CONFIG2, CONFIG3 = (CONFIGURATIONS[f"config{n}"][0] for n in (1, 2, 3))
BOTH = ("guided", "pivoting")


@pytest.mark.parametrize(
    "model, laws, kinematics, rivals",
    [
        ("housner", PAPER_MODELS, BOTH, set()),
        ("hunt_crossley", PAPER_MODELS, ("guided",), {"winkler", "housner_width"}),
        (
            "hunt_crossley_pivoting",
            PAPER_MODELS,
            BOTH,
            {"winkler", "hunt_crossley", "winkler_pivoting", "housner_width"},
        ),
        ("hunt_crossley_pivoting", ("winkler",), ("guided",), {"winkler"}),
        ("hunt_crossley_pivoting", ("hunt_crossley",), ("pivoting",), {"hunt_crossley"}),
        ("winkler_width", ("housner", "winkler"), ("guided",), {"housner_width", "winkler"}),
        (
            "general",
            LAWS,
            ("guided",),
            {"housner_width", "winkler_width", "hunt_crossley_width", "hardening", "viscoelastic"},
        ),
    ],
)
def test_rivals_free_no_more_and_none_is_a_case_of_another(model, laws, kinematics, rivals):
    assert set(rivals_of(model, laws, kinematics)) == rivals


@pytest.mark.parametrize(
    "model, block, parameters",
    [
        ("hunt_crossley_pivoting", CONFIG3, FOUNDATIONS["marble"]),
        ("winkler", CONFIG2, {"k": 6.77e6, "c": 2.17e4}),
        ("housner_width", replace(CONFIG2, contact_width_m=0.0637), {"r": 0.95}),
    ],
)
def test_nothing_is_nearer_than_the_truth(model, block, parameters):
    motion = expected_motion(model, block, parameters, math.radians(9), (0.03, 4.0))
    found = best_rival(model, replace(block, contact_width_m=None), motion)
    assert found.epsilon_theta < 1e-9
    for name, value in {**parameters, "theta0": math.radians(9)}.items():
        assert found.values[name] == pytest.approx(value, rel=1e-3)


def test_a_worn_block_is_near_a_compliant_foundation():
    """Corners worn by 9 % look like the marble of table 2, within a quarter, to a fit of the full width."""
    worn = replace(CONFIG2, contact_width_m=0.91 * CONFIG2.width_m)
    motion = expected_motion("housner_width", worn, {"r": 0.95}, math.radians(10), (0.0, 8.0))
    found = best_rival("hunt_crossley", CONFIG2, motion)
    assert 1e-3 < found.epsilon_theta < 5e-3
    assert {name: found.values[name] for name in ("k", "lambda")} == pytest.approx(
        FOUNDATIONS["marble"], rel=0.25
    )


def test_the_difference_is_that_of_noisy_fits():
    """Mean difference of the criteria of 8 pairs of fits, within 3.3 standard errors of the prediction."""
    block, parameters, angle, rate = CONFIG1, FOUNDATIONS["aerstop"], math.radians(3), 500.0
    sigma = math.radians(0.02)
    motion = expected_motion("hunt_crossley_pivoting", block, parameters, angle, (0.0, 4.0))
    rival = best_rival("hunt_crossley", block, motion)
    time_s = np.arange(0.0, motion.time_s[-1], 1 / rate)
    exact = np.interp(time_s, motion.time_s, motion.theta)
    expected = rival.bic_difference(4, sigma, rate)
    assert 10 < expected < 200  # neither drowned nor so far that the criterion is no longer quadratic
    differences = []
    for seed in range(8):
        noisy = exact + np.random.default_rng(seed).normal(0, sigma, len(exact))
        run = Motion(time_s, noisy, sigma, angle)
        bic = [fit_run(model, block, run).bic for model in ("hunt_crossley", "hunt_crossley_pivoting")]
        differences.append(bic[0] - bic[1])
    spread = 2 * rival.distance(sigma, rate) / math.sqrt(8)
    assert np.mean(differences) == pytest.approx(expected, abs=3.3 * spread)


def test_distance_and_penalty():
    rival = Rival("winkler", {"k": 1e6, "c": 1e4, "theta0": 0.1, "t0": 0.0}, 4e-8, 1e-4, 2.0)
    assert rival.distance(1e-4, 1000.0) == pytest.approx(math.sqrt(4e-5) / 1e-4)
    assert rival.bic_difference(5, 1e-4, 1000.0) == pytest.approx(4000 - math.log(2000))


def test_an_expected_motion_ends_soon_after_the_block_has_come_to_rest():
    motion = expected_motion("housner", CONFIG2, {"r": 0.9}, 0.1, (0.0, 60.0))
    moving = motion.time_s[np.abs(motion.theta) > 1e-4]
    assert motion.time_s[-1] == pytest.approx(1.1 * moving[-1], rel=0.02)


def test_a_block_that_overturns_has_no_rivals():
    with pytest.raises(FreerockError) as caught:
        expected_motion("hunt_crossley", CONFIG2, {"k": 1e4, "lambda": 1e5}, math.radians(10), (0.0, 2.0))
    assert str(caught.value) == (
        "plan: hunt_crossley released at 10°: overturned; plan for a smaller angle or a stiffer foundation"
    )


def table(expected, angles=(10,), **options):
    setup = Setup(
        ("b", "f", "l"), Laboratory(CONFIG2, {"l": Laser("horizontal", 0.2, 0.1)}), expected, angles
    )
    choices = Choices(
        {"fine": SensorSection(noise_v=0.002), "coarse": SensorSection(noise_deg=2.0)}, **options
    )
    return plan_rivals([setup, setup], choices), plan([setup], choices)


def test_rivals_of_a_campaign_in_a_table_in_words_and_drawn(tmp_path):
    expected = {"hunt_crossley": FOUNDATIONS["marble"], "housner": {"r": 0.95}}
    frame, _ = table(expected, (5, 10), sampling_rates_hz=(500, 2000), durations_s=(2,))
    assert list(frame.columns) == RIVALS
    assert len(frame) == 2 * 2 * 2 * 4 and set(frame["model"]) == {"hunt_crossley"}
    assert not frame.duplicated([*CASE_COLUMNS, "rival"]).any()
    fine = frame[frame["sensor"] == "fine"]
    assert fine["told_apart"].all() and not frame[frame["sensor"] == "coarse"]["told_apart"].all()
    by_rate = fine.groupby("sampling_rate_hz")["bic_difference"].sum()
    assert by_rate[2000] == pytest.approx(4 * by_rate[500], rel=1e-3)
    text = rivals_text(frame, {"b": "Slender"})
    assert text.startswith("Δ of the nearest rival (ε_θ between the two), Slender, f, l, 2 s, 500 Hz\n")
    (line,) = (each for each in text.splitlines() if "Housner, width free" in each)
    assert line.startswith("Hunt–Crossley against Housner, width free: told apart in ")
    pages, data = draw_rivals(frame)
    save(pages, data, tmp_path / "rivals")
    assert len(pages) == 1 and len(pages[0].axes) == 4


def test_a_rival_is_told_apart_best_where_it_is_furthest():
    rows = pd.DataFrame({"where": ["near", "far", "lost"], "epsilon_theta": [0.02, 0.05, 0.01]})
    rows = rows.assign(bic_difference=[30.0, 90.0, 2.0], told_apart=[True, True, False])
    best, least = "far (Δ = 90, ε_θ = 5 %)", "lost (Δ = 2, ε_θ = 1 %)"
    assert _sentence("a against b", rows) == (
        f"a against b: told apart in 2 of 3, best by {best}; least by {least}"
    )


def test_a_law_that_does_not_hold_exactly_tells_no_rival_that_is_nearer():
    expected = {"hunt_crossley_pivoting": FOUNDATIONS["marble"]}
    frame, _ = table(expected, durations_s=(2,), model_error=5e-3)
    fine = frame[frame["sensor"] == "fine"].set_index("rival")
    assert fine["bic_difference"].min() > 1000
    assert fine["told_apart"].to_dict() == (fine["epsilon_theta"] > 5e-3).to_dict()
    assert not fine.loc["hunt_crossley", "told_apart"]
    pair = "Hunt–Crossley, pivoting against Hunt–Crossley"
    assert f"{pair}: told apart in 0 of 2; least by " in rivals_text(frame)


def test_a_worn_block_is_planned_with_its_width():
    frame, errors = table({"housner_width": {"r": 0.95, "width_fraction": 0.9}}, durations_s=(4,))
    foundations = {"winkler", "hunt_crossley", "winkler_pivoting", "hunt_crossley_pivoting"}
    assert set(frame["rival"]) == {"housner", *foundations}
    width = errors[(errors["parameter"] == "width") & (errors["sensor"] == "fine")].iloc[0]
    assert width["value"] == pytest.approx(0.9 * CONFIG2.width_m)
    assert 0 < width["stderr"] < 1e-4 * width["value"]


def test_what_cannot_be_measured_is_said():
    frame, _ = table({"hunt_crossley": {"k": 1e4, "lambda": 1e5}}, durations_s=(2,))
    assert frame["bic_difference"].isna().all() and not frame["told_apart"].any()
    assert set(frame["note"]) == {"hunt_crossley released at 10°: overturned"}
    assert "–" in rivals_text(frame)
    draw_rivals(frame)
