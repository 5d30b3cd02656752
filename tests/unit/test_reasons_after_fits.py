"""What a run that nothing explains would fit with: the other rule of debonding, or sign of the laser."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.identification.fit import fit_run
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, GEOMETRIC, LAWS, MODEL_LABELS, Rules
from freerock.models.published import BLOCKS, TABLE_2
from freerock.noise.at_rest import noise_at_rest
from freerock.rotation.as_measured import as_measured
from freerock.rotation.beam import displaced, turned
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View
from freerock.runs.motion import Motion
from freerock.runs.verdict import Verdict
from freerock.selection import reasons_after_fits
from freerock.selection.allowed_hypotheses import BY_DEFAULT, Hypotheses
from freerock.selection.hypotheses_tried import identify_run
from freerock.selection.reasons_after_fits import (
    hints_for,
    reasons_of_fits,
    reasons_of_noise,
    with_other_sign,
)

BLOCK = BLOCKS["config2"]
THETA0, SIGMA, RATE_HZ = math.radians(8), math.radians(0.01), 1000.0
LASER = Laser("horizontal", 0.20, 0.1)
VIEW = View(BLOCK, LASER)
TENSIONLESS = Rules("tensionless")


def run(law="winkler", rules=GEOMETRIC, view=None, seen=lambda theta: theta, block=BLOCK, bed=None):
    """A run on a bed, by default the Aerstop of table 2, with white noise, and angles read otherwise than
    they are."""
    law = CANDIDATES[law].law
    generator = np.random.default_rng(3)
    time_s = np.arange(0, 3.5, 1 / RATE_HZ)
    values = {**(bed or TABLE_2["aerstop"][law]), "theta0": THETA0}
    theta = seen(as_measured(law, block, values, time_s, view, rules=rules))
    theta0 = float(seen(np.array([THETA0]))[0])
    noise = noise_at_rest([SIGMA * generator.standard_normal(4000)], RATE_HZ)
    theta += SIGMA * generator.standard_normal(time_s.size)
    return Motion(time_s, theta, SIGMA, theta0, SIGMA / 30, 1e-3, noise=noise, view=view)


def hints(motion, law):
    """Names and texts of what is said of a run that the law alone was fitted to."""
    found = hints_for(BLOCK, motion, {law: fit_run(law, BLOCK, motion)}, BY_DEFAULT.settings)
    return [(each.name, each.text) for each in found]


def test_the_other_rule_of_debonding():
    assert hints(run(rules=TENSIONLESS), "winkler") == [
        (
            "other_debonding",
            "would fit with fits.debonding: tensionless: Winkler then agrees with the noise",
        )
    ]


@pytest.mark.parametrize(
    ("law", "damping", "rules", "names"),
    [("hunt_crossley", {}, TENSIONLESS, {"other_debonding"}), ("general", {"c": 1500.0}, GEOMETRIC, set())],
)
def test_a_further_damping_does_not_hide_that_a_bed_can_not_pull(law, damping, rules, names):
    """General explains a bed of λ alone that can't pull, with c = 89 ± 31 N s/m²."""
    block, bed = Block(0.3, 0.0905, 6.515), {"k": 1.9e6, "lambda": 3.1e7, **damping}
    motion = run(law, rules, block=block, bed=bed)
    general = Hypotheses(("general",), (), {name: law.free for name, law in LAWS.items()})
    found = identify_run(block, motion, general)
    assert found.choice(general).explained
    told = reasons_of_fits(Verdict(()), block, motion, found, general)
    assert {each.name for each in told if each.verdict == "warn"} == names
    assert all("tensionless: Hunt–Crossley then agrees" in each.text for each in told if each.name in names)


def test_rounded_edges_are_not_free_under_the_rule_that_refuses_them(monkeypatch):
    asked = []
    monkeypatch.setattr(
        reasons_after_fits, "leaves_noise", lambda model, block, settings, *_: asked.append(settings) or False
    )
    motion, free = run("hunt_crossley"), {"hunt_crossley": ("theta0", "edge_radius")}
    rounded = Hypotheses(("hunt_crossley",), (), free)
    fit = fit_run("hunt_crossley", BLOCK, motion)
    assert not [*hints_for(BLOCK, motion, {"hunt_crossley": fit}, rounded.settings)]
    assert [(each.debonding, each.free) for each in asked] == [("tensionless", ("theta0",))]


def read_with_the_other_sign(theta):
    return turned(-displaced(theta, BLOCK, LASER), BLOCK, LASER)


@pytest.mark.parametrize("model", ["hunt_crossley", "hunt_crossley_pivoting", "housner"])
def test_the_other_sign_of_the_laser(model):
    motion = run(model, CANDIDATES[model].rules("geometric"), VIEW, read_with_the_other_sign)
    told = f"would fit with the other sign of the laser: {MODEL_LABELS[model]} then agrees with the noise"
    assert hints(motion, model) == [("other_sign", told)]


def test_a_motion_mirrored_twice_is_itself():
    motion = run("hunt_crossley", view=VIEW)
    once = with_other_sign(motion)
    assert once.theta0 < 0 and abs(once.theta0 + THETA0) > 10 * SIGMA
    twice = with_other_sign(once)
    assert twice.theta0 == pytest.approx(THETA0, rel=1e-12)
    assert np.allclose(twice.theta, motion.theta, rtol=0, atol=1e-12)


def test_a_rotation_as_recorded_has_no_other_sign():
    motion = run("hunt_crossley")
    assert with_other_sign(motion) is None
    rotation = View(BLOCK, replace(LASER, beam=None, position_m=None, units="rad"))
    assert with_other_sign(replace(motion, view=rotation)) is None


@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
def test_nothing_is_said_where_neither_helps(law):
    struck = run(law, view=VIEW)
    slower = struck.time_s - 0.1 * np.maximum(struck.time_s - 0.4, 0)
    theta = np.interp(slower, struck.time_s, struck.theta)
    assert hints(replace(struck, theta=theta), law) == []


def test_a_law_without_the_rule_is_left_out_where_another_is_left():
    free = {name: law.free for name, law in LAWS.items()}
    asked = ("winkler", "hunt_crossley", "general")
    options = {"debonding": "tensionless"}
    found = Hypotheses(asked, ("guided", "pivoting"), free, options).candidates
    assert found == tuple(
        name for name in Hypotheses(asked, ("guided", "pivoting"), free).candidates if "general" not in name
    )
    assert Hypotheses(("general",), (), free, options).candidates == ("general",)


def test_a_run_without_a_rest_says_that_its_errors_know_less():
    theta = np.zeros(100)
    seen = Motion(theta, theta, SIGMA, 0.1, noise=noise_at_rest([np.zeros(4000)], RATE_HZ))
    assert reasons_of_noise(seen) == []
    (doubt,) = reasons_of_noise(Motion(theta, theta, SIGMA, 0.1))
    assert (doubt.verdict, doubt.name) == ("warn", "no_rest")
    assert doubt.text.startswith("no rest or hold is long enough to show the noise of the sensor")
