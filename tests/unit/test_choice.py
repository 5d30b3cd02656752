"""Which law the runs of a record need, and what is said of its fits."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scattered import BLOCK, SIGMA, TRUTH, scattered_run

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification import start
from freerock.identification.fit import Followers, fit_record
from freerock.identification.run_model import Point, RunModel
from freerock.identification.scatter import Scatter
from freerock.identification.start import START, Followed
from freerock.models import laws
from freerock.models.simulate import Solver, simulate_fitted
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.view import view_of
from freerock.selection.candidates import Allowed, contains, n_numbers
from freerock.selection.choice import choose
from freerock.selection.identify import identify_record
from freerock.selection.prediction import compared, errors_of_swings
from freerock.selection.reasons import line_hz, of_swings, reasons_of_fit, trend

LAWS = Allowed(("housner", "winkler", "hunt_crossley"), ("guided", "pivoting"))


def runs(candidate, sigma_r, seeds=(1, 2)):
    return {run: scattered_run(candidate, sigma_r, seed)[0] for run, seed in enumerate(seeds)}


@pytest.fixture(scope="module")
def found():
    return identify_record(BLOCK, runs("hunt_crossley", 0.01), LAWS)


def test_no_law_is_ruled_out_before_its_search_has_ended(monkeypatch):
    monkeypatch.setattr(start, "START", replace(START, quick=(8, 0.99)))  # a glimpse that ends too soon
    found = identify_record(BLOCK, runs("winkler", 0.01, [2]), Allowed(LAWS.laws, ()))
    assert found.choice.selected == "winkler"
    assert "winkler" not in found.ruled_out
    (share,) = re.findall(r"leaves (\S+) times", found.ruled_out["hunt_crossley"])
    assert float(share) == pytest.approx(1.63, rel=0.03)  # 3.9 of the glimpses


@pytest.mark.slow
@pytest.mark.parametrize("candidate", ["winkler", "housner", "hunt_crossley_pivoting"])
@pytest.mark.parametrize("sigma_r", [0.0, 0.01])
def test_the_true_law_is_chosen_whether_impacts_scatter_or_not(candidate, sigma_r):
    choice = identify_record(BLOCK, runs(candidate, sigma_r), LAWS).choice
    assert candidate in (choice.selected, *choice.also_possible)
    assert choice.level == "noise" and choice.criterion == "evidence" and choice.explained


def test_every_law_has_numbers_and_the_papers_fit(found):
    assert found.choice.selected == "hunt_crossley"
    for law in LAWS.laws:
        for fit in found.fits[law].values():
            assert np.isfinite(fit.value).all() and (fit.u_total > 0).all()
    assert found.paper.keys() == {0, 1}
    for own in found.paper.values():
        assert own.keys() == {*LAWS.laws}
    winkler = found.fits["winkler"][0]
    assert not winkler.evidence.agrees and winkler.evidence.residual_over_noise > 1.2


@pytest.mark.slow
@pytest.mark.parametrize(("of", "stage"), [(Followed, "_posed"), (Followed, "whole"), (Followers, "ends")])
def test_a_candidate_whose_fit_fails_takes_no_other_with_it(of, stage, monkeypatch):
    own = getattr(of, stage)

    def fails(self, *given):
        model = self.model if of is Followed else self.models[1]
        if model.candidate == "winkler":
            raise FreerockError("fits", "no motion", "none")
        return own(self, *given)

    monkeypatch.setattr(of, stage, fails)
    motion = scattered_run("winkler", 0.0, 3)[0]
    found = identify_record(BLOCK, {1: motion}, Allowed(["winkler", "hunt_crossley"], []))
    assert "no motion" in found.missing["winkler"] and "hunt_crossley" in found.fits


def test_candidates_are_at_most_fourteen_few_numbers_first():
    names = Allowed(tuple(laws.LAWS), ("guided", "pivoting")).candidates
    assert len(names) == 14 and [*map(n_numbers, names)] == sorted(map(n_numbers, names))
    assert names[0] == "housner" and n_numbers("winkler_width") == 3 and n_numbers("general") == 3
    assert Allowed(("winkler",), ()).candidates == ("winkler",)
    assert contains("general", "winkler") and contains("winkler_width", "winkler")
    assert not contains("winkler", "general") and not contains("general", "winkler_pivoting")
    tensionless = Allowed(("general", "winkler"), ("guided",), options={"debonding": "tensionless"})
    assert "general" not in tensionless.candidates


@pytest.mark.slow
def test_where_no_law_agrees_prediction_decides_and_numbers_stay():
    """A motion that no law makes: a table swings beneath, and the runs scatter."""
    shaken = {}
    for run, motion in runs("hunt_crossley", 0.01, (1, 2, 3)).items():
        swing = 3 * SIGMA * np.sin(40 * motion.time_s + run)
        shaken[run] = replace(motion, theta=motion.theta + swing)
    found = identify_record(BLOCK, shaken, LAWS)
    choice = found.choice
    assert choice.selected == "hunt_crossley" and choice.criterion == "prediction"
    assert choice.level == "repeatability"
    for fit in found.fits["hunt_crossley"].values():
        k = TRUTH["hunt_crossley"]["k"]
        assert not fit.evidence.agrees and fit.uncertainty.u_law[0] > 0
        assert abs(fit.values["k"] - k) < 3.3 * fit.u_total[0]
        assert line_hz(fit) == pytest.approx(40 / (2 * np.pi), rel=0.2)
    names = [each.name for each in reasons_of_fit(shaken[0], found.fits["hunt_crossley"][0], choice)]
    assert "model_error" in names and "unexplained" not in names


def test_without_a_usable_fit_nothing_is_chosen(found):
    failed = {"winkler": {0: replace(found.fits["winkler"][0], success=False, message="lost")}}
    choice = choose(failed, {"housner": "not tried"})
    assert choice.selected == "" and choice.level == "none" and not choice.explained
    assert [each.status for each in choice.judged] == ["not_fitted", "not_fitted"]


def test_a_law_that_first_swings_reject_is_no_choice_beside_one_that_leaves_only_noise(found):
    true = found.fits["hunt_crossley"]
    alike = {
        run: replace(fit, evidence=replace(fit.evidence, minus_two_log=fit.evidence.minus_two_log - 50))
        for run, fit in true.items()
    }
    fits, why = {"winkler": alike, "hunt_crossley": true}, {"winkler": "on the first swings"}
    assert choose(fits, {}).selected == "winkler"
    choice = choose(fits, {}, why)
    assert choice.selected == "hunt_crossley" and not choice.also_possible
    assert [each.reason for each in choice.judged if each.model == "winkler"] == ["on the first swings"]
    assert choose({"winkler": alike}, {}, why).selected == "winkler"
    assert "winkler" in found.ruled_out and "hunt_crossley" not in found.ruled_out


def test_the_right_law_predicts_the_swings_of_a_run_left_out(found):
    right, wrong = (errors_of_swings(found.fits[law]) for law in ("hunt_crossley", "housner"))
    told = compared(right, wrong)
    assert told.ratio < 0.5 and told.p < 0.01
    assert compared(right, right).p > 0.5


def test_a_trend_of_delta_over_amplitude_is_seen_and_none_is_not(found):
    motion = runs("hunt_crossley", 0.01)[0]
    fit = found.fits["hunt_crossley"][0]
    amplitude, side = of_swings(motion, len(fit.scatter.delta))
    assert (np.diff(amplitude) < 0).all() and set(side) == {-1.0, 1.0}
    assert trend(fit, amplitude)[1] > 1e-3 and trend(fit, side)[1] > 1e-3


def test_a_loss_that_differs_by_side_is_said():
    motion, _ = scattered_run("hunt_crossley", 0.0, 7)
    delta = 0.003 * np.random.default_rng(1).standard_normal(40) + 0.02 * (-1.0) ** np.arange(40)
    values = {**TRUTH["hunt_crossley"], "theta0": 0.17, "t0": 0.0, "impacts": delta}
    theta = simulate_fitted("hunt_crossley", BLOCK, values, motion.time_s, solver=Solver(1e-10))
    noise = SIGMA * np.random.default_rng(2).standard_normal(theta.size)
    uneven = replace(motion, theta=theta + noise, theta0=0.17)
    fits = fit_record("hunt_crossley", BLOCK, {1: uneven})
    choice = choose({"hunt_crossley": fits}, {})
    names = [each.name for each in reasons_of_fit(uneven, fits[1], choice)]
    assert "loss_by_side" in names and "loss_by_amplitude" not in names


def test_an_input_that_is_pulled_is_said():
    """A rigid block is 0.5 % lower than stated, to 0.1 %."""
    wrong = replace(BLOCK, height_m=1.005 * BLOCK.height_m)
    inputs = (Input("block", "height_m", 1e-3 * BLOCK.height_m, True),)
    laboratory = Laboratory(wrong, {"laser": Laser("horizontal", 0.2, 0.1)}, inputs)
    motion = replace(scattered_run("housner", 0.0, 3)[0], laboratory=laboratory)
    fits = fit_record("housner", wrong, {1: motion})
    reasons = [*reasons_of_fit(motion, fits[1], choose({"housner": fits}, {}))]
    pulled = [each for each in reasons if each.name == "pulled_input"]
    assert pulled and pulled[0].verdict == "warn" and "height_m of block" in pulled[0].text


@pytest.mark.parametrize(("off", "birge"), [(0.0, 1.0), (6.0, 6.0)])
def test_where_inputs_are_pulled_u_grows_to_hold_the_truth(off, birge):
    """A block is wider than stated by so many of its standard uncertainties."""
    inputs = (Input("block", "width_m", 1e-3 * BLOCK.width_m, True),)
    laboratory = Laboratory(BLOCK, {"laser": Laser("horizontal", 0.2, 0.1)}, inputs)
    plain, delta = scattered_run("hunt_crossley", 0.01, 3)
    motion = replace(plain, laboratory=laboratory, view=view_of([*laboratory.lasers.values()], BLOCK))
    true = Point({**TRUTH["hunt_crossley"], "theta0": 0.17, "t0": 0.0}, np.array([off]), delta)
    read = RunModel("hunt_crossley", BLOCK, motion, FitSettings()).curve(true, motion.time_s, 1e-10)
    noisy = read + SIGMA * np.random.default_rng(1).standard_normal(read.size)
    fit = fit_record("hunt_crossley", BLOCK, {1: replace(motion, theta=noisy)})[1]
    assert fit.posterior.birge == pytest.approx(birge, rel=0.3)
    assert abs(fit.values["k"] - TRUTH["hunt_crossley"]["k"]) < 1.96 * fit.u_total[0]


def test_a_release_elsewhere_and_a_large_scatter_warn(found):
    fit, motion = found.fits["hunt_crossley"][0], runs("hunt_crossley", 0.01)[0]
    late = replace(fit, values={**fit.values, "t0": 0.05})
    loose = replace(fit, scatter=replace(fit.scatter, of_record=Scatter(0.1, 0.06, 0.2, 8.0)))
    named = {
        each: {reason.name for reason in reasons_of_fit(motion, one, found.choice)}
        for each, one in (("plain", fit), ("late", late), ("loose", loose))
    }
    assert named["late"] - named["plain"] == {"pulled_release"}
    assert named["loose"] - named["plain"] == {"large_scatter"}
