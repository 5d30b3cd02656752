"""Which candidates a run is fitted with, and which of them is named."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.identification.fit import fit_record
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, LAWS, law_of
from freerock.selection import hypotheses_tried
from freerock.selection.allowed_hypotheses import BY_DEFAULT, NOT_TRIED
from freerock.selection.choice import evidence
from freerock.selection.hypotheses_tried import identify_run
from freerock_bench.virtual_run import Truth, virtual_motion

BLOCK = Block(0.28, 0.07, 5.84)
SQUAT = Block(0.14, 0.07, 2.98)
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}
PAPER = ["housner", "winkler", "hunt_crossley"]


def motion_of(truth, seed=1):
    return virtual_motion(truth, np.random.default_rng(seed))


def released(model, block, parameters, degrees):
    return Truth(model, block, parameters, math.radians(degrees), math.radians(0.006))


def test_what_housner_explains_costs_no_foundation_but_the_papers():
    found = identify_run(BLOCK, motion_of(released("housner", BLOCK, {"r": 0.93}, 8)), BY_DEFAULT)
    choice = found.choice(BY_DEFAULT)
    assert (choice.selected, choice.explained) == ("housner", True)
    assert list(found.fits) == PAPER
    assert not any(law_of(model).is_foundation for model in found.ruled_out)


def test_beds_that_have_become_rigid_are_not_extended():
    """A rigid block that is shorter than stated: no law explains it, beds end at the largest stiffness."""
    shorter = replace(BLOCK, height_m=0.27)
    found = identify_run(BLOCK, motion_of(released("housner", shorter, {"r": 0.93}, 8)), BY_DEFAULT)
    assert not found.explained
    assert found.fits["hunt_crossley"].values["k"] > 1e10
    foundations = {model for model in (*found.fits, *found.ruled_out) if law_of(model).is_foundation}
    assert foundations == {"winkler", "hunt_crossley"}
    left = {each.reason for each in found.choice(BY_DEFAULT).judged if each.status == "not_fitted"}
    assert left == {f"{NOT_TRIED}no candidate that it extends has a good enough fit"}


def test_a_small_candidate_that_a_law_of_the_paper_surpasses_does_not_end_the_search():
    """A foundation near to rigid under a coarse sensor: Housner leaves only noise, a guided law far less."""
    stiff = {"k": 3.1e8, "lambda": 1.5e10}
    truth = replace(released("hunt_crossley_pivoting", SQUAT, stiff, 20), sigma_theta=math.radians(2))
    for seed in (1, 2):
        found = identify_run(SQUAT, motion_of(truth, seed), BY_DEFAULT)
        assert evidence(found.fits["housner"]).explains
        choice = found.choice(BY_DEFAULT)
        assert {choice.selected, *choice.also_possible} == {"hunt_crossley", "hunt_crossley_pivoting"}


def test_worn_corners_are_found_before_any_larger_candidate():
    worn = replace(BLOCK, contact_width_m=0.91 * BLOCK.width_m)
    found = identify_run(BLOCK, motion_of(released("housner", worn, {"r": 0.93}, 8)), BY_DEFAULT)
    choice = found.choice(BY_DEFAULT)
    assert (choice.selected, choice.also_possible) == ("housner_width", ())
    assert found.fits["housner_width"].values["width"] == pytest.approx(worn.contact_width_m, rel=1e-3)
    tried = [*found.fits, *found.ruled_out]
    assert max(map(BY_DEFAULT.n_freed, tried)) == BY_DEFAULT.n_freed("housner_width")


@pytest.mark.parametrize("model", ["hunt_crossley", "hunt_crossley_pivoting"])
def test_the_kinematics_of_a_squat_block_is_told(model):
    found = identify_run(SQUAT, motion_of(released(model, SQUAT, MARBLE, 15)), BY_DEFAULT)
    choice = found.choice(BY_DEFAULT)
    assert (choice.selected, choice.also_possible) == (model, ())
    fit = found.fits[model]
    assert abs(fit.values["k"] - MARBLE["k"]) < 4 * fit.stderr[0]
    assert {each.evidence.model for each in choice.judged} == {*BY_DEFAULT.candidates}
    assert all(each.reason for each in choice.judged)


def test_both_dampings_are_fitted_where_no_smaller_law_leaves_noise_only():
    both = MARBLE | {"c": 1e4}
    found = identify_run(BLOCK, motion_of(released("general", BLOCK, both, 8)), BY_DEFAULT)
    assert found.choice(BY_DEFAULT).selected == "general"
    alone = identify_run(BLOCK, motion_of(released("hunt_crossley", BLOCK, MARBLE, 8)), BY_DEFAULT)
    assert "general" not in alone.fits


def test_far_from_all_candidates_one_rival_at_most_is_fitted_in_full():
    motion = motion_of(released("hunt_crossley", BLOCK, MARBLE, 8))
    bent = replace(motion, theta=motion.theta * (1 + 0.1 * np.sin(3 * motion.time_s)))
    found = identify_run(BLOCK, bent, BY_DEFAULT)
    assert not found.explained
    assert len([model for model in found.fits if model not in PAPER]) <= 1
    assert {*found.fits, *found.ruled_out, *found.errors} == {*BY_DEFAULT.candidates}
    choice = found.choice(BY_DEFAULT)
    assert choice.selected and not choice.explained


def test_a_rival_whose_full_fit_fails_is_not_fitted_again(monkeypatch):
    fitted = []

    def failing(model, block, motions, settings, **options):
        fitted.append((model, settings))
        fit = fit_record(model, block, motions, settings, **options)
        return replace(fit, success=False) if CANDIDATES[model].is_rival else fit

    monkeypatch.setattr(hypotheses_tried, "fit_record", failing)
    motion = motion_of(released("hunt_crossley_pivoting", SQUAT, MARBLE, 18))
    bent = replace(motion, theta=motion.theta * (1 + 1e-3 * np.sin(3 * motion.time_s)))
    found = identify_run(SQUAT, bent, BY_DEFAULT)
    assert not found.explained
    assert len(fitted) == len(set(fitted)) > len(PAPER)


def test_a_start_from_which_the_fit_fails_leaves_the_fits_from_others(monkeypatch):
    motion = motion_of(released("hunt_crossley", BLOCK, MARBLE, 8))
    good = fit_record("hunt_crossley", BLOCK, [motion], BY_DEFAULT.settings("hunt_crossley"))

    def fake(model, block, motions, settings, start):
        if start:
            raise FreerockError("lambda", "is negative", "state it")
        return good

    monkeypatch.setattr(hypotheses_tried, "fit_record", fake)
    search, each = hypotheses_tried._Search(BLOCK, motion, BY_DEFAULT), BY_DEFAULT.of("hunt_crossley", ())
    search.fit(each, [None, {"k": 1.0}])
    assert search.fits == {each: good} and not search.errors
    search.fit(other := BY_DEFAULT.of("winkler", ()), [{"k": 1.0}])
    assert other not in search.fits and "negative" in str(search.errors[other])


def test_without_kinematics_there_is_no_rival():
    hypotheses = replace(BY_DEFAULT, kinematics=())
    found = identify_run(SQUAT, motion_of(released("hunt_crossley_pivoting", SQUAT, MARBLE, 15)), hypotheses)
    assert set(found.fits) <= set(LAWS)
    assert not found.choice(hypotheses).explained


def test_fits_of_a_run_that_nothing_explains_widen_what_leaves_least_whatever_their_release(monkeypatch):
    """A tilted base, of which each fit leaves more than noise, with a release at its bound."""

    def bounded(model, block, motions, settings, **options):
        fit = fit_record(model, block, motions, settings, **options)
        at = fit.parameters.index("theta0")
        stderr = np.where(np.arange(len(fit.stderr)) == at, np.nan, fit.stderr)
        return replace(fit, stderr=stderr, diagnostics=fit.diagnostics | {"noise_p": 0.0, "noise": 0.0})

    hypotheses = replace(BY_DEFAULT, laws=("hunt_crossley",), kinematics=())
    monkeypatch.setattr(hypotheses_tried, "fit_record", bounded)
    motion = motion_of(released("hunt_crossley", BLOCK, MARBLE | {"tilt": 0.01}, 8))
    found = identify_run(BLOCK, motion, hypotheses)
    assert not found.explained and found.widened == ("tilt",)
    assert found.fits["hunt_crossley"].values["k"] == pytest.approx(MARBLE["k"], rel=0.01)


def test_a_widened_prior_with_a_number_at_a_bound_is_not_named(monkeypatch):
    """A block let go lower than it was held needs another release, which may lie at its bound."""

    def bounded(model, block, motions, settings, **options):
        fit = fit_record(model, block, motions, settings, **options)
        at_bound = {"stderr": np.append(fit.stderr[:-1], np.nan)} if settings.loose_release else {}
        return replace(fit, **at_bound)

    hypotheses = replace(BY_DEFAULT, laws=("hunt_crossley",), kinematics=())
    motion = replace(motion_of(released("hunt_crossley", BLOCK, MARBLE, 8)), theta0=math.radians(8.2))
    assert identify_run(BLOCK, motion, hypotheses).widened == ("release",)
    monkeypatch.setattr(hypotheses_tried, "fit_record", bounded)
    found = identify_run(BLOCK, motion, hypotheses)
    assert "release" not in found.widened


def test_a_candidate_that_was_never_tried_says_why():
    """Winkler's law leaves so much that its rival with pivoting corners is not tried."""
    found = identify_run(BLOCK, motion_of(released("hunt_crossley", BLOCK, MARBLE, 8)), BY_DEFAULT)
    why = {each.evidence.model: each.reason for each in found.choice(BY_DEFAULT).judged}
    assert not {"winkler_pivoting", "general"} & {*found.fits, *found.ruled_out, *found.errors}
    assert why["winkler_pivoting"] == "not tried because no candidate that it extends has a good enough fit"
    assert why["general"] == "not tried because a smaller candidate explains the run"
    times = re.search(r"a quick fit leaves ([\d.]+) times the mean square of the best", why["housner_width"])
    assert float(times[1]) > hypotheses_tried.EFFORT.contends
