"""A run that something else than the law acted on, told from one under another law."""

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification.start import tops_of
from freerock.runs.motion import Motion
from freerock.runs.verdict import Reason, Verdict, in_one_line
from freerock.selection import reasons_after_fits
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.causes import Cause
from freerock.selection.hypotheses_tried import Identified, identify_run
from freerock.selection.reasons_after_fits import UNEXPLAINED, find_disturbance, reasons_of_fits
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.springs import Motion as Rocking
from freerock_bench.springs import Scene

BLOCK, ANGLE, _ = CONFIGURATIONS["config2"]
SIGMA = math.radians(0.01)
RATE_HZ = 1000


def fitted(foundation, off=1.03, louder=5.0):
    """What the whole run made of the law: parameters that are a little off."""
    values = {name: off * value for name, value in FOUNDATIONS[foundation].items()}
    return {
        "hunt_crossley": SimpleNamespace(
            epsilon_theta=0.01, values=values, diagnostics={"residual_over_sigma": louder}
        )
    }


MISHAPS = {
    "none": {},
    "hit": {"blow": (0.6, 1.0, 0.04)},
    "hit later": {"blow": (0.9, 1.0, 0.04)},
    "pushed": {"rate": 0.06},
    "braked": {"blow": (0.1, 0.5, 0.0)},
    "caught": {"blow": (0.1, 0.0, 0.0)},
    "off level": {"besides": {"tilt": math.radians(0.3)}},
    "rounded": {"base": {"radius_m": 2e-3}},
}


@cache
def run(mishap="none"):
    """A measured run of 3 s in which something besides the law acted."""
    since, differs = np.arange(3 * RATE_HZ) / RATE_HZ, MISHAPS[mishap]
    theta = Rocking(Scene(BLOCK, FOUNDATIONS["aerstop"], False, ANGLE, 1e-7, **differs), RATE_HZ, 3.0).theta
    theta = np.pad(theta, (0, since.size))[: since.size]
    noise = SIGMA * np.random.default_rng(5).standard_normal(since.size)
    return Motion(since, theta + noise, SIGMA, ANGLE, 1e-5, 2e-4)


def found(motion, foundation="aerstop"):
    return find_disturbance(BLOCK, motion, fitted(foundation), lambda model: FitSettings())


def test_tops_are_those_of_the_motion():
    motion = run()
    tops = tops_of(motion)
    assert len(tops) >= 4
    assert [math.copysign(1, top.height) for top in tops[:4]] == [-1, 1, -1, 1]
    for top in tops:
        near = np.abs(motion.time_s - top.time_s) < 0.04
        assert abs(top.height) == pytest.approx(np.abs(motion.theta[near]).max(), abs=5 * SIGMA)


@pytest.mark.parametrize("mishap", ["hit", "hit later"])
def test_a_blow_is_found_between_the_tops_beside_it(mishap):
    at_s, disturbance = MISHAPS[mishap]["blow"][0], found(run(mishap))
    assert disturbance.start_s <= at_s <= disturbance.end_s
    assert disturbance.end_s - disturbance.start_s < 0.5


@pytest.mark.parametrize("mishap", ["pushed", "braked", "caught"])
def test_what_comes_before_the_first_top_is_of_the_release(mishap):
    motion = run(mishap)
    disturbance = found(motion)
    assert disturbance.start_s == 0 < disturbance.end_s == tops_of(motion)[0].time_s


@pytest.mark.parametrize("mishap", ["off level", "rounded"])
def test_what_acts_all_the_time_is_no_disturbance(mishap):
    assert found(run(mishap)) is None


def doubts(motion, *measured, causes=None):
    def chosen(_):
        return SimpleNamespace(selected="")

    known = {"fits": fitted("aerstop"), "causes": causes or {}, "widened": ("edge_radius",)}
    whole = SimpleNamespace(**known, explained=False, choice=chosen)
    return reasons_of_fits(Verdict(measured), BLOCK, motion, whole, BY_DEFAULT)


def test_the_doubts_are_named_and_say_when():
    hit, unexplained = doubts(run("hit"))
    assert (hit.verdict, hit.name, unexplained.name) == ("warn", "disturbed", "unexplained")
    assert "something acted on the block between 0.5" in hit.text and ";" not in hit.text
    unexplained, released = doubts(run("pushed"))
    assert (unexplained.name, released.name) == ("unexplained", "disturbed_release")
    assert "free rocking may begin only 0.5" in released.text


def test_causes_are_numbered_and_shares_of_the_misfit_of_a_named_law(monkeypatch):
    told = [Cause("beds", "the right one stiffer by −1.0 %", 0.19, 1.0, 1.0, {})]
    told.append(Cause("samples", "0.9 lost at 0.87 s", 0.1, 2.0, 1.0, {}))
    monkeypatch.setattr(reasons_after_fits, "odd_contact", lambda *_: [])
    (alone,) = doubts(run("off level"), causes={"winkler": told[1:], "hunt_crossley": told})
    assert alone.text == (
        f"{UNEXPLAINED}. Hunt–Crossley with free edge radius comes nearest if one further cause acts. "
        "Possible causes, with their share of its misfit (measure a cause before you change its setting): "
        "(1) beds, the right one stiffer by −1.0 % (19 %), (2) samples, 0.9 lost at 0.87 s (10 %)"
    )
    assert in_one_line([alone, alone]).count(";") == 1


def test_without_causes_none_is_told():
    tilted = run("off level")
    (alone,) = doubts(tilted)
    assert (alone.name, alone.text) == ("unexplained", UNEXPLAINED)
    (beside,) = doubts(tilted, Reason("warn", "alternating_restitution", "restitution alternates"))
    assert beside.text == UNEXPLAINED


def test_a_run_that_is_explained_or_was_not_fitted_gives_no_doubt():
    motion, hypotheses = run(), replace(BY_DEFAULT, laws=("hunt_crossley",), kinematics=())
    explained = identify_run(BLOCK, motion, hypotheses)
    assert explained.explained
    for whole in (explained, Identified()):
        assert reasons_of_fits(Verdict(), BLOCK, motion, whole, hypotheses) == []


def test_what_is_hardly_more_than_noise_is_not_searched():
    whole = fitted("aerstop", louder=1.1)
    assert find_disturbance(BLOCK, run("hit"), whole, lambda model: FitSettings()) is None


def test_a_run_that_ends_at_once_has_no_tops():
    motion = run()
    short = Motion(motion.time_s[:50], motion.theta[:50], SIGMA, ANGLE)
    assert tops_of(short) == [] and found(short) is None
