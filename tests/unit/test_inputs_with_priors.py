"""Inputs as nuisances: a law explains a run whose inputs are wrong by their own uncertainty.

The motions are those of SciPy's integrator, seen by a laser whose place, block and scale differ from what is
stated.
"""

import math
from dataclasses import replace
from functools import cache

import lmfit
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification import intervals
from freerock.identification.fit import fit_record, fit_run
from freerock.identification.inputs_with_priors import Nuisances
from freerock.identification.least_squares import legal
from freerock.identification.start import posed
from freerock.models.block import GRAVITY, Block
from freerock.models.given import Given
from freerock.models.simulate import simulate_theta
from freerock.noise.at_rest import noise_at_rest
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.u_total import Contributions
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion
from freerock.selection import hypotheses_tried
from freerock.selection.added_uncertainty import beside_others
from freerock.selection.allowed_hypotheses import BY_DEFAULT, Hypothesis
from freerock.selection.choice import evidence
from freerock.selection.hypotheses_tried import at_end_of, freeing, identify_run
from freerock.selection.quick import Screening, narrowed
from freerock.selection.reasons_of_set_up import explains_as_well, pulled_inputs

BLOCK = Block(0.28, 0.07, 5.84)
LASER = Laser("horizontal", 0.2, 0.1)
SIGMA, RATE_HZ, N_REST = math.radians(0.006), 1000, 2000
RULE = {
    "height_m": ("b", 3e-4),
    "width_m": ("b", 3e-4),
    "mass_kg": ("b", 0.00584),
    "position_m": ("l", 6e-4),
    "scale_fraction": ("l", 1e-3),
    "sampling_rate_fraction": ("l", 6e-5),
}
INPUTS = tuple(Input(owner, name, u, True) for name, (owner, u) in RULE.items())
STATED = Laboratory(BLOCK, {"l": LASER}, INPUTS)


def rigid(block, r, theta0, time_s):
    """Housner's block by its equation of motion, apart from the project's closed forms."""
    inertia = block.mass_kg * ((block.width_m**2 + block.height_m**2) / 12 + block.b**2 + block.h**2)
    arm, alpha = block.mass_kg * GRAVITY * math.hypot(block.b, block.h), math.atan2(block.b, block.h)
    theta, start, state, side = np.zeros(len(time_s)), 0.0, [theta0, 0.0], 1.0
    while start < time_s[-1]:

        def moves(_, y, side=side):
            return [y[1], -arm * math.sin(side * alpha - y[0]) / inertia]

        def lands(_, y, side=side):
            return y[0] * side

        lands.terminal, lands.direction = True, -1
        swing = solve_ivp(
            moves,
            (start, time_s[-1]),
            state,
            "DOP853",
            events=lands,
            dense_output=True,
            rtol=1e-10,
            atol=1e-13,
        )
        during = (time_s >= start) & (time_s <= swing.t[-1])
        theta[during] = swing.sol(time_s[during])[0]
        start, side = swing.t[-1], -side
        state = [side * 1e-300, r * swing.y[1, -1]]
    return theta


def measured(seed, drawn=1.0, r=0.93, corners_m=None):
    """A run whose inputs are off by draws of their uncertainty, as the stated inputs read it."""
    draw = np.random.default_rng(seed)
    z = drawn * draw.standard_normal(len(INPUTS))
    true = STATED.at(INPUTS, z)
    block = true.block if corners_m is None else replace(true.block, contact_width_m=corners_m)
    time_s, theta0 = np.arange(0, 3, 1 / RATE_HZ), math.radians(9)
    theta = true.reread(np.append(rigid(block, r, theta0, time_s * true.clock), theta0), STATED)
    error = SIGMA * draw.standard_normal(len(theta) + N_REST)
    moving = min(np.flatnonzero(np.abs(theta[:-1]) > SIGMA)[-1] + 100, len(time_s))
    return z, Motion(
        time_s[:moving],
        theta[:moving] + error[:moving],
        SIGMA,
        float(theta[-1]) + float(error[-N_REST:].mean()),
        3 * SIGMA / math.sqrt(N_REST),
        2e-4,
        noise=noise_at_rest([error[-N_REST:]], RATE_HZ),
        view=view_of([LASER], BLOCK),
        laboratory=STATED,
    )


@pytest.mark.parametrize("seed", range(4))
def test_a_law_explains_a_run_whose_inputs_are_wrong_by_their_uncertainty(seed):
    _, motion = measured(seed)
    found = identify_run(BLOCK, motion, BY_DEFAULT)
    choice = found.choice(BY_DEFAULT)
    assert (choice.selected, choice.explained, found.widened) == ("housner", True, ())
    fit = found.fits["housner"]
    assert fit.contributions is not None
    assert fit.result.success
    assert not fit.result.aborted
    total = fit.contributions.total(fit.stderr)
    assert abs(fit.values["r"] - 0.93) < 3 * total[0]
    assert np.nanmax(np.abs(fit.contributions.pulls)) < 3.5


@cache
def drawn_seventh():
    """A run, and its fit."""
    _, motion = measured(7)
    return motion, fit_run("housner", BLOCK, motion)


def test_with_the_inputs_held_the_same_runs_are_not_explained():
    held = [fit_run("housner", BLOCK, replace(measured(seed)[1], laboratory=None)) for seed in range(4)]
    assert sum(evidence(fit).explains for fit in held) < 4


def test_pulls_are_standard_normal_and_inputs_are_better_known_after_the_fit():
    pulls, inside = [], []
    for seed in range(20):
        _, motion = measured(100 + seed)
        fit = fit_run("housner", BLOCK, motion)
        assert evidence(fit).explains
        found = fit.contributions
        assert np.all(found.remaining < 1.001) and np.min(found.remaining) < 0.7
        pulls += found.pulls[np.isfinite(found.pulls)].tolist()
        inside.append(abs(fit.values["r"] - 0.93) < 1.96 * found.total(fit.stderr)[0])
    assert 0.7 < np.std(pulls) < 1.3
    assert np.mean(inside) >= 0.85


def test_derivatives_by_inputs_are_those_of_small_steps_also_where_a_run_tells_much_of_an_input():
    """Little damping: the width's uncertainty would move the curve by thousands of times its noise."""
    time_s = np.arange(30000) / RATE_HZ
    law = {"k": 2.8e6, "lambda": 3e6}
    theta, _ = simulate_theta("hunt_crossley", BLOCK, law, time_s, theta0=0.15)
    motion = Motion(time_s, theta, SIGMA, 0.15, view=view_of([LASER], BLOCK), laboratory=STATED)
    problem = posed("hunt_crossley", (BLOCK,), [motion], FitSettings())
    nuisances, samples = Nuisances.of(problem), problem.samples()
    z, x = np.zeros(len(nuisances.sources)), problem.start_at(law)
    got = nuisances.by_inputs(z, x, samples)
    for j, source in enumerate(nuisances.sources):
        ends = [
            np.concatenate(nuisances.rows(z + by * np.eye(len(z))[j], x, samples, 1e-11))
            for by in (-1e-3, 1e-3)
        ]
        column = (ends[1] - ends[0]) / 2e-3
        assert np.linalg.norm(got[:, j] - column) < 1e-4 * np.linalg.norm(column), source.name


@pytest.mark.parametrize("name", ["height_m", "width_m", "position_m"])
def test_an_impact_is_the_shift_of_a_fit_with_the_input_held_off_by_what_remains(name):
    motion, fit = drawn_seventh()
    found = fit.contributions
    j = [each.name for each in INPUTS].index(name)
    off = found.moved[j] + found.remaining[j]
    others = tuple(each for each in INPUTS if each.name != name)
    held = replace(STATED.moved(INPUTS[j], off), inputs=others)
    theta = STATED.reread(np.append(motion.theta, motion.theta0), held)
    motion = replace(
        motion,
        theta=theta[:-1],
        theta0=float(theta[-1]),
        laboratory=held,
        view=view_of([*held.lasers.values()], held.block),
    )
    shift = fit_run("housner", held.block, motion).values["theta0"] - fit.values["theta0"]
    assert shift == pytest.approx(found.impacts[1, j], rel=0.3)  # a step of 1 u is not quite linear


def test_worn_corners_are_a_width_beyond_its_prior():
    worn = BLOCK.width_m - 20 * RULE["width_m"][1]
    _, motion = measured(5, corners_m=worn)
    nominal = fit_run("housner", BLOCK, motion)
    assert not evidence(nominal).explains
    found = identify_run(BLOCK, motion, BY_DEFAULT)
    assert found.choice(BY_DEFAULT).selected == "housner_width"
    fit = found.fits["housner_width"]
    total = fit.contributions.total(fit.stderr)[1]
    assert abs(fit.values["width"] - worn) < 4 * total


def off_by_height(off_m, u):
    """A block stated shorter than it is, and its run; only the height is uncertain."""
    _, motion = measured(6, drawn=0.0)
    height = replace(INPUTS[0], u=u)
    laboratory = Laboratory(replace(BLOCK, height_m=BLOCK.height_m - off_m), {"l": LASER}, (height,))
    return laboratory.block, replace(motion, laboratory=laboratory, view=view_of([LASER], laboratory.block))


@cache
def far_off():
    """A block stated five standard uncertainties shorter than it is, its run, and the fit."""
    block, motion = off_by_height(1e-3, 2e-4)
    return block, motion, fit_run("housner", block, motion)


def test_an_input_off_by_more_than_its_prior_rejects_the_law_and_is_named():
    block, motion = off_by_height(6e-4, 1e-4)
    fit = fit_run("housner", block, motion)
    assert not evidence(fit).explains
    assert fit.pulled.startswith("height_m of b off by +0.00059")
    assert evidence(fit).objection == f"requires {fit.pulled}"
    # its numbers are those beside the moved input, which the stated one would falsify
    assert abs(fit.values["r"] - 0.93) < 3 * fit.contributions.total(fit.stderr)[0]


def test_what_a_law_with_a_pulled_input_would_be_with_the_stated_one_counts_as_discrepancy():
    block, motion = off_by_height(2e-4, 1e-4)
    near = fit_run("housner", block, motion)
    held = replace(motion, laboratory=replace(motion.laboratory, inputs=()))
    shift = fit_run("housner", block, held).values["r"] - near.values["r"]
    assert near.contributions.if_as_stated[0] == pytest.approx(shift, rel=0.2)
    assert near.discrepancy[0] < 0.1 * abs(shift)
    far = fit_run("housner", *off_by_height(6e-4, 1e-4))
    assert far.discrepancy[0] >= abs(far.contributions.if_as_stated[0]) > 2 * abs(shift)


def test_an_input_that_is_pulled_adds_to_the_errors_of_the_law():
    off, on = (fit_run("housner", *off_by_height(by, 1e-4)) for by in (3e-4, 5e-5))
    known = off.contributions
    assert known.enlarged == pytest.approx(known.pulls[0], rel=1e-6) and known.pulls[0] > 2.5
    excess = math.sqrt(known.enlarged**2 - 1) * np.abs(known.values[:, 0])
    assert known.excess == pytest.approx(excess)
    assert np.all(off.discrepancy >= excess)
    assert off.u_total**2 == pytest.approx(off.stderr**2 + off.discrepancy**2 + known.values[:, 0] ** 2)
    assert abs(on.contributions.pulls[0]) < 1
    assert on.contributions.enlarged == 1.0 and not on.discrepancy.any()


@pytest.mark.parametrize("sigma, is_least", [(1.2e-5, True), (5e-5, False)])
def test_no_number_is_known_better_than_the_first_order_of_the_inputs(monkeypatch, sigma, is_least):
    monkeypatch.setitem(globals(), "SIGMA", sigma)
    fit = fit_run("housner", BLOCK, measured(1, r=0.98)[1])
    first_order, least = fit.contributions.total(fit.stderr)[0], 1e-6 * fit.value[0]
    assert fit.success and bool(first_order < least) is is_least
    assert fit.u_total[0] == pytest.approx(math.hypot(first_order, is_least * least))


def test_a_number_that_is_fixed_stays_certain_beside_inputs_that_moved():
    given = {"housner": {"r": Given(value=0.93, vary=False)}}
    fit = fit_run("housner", BLOCK, measured(1)[1], FitSettings(parameters=given))
    assert fit.success and fit.contributions.moved.any()
    assert fit.u_total[0] == 0 and fit.u_total[1] > 0


def test_shifts_of_inputs_are_held_against_their_covariance():
    along, across, unseen = np.array([1.0, 1, 0]), np.array([1.0, -1, 0]), np.array([0, 0, 1.0])
    covariance = 0.32 * np.outer(along, along) + 0.02 * np.outer(across, across)  # eigenvalues 0.64, 0.04
    for z, squares in ((along, 2 / 0.64), (across, 2 / 0.04), (along + unseen, 2 / 0.64)):
        assert intervals._enlarged(3 * z, covariance, 1e-2) == pytest.approx(3 * math.sqrt(squares / 2))
    assert intervals._enlarged(across, covariance, 0.1) == 1.0  # the only direction that is seen has no shift
    assert intervals._enlarged(0.1 * along, covariance, 1e-2) == 1.0
    assert intervals._enlarged(np.zeros(0), np.zeros((0, 0)), 1e-2) == 1.0


def test_where_the_data_determine_nothing_a_fit_says_so():
    _, motion = measured(3)
    first = np.flatnonzero(motion.theta < 0)[0] - 20
    short = replace(motion, time_s=motion.time_s[:first], theta=motion.theta[:first])
    fit = fit_run("housner", BLOCK, short)
    assert not fit.success and fit.message == "the data do not determine the parameters"


def test_an_input_beyond_its_prior_counts_as_one_number_in_the_search():
    block, motion = off_by_height(6e-4, 1e-4)
    search = hypotheses_tried._Search(block, motion, BY_DEFAULT)
    law = Hypothesis("housner")
    search.fit(law)
    assert evidence(search.fits[law]).objection.startswith("requires ")

    def next_after_in_vain():
        first = search.worth_trying()
        assert {search.rank(each) for each in first} == {search.rank(law) + 1}
        empty, left = np.empty(0), search.fits[law].diagnostics["mean_square"]
        search.quick = {each: Screening(each.model, {}, empty, empty, left, 1, False) for each in first}
        return search.worth_trying()

    assert next_after_in_vain() == []
    why = "a smaller candidate explains the run with an input beyond its prior"
    assert search._why_untried(Hypothesis("general_width")) == why
    fit, search.quick = search.fits[law], {}
    no_input = {"pulls_p": 1.0, "noise_p": 1e-6}  # is the cause
    search.fits[law] = replace(fit, diagnostics=fit.diagnostics | no_input)
    assert {search.rank(each) for each in next_after_in_vain()} == {search.rank(law) + 2}


@pytest.mark.parametrize("apart, is_named", [(9.0, True), (11.0, False)])
def test_a_law_with_an_input_beyond_its_prior_is_named_beside_a_freed_width(apart, is_named):
    block, motion = off_by_height(1e-3, 2e-4)
    law, wider = Hypothesis("housner"), Hypothesis("housner_width")
    search = hypotheses_tried._Search(block, motion, BY_DEFAULT)
    for each in (law, wider):
        search.fit(each)
    (height,) = motion.laboratory.inputs
    freed = freeing(height, search.fits[law], block, motion, BY_DEFAULT.settings("housner"))
    assert freed.contributions.p_of_pulls > 0.1
    assert abs(freed.values["r"] - 0.93) < 3 * freed.contributions.total(freed.stderr)[0]
    explains = search.fits[wider].diagnostics | {"noise_p": 1.0, "pulls_p": 1.0, "added_damping": 0.0}
    search.fits[wider] = replace(search.fits[wider], bic=freed.bic - apart, diagnostics=explains)
    found = search.found()
    assert found.choice(BY_DEFAULT).selected == wider.model
    with_height = Hypothesis("housner", ("height_m of b",))
    assert [*found.alternatives] == [with_height] * is_named
    notes = list(explains_as_well(with_height, freed, replace(freed, value=2 * freed.value), {"housner"}))
    assert [(note.verdict, note.name) for note in notes] == [("warn", "pulled_input")]
    assert notes[0].text.startswith("Housner with height_m of b off by +0.00099")


def test_where_nothing_explains_a_run_its_fits_widen_what_the_nearest_does():
    block, motion = off_by_height(1e-3, 2e-4)
    law, level = Hypothesis("housner"), Hypothesis("housner", ("tilt",))
    search = hypotheses_tried._Search(block, motion, BY_DEFAULT)
    search.fit(law)
    fit = replace(search.fits[law], diagnostics=search.fits[law].diagnostics | {"noise_p": 0.0})
    for least, widened in ((0.9, ()), (0.5, ("tilt",))):  # of those about as near the one that widens least
        nearest = fit.diagnostics | {"mean_square": least * fit.diagnostics["mean_square"]}
        search.fits = {law: fit, level: replace(fit, diagnostics=nearest)}
        assert search.found().widened == widened
    search.fits[level] = replace(search.fits[level], success=False)
    assert search.found().widened == ()


def test_an_input_that_cannot_be_freed_ends_no_search(monkeypatch):
    block, motion = off_by_height(1e-3, 2e-4)
    law, wider = Hypothesis("housner"), Hypothesis("housner_width")
    search = hypotheses_tried._Search(block, motion, BY_DEFAULT)
    for each in (law, wider):
        search.fit(each)
    explains = search.fits[wider].diagnostics | {"noise_p": 1.0, "pulls_p": 1.0, "added_damping": 0.0}
    bic = search.fits[law].bic - 20
    search.fits[wider] = replace(search.fits[wider], bic=bic, diagnostics=explains)
    tried = []

    def fails(*_):
        tried.append(1)
        raise FreerockError("fit", "no", "none")

    monkeypatch.setattr(hypotheses_tried, "freeing", fails)
    found = search.found()
    assert tried and found.alternatives == {} and found.choice(BY_DEFAULT).selected == wider.model


def test_a_hypothesis_beside_others_takes_up_what_they_would_change_by_their_odds():
    _, _, fit = far_off()
    other = replace(fit, value=fit.value * 1.01, bic=fit.bic)
    assert beside_others(fit, []).discrepancy == pytest.approx(fit.discrepancy)
    known = np.hypot(fit.discrepancy, 0.01 * fit.value / math.sqrt(2))
    assert beside_others(fit, [other]).discrepancy == pytest.approx(known)
    unlikely = replace(other, bic=fit.bic + 20)
    assert np.all(beside_others(fit, [unlikely]).discrepancy - fit.discrepancy < 0.01 * known)


def test_the_stated_width_is_fitted_from_where_a_freed_one_ended():
    """A block 2.4 mm narrower than stated: by itself the fit of the law ends where no input moves."""
    laboratory = Laboratory(BLOCK, {"l": LASER}, (replace(INPUTS[1], u=4e-4),))
    true = laboratory.moved(laboratory.inputs[0], -6.0)
    soil, theta0, time_s = {"k": 4e6, "lambda": 9e7}, math.radians(5), np.arange(0, 2.5, 1e-3)
    theta, _ = simulate_theta("hunt_crossley", true.block, soil, time_s, theta0=theta0)
    *theta, theta0 = true.reread(np.append(theta, theta0), laboratory)
    noise = SIGMA * np.random.default_rng(5).standard_normal(time_s.size + N_REST)
    known = {"noise": noise_at_rest([noise[:N_REST]], RATE_HZ), "view": view_of([LASER], BLOCK)}
    given = time_s, np.array(theta) + noise[N_REST:], SIGMA, theta0, SIGMA / 10, 2e-4
    motion = Motion(*given, **known, laboratory=laboratory)
    assert evidence(fit_run("hunt_crossley", BLOCK, motion)).noise_p < 1e-10
    wide = BY_DEFAULT.settings("hunt_crossley_width")
    fit = fit_record("hunt_crossley_width", BLOCK, [motion], wide)
    values, moved = narrowed(at_end_of(fit, BLOCK, motion, wide))
    assert {*values} == {"k", "lambda", "theta0", "t0"} and {*moved} == {*laboratory.inputs}
    near = fit_record("hunt_crossley", BLOCK, [motion], start=values, moved=moved)
    assert evidence(near).noise_p > 1e-3 and near.pulled.startswith("width_m of b off by -0.002")
    assert abs(near.values["k"] - soil["k"]) < 3 * near.u_total[0]


def test_a_base_that_is_off_level_by_its_input_is_not_called_level():
    _, _, flat = far_off()
    tilted = replace(flat, parameters=(*flat.parameters, "tilt"), value=np.append(2 * flat.value, 1e-3))

    def told(name):
        (source,) = flat.contributions.inputs
        moved = replace(flat.contributions, inputs=(replace(source, name=name, u=1.0),), moved=np.ones(1))
        other = Hypothesis("housner", (f"{name} of b",))
        (note,) = explains_as_well(other, replace(flat, contributions=moved), tilted, {"housner"})
        return note.text.partition(" explains")[0]

    assert told("height_m") == "Housner with a level base and height_m of b off by +1 m"
    assert told("levelled_deg") == "Housner with levelled_deg of b off by +1 deg"


@pytest.mark.parametrize("times, name", [(1.05, "pushed"), (0.95, "held_back")])
def test_a_doubt_about_the_release_states_its_direction(times, name):
    _, _, fit = far_off()
    at = {"r": 1.02, "theta0": times}
    loose = replace(fit, value=fit.value * [at.get(each, 1.0) for each in fit.parameters])
    plain, released = Hypothesis("housner"), Hypothesis("housner", ("release",))
    (freed,) = explains_as_well(released, loose, fit, {"housner"})
    (kept,) = explains_as_well(plain, fit, loose, {"housner"}, released.widened)
    assert freed.name == kept.name == name
    assert freed.text.startswith("Housner with another release explains")
    assert kept.text.startswith("Housner with the release as measured explains")
    (sharp,) = explains_as_well(plain, fit, loose, {"housner"}, ("edge_radius",))
    assert (sharp.name, sharp.text.partition(" explains")[0]) == ("rounded_edges", "Housner with sharp edges")
    tilted = [
        replace(each, parameters=(*each.parameters, "tilt"), value=np.append(each.value, 1e-3))
        for each in (loose, fit)
    ]
    (alike,) = explains_as_well(Hypothesis("housner", ("release", "tilt")), *tilted, {"housner"}, ("tilt",))
    assert alike.name == name and " off level by 0.057 degrees and another release explains" in alike.text


def test_a_pull_beyond_two_names_the_input():
    _, motion = measured(1)
    fit = fit_run("housner", BLOCK, motion)
    found = fit.contributions
    pulls = np.full(len(INPUTS), 0.5)
    pulls[0] = 2.5
    noted = replace(fit, contributions=replace(found, moved=pulls, pulls=pulls))
    (note,) = pulled_inputs(noted)
    assert (note.verdict, note.name) == ("ok", "pulled_input")
    assert note.text == "height_m of b fitted +0.00075 m off, a pull of 2.5"
    pulls[0] = 3.6
    (warned,) = pulled_inputs(replace(fit, contributions=replace(found, moved=pulls, pulls=pulls)))
    assert warned.verdict == "warn" and warned.text.endswith("measure it again")


def test_exact_inputs_leave_a_fit_as_it_is():
    _, motion = measured(2, drawn=0.0)
    exact = Laboratory(BLOCK, {"l": LASER}, tuple(replace(each, u=0.0) for each in INPUTS))
    with_exact = fit_run("housner", BLOCK, replace(motion, laboratory=exact))
    without = fit_run("housner", BLOCK, replace(motion, laboratory=None))
    assert np.array_equal(with_exact.value, without.value)


def test_the_numbers_of_every_fit_are_those_of_lmfit(monkeypatch):
    _, motion = measured(3)
    fit = fit_run("housner", BLOCK, motion)
    assert fit.result.params["r"].value == fit.values["r"]
    held = fit_run("winkler", BLOCK, replace(motion, laboratory=None))
    assert held.result.params["k"].value == pytest.approx(held.values["k"], rel=1e-12)
    assert held.result.params["c"].value == pytest.approx(held.values["c"], rel=1e-12)
    assert held.result.var_names == ["k", "c", "theta0", "t0"]

    def refuse(*_, **__):
        raise FreerockError("lmfit", "refused", "none")

    monkeypatch.setattr(lmfit.Minimizer, "least_squares", refuse)
    for model in ("housner", "winkler", "hunt_crossley"):
        with pytest.raises(FreerockError, match="refused"):
            fit_run(model, BLOCK, motion)


def test_a_keyword_of_python_is_no_name_of_a_parameter():
    assert (legal("lambda"), legal("k")) == ("lambda_", "k")


def test_of_inputs_that_no_run_sees_there_is_no_pull():
    none = Contributions.held(INPUTS, np.zeros((2, len(INPUTS))))
    assert none.most_pulled is None and none.p_of_pulls == 1.0
