"""The causes of a misfit, ranked by the derivatives."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import fit_run
from freerock.identification.inputs_with_priors import at_end
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.given import Given
from freerock.models.simulate import simulate_theta
from freerock.rotation.beam import displaced, turned
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion
from freerock.runs.verdict import Verdict
from freerock.selection import causes as selection_causes
from freerock.selection import hypotheses_tried, reasons_after_fits, unmodelled
from freerock.selection.added_uncertainty import beside_causes
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.causes import Cause, ranked, required_effect
from freerock.selection.hypotheses_tried import identify_run, identify_runs, take_up_causes
from freerock.selection.reasons_of_set_up import odd_contact, unmodelled_effect
from freerock_bench.springs import Motion as Rocking
from freerock_bench.springs import Scene, read

BLOCK, LASER, SIGMA = Block(0.28, 0.07, 5.84), Laser("horizontal", 0.2, 0.1), math.radians(0.006)
US = {"height_m": 3e-4, "com_height_m": 3e-4, "position_m": 6e-4, "sampling_rate_fraction": 6e-5}
INPUTS = tuple(
    Input("l" if name in ("position_m", "sampling_rate_fraction") else "b", name, u, True)
    for name, u in US.items()
)
STATED = Laboratory(BLOCK, {"l": LASER}, INPUTS)


def measured(true):
    """A run of a laboratory with other inputs, as the stated ones read it."""
    time_s, theta0 = np.arange(0, 2.5, 1e-3), math.radians(9)
    theta, _ = simulate_theta("housner", true.block, {"r": 0.93}, time_s * true.clock, theta0=theta0)
    theta = true.reread(np.append(theta, theta0), STATED)
    noise = SIGMA * np.random.default_rng(3).standard_normal(time_s.size)
    view = view_of([LASER], BLOCK)
    return Motion(
        time_s, theta[:-1] + noise, SIGMA, float(theta[-1]), SIGMA / 10, 2e-4, view=view, laboratory=STATED
    )


@pytest.mark.parametrize("name, u", [("com_offset_m", 3e-4), ("position_m", 6e-4), ("com_height_m", 3e-4)])
def test_what_is_off_stands_among_the_causes_with_its_value(name, u):
    by = 3 * u
    motion = measured(STATED.moved(Input("l" if name == "position_m" else "b", name, u, True), 3.0))
    fit = fit_run("housner", BLOCK, replace(motion, laboratory=None))
    problem = posed("housner", (BLOCK,), (motion,), FitSettings())
    causes = ranked(at_end(problem, fit.values, None))
    found = {cause.name: cause for cause in causes}
    assert name in found and len(causes) <= 3
    assert found[name].share > 0.5
    assert found[name].off == pytest.approx(by, rel=0.3)
    assert [cause.share for cause in causes] == sorted((cause.share for cause in causes), reverse=True)


def test_an_input_that_would_be_off_by_far_is_no_cause():
    """A beam 3 and 30 mm higher, and a clock that is off by 0.3 %, stated to a hundredth and a thousandth."""
    for name, off, u, is_named in (
        ("position_m", 3e-3, 3e-5, True),
        ("position_m", 3e-2, 3e-4, False),
        ("sampling_rate_fraction", 3e-3, 3e-5, True),
        ("sampling_rate_fraction", 3e-3, 3e-6, False),
    ):
        motion = measured(STATED.moved(Input("l", name, off, True), 1.0))
        fit = fit_run("housner", BLOCK, replace(motion, laboratory=None))
        stated = replace(STATED, inputs=(Input("l", name, u, True),))
        problem = posed("housner", (BLOCK,), (replace(motion, laboratory=stated),), FitSettings())
        names = [cause.name for cause in ranked(at_end(problem, fit.values, None))]
        assert (name in names) is is_named


@pytest.mark.parametrize("bent, is_named", [(0.01, True), (0.04, False)])
def test_a_sensor_bent_by_more_than_any_is_no_cause(bent, is_named):
    motion = measured(STATED)
    way = displaced(motion.theta, BLOCK, LASER)
    read = turned(way + 4 * bent * way**2 / LASER.range_m, BLOCK, LASER)
    problem = posed("housner", (BLOCK,), (replace(motion, theta=read),), FitSettings())
    known = {"r": 0.93, "theta0": motion.theta0, "t0": 0.0}
    names = [cause.name for cause in ranked(at_end(problem, known, None))]
    assert ("sensor" in names) is is_named


def test_of_two_lasers_each_input_is_named_with_its_own():
    """An averaging time is given as a value, that of the laser that averages."""
    two = Laboratory(BLOCK, {"low": replace(LASER, position_m=0.1, response_ms=2.0), "high": LASER}, ())
    sources = [Input(owner, "response_ms", 4.0, False) for owner in two.lasers]
    told = [selection_causes._effect_of(source, two).text(1.0) for source in sources]
    assert told == ["6.0 ms of low", "4.0 ms of high"]


def test_no_bed_relaxes_by_more_than_it_bears_and_no_base_is_hollow_by_much():
    found = {each.name: each for each in unmodelled.effects(fitted(seen({})))}
    assert found["relaxation"].bounds == (0.0, 1.0) and 0 < found["base"].bounds[1] < 0.1 * BLOCK.b
    lost = found["samples"]
    assert lost.text(2.7e-3).startswith("3 lost at") and lost.text(4e-4).startswith("1 lost at")


def test_amounts_have_a_true_minus_sign_and_a_space_before_the_unit():
    bent = unmodelled.Effect("sensor", np.empty(0), "bent by {:+.2%} of the range of laser-1".format)
    tried = selection_causes._Tried(bent, 0.2, 1.0, -0.0029, np.empty(0), np.empty(0))
    assert tried.text == "bent by −0.29 % of the range of laser-1"


def test_a_contact_wider_than_the_block_is_a_warning():
    width = Input("b", "width_m", 3e-4, True)
    motion = replace(measured(STATED), laboratory=replace(STATED, inputs=(*INPUTS, width)))
    fit = fit_run("housner_width", BLOCK, motion)
    assert not [*odd_contact(fit, BLOCK)]
    (reason,) = odd_contact(fit, replace(BLOCK, width_m=BLOCK.width_m - 2e-3))
    assert (reason.verdict, reason.name) == ("warn", "pulled_input")
    assert "fitted 0.0019 m wider than the block, a pull of 7.5" in reason.text
    (reason,) = odd_contact(fit, replace(BLOCK, width_m=2 * BLOCK.width_m))
    assert reason.verdict == "warn" and "fitted 50 % of the stated one: " in reason.text
    assert not [*odd_contact(fit, replace(BLOCK, width_m=1.3 * BLOCK.width_m))]


@pytest.mark.parametrize("explained", [True, False])
def test_a_contact_of_half_the_block_is_a_warning_of_any_run(explained, monkeypatch):
    """As of a range stated twice too small."""
    motion = replace(measured(STATED), laboratory=None)
    fit = fit_run("housner_width", BLOCK, motion)
    monkeypatch.setattr(hypotheses_tried.Identified, "explained", explained)
    monkeypatch.setattr(reasons_after_fits, "hints_for", lambda *_: [])
    monkeypatch.setattr(reasons_after_fits, "find_disturbance", lambda *_: None)
    monkeypatch.setattr(reasons_after_fits, "slow_sensor", lambda *_: [])
    found = hypotheses_tried.Identified(fits={"housner_width": fit})
    reasons = reasons_after_fits.reasons_of_fits(
        Verdict(), replace(BLOCK, width_m=0.14), motion, found, BY_DEFAULT
    )
    assert "contact width fitted 50 % of the stated one" in reasons[0].text
    assert ("unexplained" in [each.name for each in reasons]) is not explained


def test_a_run_of_no_known_laboratory_has_no_causes():
    motion = replace(measured(STATED), laboratory=None)
    fit = fit_run("housner", BLOCK, motion)
    assert ranked(at_end(posed("housner", (BLOCK,), (motion,), FitSettings()), fit.values, None)) == []


SOIL, THETA0 = {"k": 2.86e6, "lambda": 8.16e7}, math.radians(8)


def unexplained(besides=None, **others):
    """Causes of a run of another simulator with something that the law of its fit has not."""
    return ranked(fitted(seen(besides or {}, **others)))


def fitted(motion):
    """Where the fit of a run by Hunt and Crossley's law ends."""
    fit = fit_run("hunt_crossley", BLOCK, replace(motion, laboratory=None))
    return at_end(posed("hunt_crossley", (BLOCK,), (motion,), FitSettings()), fit.values, None)


def seen(besides, lost=0, incline=0.0, base=None):
    """A run of another simulator with something that the law of its fit has not."""
    return _seen(tuple(besides.items()), lost, incline, tuple((base or {}).items()))


@cache
def _seen(besides, lost, incline, base):
    scene = Scene(BLOCK, SOIL, False, THETA0, 1e-7, base=dict(base), besides=dict(besides))
    moves = Rocking(scene, 1e3, 2.5)
    way = read(moves.states, scene, LASER.position, incline)
    way = way - read(moves.stands[:6, None], scene, LASER.position, incline)
    theta = np.delete(turned(way, BLOCK, LASER), np.s_[600 : 600 + lost])
    noise = 0.2 * SIGMA * np.random.default_rng(3).standard_normal(theta.size)
    time_s, view = np.arange(theta.size) * 1e-3, view_of([LASER], BLOCK)
    given = 0.2 * SIGMA, float(theta[0]), SIGMA / 50, 2e-4
    return Motion(time_s, theta + noise, *given, view=view, laboratory=STATED)


@pytest.mark.parametrize(
    ("name", "how", "size"),
    [
        ("air", {"besides": {"air_nms2": 2e-3}}, 2e-3),
        ("friction", {"besides": {"rub_nm": 3e-3}}, 3e-3),
        ("relaxation", {"besides": {"relaxing": 0.05, "relaxes_s": 0.02}}, 0.05),
        ("beds", {"besides": {"two_beds": 0.01}}, 0.02),
        ("base", {"base": {"hollow_m": 1e-5}}, 1e-5),
        ("samples", {"lost": 3}, 3e-3),
        ("beam", {"incline": 0.02}, 0.02),
    ],
)
def test_what_no_law_has_is_named_with_its_size(name, how, size):
    causes = unexplained(**how)
    assert name in f"{causes[0].name} {causes[0].what}"
    assert causes[0].share > 0.7 and causes[0].left <= min(cause.left for cause in causes)
    if causes[0].name == name:
        assert causes[0].off == pytest.approx(size, rel=0.4)


def with_friction(grip):
    """A run of a block that friction holds, between two rests, the states of it, and its base's way [m]."""
    scene = Scene(BLOCK, SOIL, True, THETA0, 1e-7, besides={"grip": grip})
    moves = Rocking(scene, 1e3, 2.5)
    x, angle = moves.states[0], moves.states[2]
    slid_m = x - BLOCK.b * np.sign(angle) * (1 - np.cos(angle)) - BLOCK.h * np.sin(angle)
    way = read(moves.states, scene, LASER.position, 0.0)
    before = read(moves.stands[:6, None], scene, LASER.position, 0.0)
    theta = turned(way - before - slid_m[-1] / 2, BLOCK, LASER)
    noise = 0.2 * SIGMA * np.random.default_rng(3).standard_normal(theta.size)
    time_s, given = np.arange(theta.size) * 1e-3, (0.2 * SIGMA, float(theta[0]), SIGMA / 50, 2e-4)
    motion = Motion(time_s, theta + noise, *given, view=view_of([LASER], BLOCK), laboratory=STATED)
    return motion, moves.states, slid_m


def ended_at(motion, values):
    """The end of a pivoting fit at some values."""
    return at_end(posed("hunt_crossley_pivoting", (BLOCK,), (motion,), FitSettings()), values, None)


def test_a_base_that_friction_holds_rolls_where_the_bed_presses():
    motion, _, _ = with_friction(grip=1.0)
    fit = fit_run("hunt_crossley_pivoting", BLOCK, replace(motion, laboratory=None))
    first = ranked(ended_at(motion, fit.values))[0]
    assert first.name == "rolling" and first.share > 0.9
    assert first.off == pytest.approx(1.0, abs=0.25)


def test_a_block_that_rolls_or_slides_moves_as_its_derivative_has_it():
    """Against the other simulator: with friction and on its corners, with little friction and with much."""
    motion, rolls, _ = with_friction(grip=1.0)
    _, slides, _ = with_friction(grip=0.1)
    pivots = Rocking(Scene(BLOCK, SOIL, True, THETA0, 1e-7), 1e3, 2.5).states
    path = unmodelled._Path.of(ended_at(motion, {**SOIL, "theta0": THETA0, "t0": 0.0}))
    path = replace(path, best=replace(path.best, nuisances=unseen(path.best)))
    found = {each.text(1.0): each.column for each in unmodelled._of_grip(path)}
    for text, more, n, close in (
        ("1.0 times that of a base held by friction", rolls - pivots[:, : rolls.shape[1]], 1000, 0.1),
        ("friction coefficient about 0.1", slides - rolls[:, : slides.shape[1]], 900, 0.2),
    ):
        assert np.linalg.norm(found[text][:n] - more[2, :n]) < close * np.linalg.norm(more[2, :n])


def test_a_block_that_slides_is_named():
    motion, _, _ = with_friction(grip=0.1)
    fit = fit_run("hunt_crossley_pivoting", BLOCK, replace(motion, laboratory=None))
    first = ranked(ended_at(motion, fit.values))[0]
    assert "slip, friction coefficient about 0.1" in f"{first.name}, {first.what}" and first.share > 0.8


def unseen(best):
    """Nuisances of the same problem without a beam."""
    motion = replace(best.nuisances.problem.motions[0], view=None, laboratory=None)
    return replace(best.nuisances, problem=replace(best.nuisances.problem, motions=(motion,)))


def test_a_base_slides_as_far_as_that_of_the_other_simulator():
    motion, _, slid_m = with_friction(grip=0.1)
    path = unmodelled._Path.of(ended_at(motion, {**SOIL, "theta0": THETA0, "t0": 0.0}))
    first_swing = np.flatnonzero(np.abs(slid_m) > 7e-4)[0]
    _, way = path.slid(0.1)
    assert way[first_swing + 50] == pytest.approx(slid_m[first_swing + 50], rel=0.05)
    assert not any(np.any(each) for each in path.slid(1.0))


def test_a_part_that_swings_is_a_line_of_its_frequency():
    causes = {cause.name: cause for cause in unexplained({"top": 0.3, "top_hz": 30.0})}
    hz = float(causes["oscillation"].what.split("at ")[1].split(" Hz")[0])
    assert 25 < hz < 45 and causes["oscillation"].what.endswith("bias k")


@pytest.mark.parametrize("of_own, found", [(0.9, False), (1.0, False), (1.1, False), (2.0, True)])
def test_a_line_at_the_frequency_of_the_block_itself_is_of_no_other_part(of_own, found):
    """That of a motion so small that the whole base stays in contact, by its passages through zero."""
    law = {"k": 8e7, "c": 10.0}
    small, _ = simulate_theta("winkler", BLOCK, law, np.arange(0, 1, 1e-4), theta0=1e-6)
    passages = np.flatnonzero(np.diff(np.sign(small))) * 1e-4
    own_hz = 1 / (2 * np.mean(np.diff(passages)))
    motion = replace(measured(STATED), laboratory=None)
    problem = posed("winkler", (BLOCK,), (motion,), FitSettings())
    end = at_end(problem, law | {"theta0": motion.theta0, "t0": 0.0}, None)
    noise = SIGMA * np.random.default_rng(1).standard_normal(len(end.residual))
    swings = 3 * SIGMA * np.sin(2 * math.pi * of_own * own_hz * end.samples.time_s)
    line = unmodelled.line_in(replace(end, residual=noise + swings))
    assert line[0] == pytest.approx(of_own * own_hz, rel=0.05) if found else line == (0.0, 0.0)


@pytest.mark.parametrize(
    ("name", "besides", "without"),
    [
        ("friction", {"rub_nm": 2e-4}, {}),
        ("relaxation", {"relaxing": 5e-3, "relaxes_s": 0.02}, {"relaxing": 0.0, "relaxes_s": 0.02}),
    ],
)
def test_an_effect_too_small_to_reject_a_law_is_required_with_what_it_changes(name, besides, without):
    motion, clean = seen(besides), seen(without)
    fit, true = (fit_run("hunt_crossley", BLOCK, each) for each in (motion, clean))
    assert (
        required_effect(at_end(posed("hunt_crossley", (BLOCK,), (clean,), FitSettings()), true.values, None))
        is None
    )
    found = required_effect(
        at_end(posed("hunt_crossley", (BLOCK,), (motion,), FitSettings()), fit.values, None)
    )
    assert found.name == name and found.deviations > 4
    off = fit.values["lambda"] - true.values["lambda"]
    assert found.shifts["lambda"] == pytest.approx(-off, rel=0.4)
    note = unmodelled_effect(fit, found)
    assert (note.verdict, note.name, note.value) == ("warn", "unmodelled_effect", found.deviations)
    assert note.text.startswith(f"requires {name}, ") and " and lambda " in note.text
    at = fit.parameters.index("lambda")
    more = beside_causes(fit, [found], [1.0]).discrepancy[at] ** 2 - fit.discrepancy[at] ** 2
    assert more == pytest.approx(found.shifts["lambda"] ** 2)


def test_what_a_required_effect_would_change_stands_in_the_uncertainty():
    motion, laws = seen({"rub_nm": 2e-4}), ("hunt_crossley",)
    found = identify_run(BLOCK, motion, replace(BY_DEFAULT, laws=laws, kinematics=()))
    best, held = found.fits["hunt_crossley"], fit_run("hunt_crossley", BLOCK, motion)
    assert found.explained and found.effects["hunt_crossley"].name == "friction"
    at = best.parameters.index("lambda")
    shift = found.effects["hunt_crossley"].shifts["lambda"]
    assert best.discrepancy[at] == pytest.approx(math.hypot(held.discrepancy[at], shift), rel=0.01)
    assert abs(best.values["lambda"] - SOIL["lambda"]) < 1.96 * best.u_total[at]


def test_what_causes_would_change_counts_by_their_shares():
    fit = fit_run("hunt_crossley", BLOCK, seen({}))
    at, size = fit.parameters.index("k"), fit.values["k"]
    causes = [
        Cause(name, "", 1.0, 1.0, 1.0, {"k": by * size}) for name, by in (("air", 0.03), ("slip", 0.04))
    ]
    for shares, square in (
        ((0.5, 0.25), 0.5 * 0.03**2 + 0.25 * 0.04**2),
        ((1.0, 1.0), (0.03**2 + 0.04**2) / 2),
    ):
        told = beside_causes(fit, causes, shares).discrepancy[at] ** 2 - fit.discrepancy[at] ** 2
        assert told == pytest.approx(square * size**2)


def test_a_run_that_nothing_explains_is_known_to_what_its_causes_would_change():
    laws = ("winkler", "hunt_crossley", "general")
    hypotheses = replace(BY_DEFAULT, laws=laws, kinematics=())
    motion = seen({"relaxing": 0.3, "relaxes_s": 0.05})
    found = identify_run(BLOCK, motion, hypotheses)
    assert not found.explained
    for model, own in found.fits.items():
        causes = [cause for cause in found.causes[model] if cause.name != "oscillation"]
        alone = fit_run(model, BLOCK, motion, hypotheses.settings(model, ()))
        square = sum(cause.share * cause.shifts["k"] ** 2 for cause in causes)
        square /= max(1.0, sum(cause.share for cause in causes))
        others = [found.fits[name] for name in found.fits if name != model]
        odds = [(own.epsilon_theta / other.epsilon_theta) ** 3 for other in others]
        for each, other in zip(odds, others, strict=True):
            square += each / (1 + sum(odds)) * (own.value[0] - other.value[0]) ** 2
        assert own.discrepancy[0] ** 2 == pytest.approx(alone.discrepancy[0] ** 2 + square, rel=1e-6)


def test_causes_that_no_run_tells_apart_change_by_the_most_of_each():
    motion = seen({"relaxing": 0.3, "relaxes_s": 0.05})
    fit = fit_run("winkler", BLOCK, motion)
    best = at_end(posed("winkler", (BLOCK,), (motion,), FitSettings()), fit.values, fit.contributions)
    together = next(cause for cause in ranked(best) if "relaxation" in cause.what)
    assert together.name != "relaxation"
    assert together.shifts["k"] < -0.05 * fit.values["k"] and together.shifts["c"] < -0.1 * fit.values["c"]


def test_a_bed_that_has_become_rigid_has_no_causes():
    """It may leave less of a rigid block in air than the rigid law, and names another cause."""
    hypotheses = replace(BY_DEFAULT, laws=("winkler", "hunt_crossley"), kinematics=())
    found = identify_run(BLOCK, seen({"relaxing": 0.3, "relaxes_s": 0.05}), hypotheses)
    assert {*found.causes} == {"winkler", "hunt_crossley"}
    fit, k = found.fits["winkler"], found.fits["winkler"].parameters.index("k")
    found.fits["winkler"] = replace(fit, value=np.where(np.arange(len(fit.value)) == k, 5e10, fit.value))
    found.causes.clear()
    take_up_causes(found, BLOCK, seen({}), hypotheses)
    assert {*found.causes} == {"hunt_crossley"}


def test_a_number_that_is_fixed_stays_certain():
    options = {**BY_DEFAULT.options, "parameters": {"winkler": {"k": Given(value=3.2e6, vary=False)}}}
    hypotheses = replace(BY_DEFAULT, laws=("winkler", "hunt_crossley"), kinematics=(), options=options)
    found = identify_run(BLOCK, seen({"relaxing": 0.3, "relaxes_s": 0.05}), hypotheses)
    fit = found.fits["winkler"]
    assert not found.explained
    assert fit.u_total[0] == 0 and fit.discrepancy[1] > 0


def test_a_run_that_the_others_of_its_record_contradict_has_causes(monkeypatch):
    motion, cause = seen({}), Cause("air", "", 1.0, 1.0, 1.0, {"k": 0.1 * SOIL["k"]})
    hypotheses = replace(BY_DEFAULT, laws=("hunt_crossley",), kinematics=())
    alone = identify_runs(BLOCK, {1: motion}, hypotheses)[1]
    assert alone.explained and not alone.causes
    monkeypatch.setattr(hypotheses_tried, "of_other_runs", lambda *of: dict.fromkeys(of[3], 2.0))
    monkeypatch.setattr(hypotheses_tried, "ranked", lambda _: [cause])
    found = identify_runs(BLOCK, {1: motion}, hypotheses)[1]
    assert not found.explained and found.causes["hunt_crossley"] == [cause]


def test_where_the_law_cannot_be_followed_no_effect_is_required(monkeypatch):
    motion = seen({})
    fit = fit_run("hunt_crossley", BLOCK, motion)
    best = at_end(posed("hunt_crossley", (BLOCK,), (motion,), FitSettings()), fit.values, fit.contributions)
    monkeypatch.setattr(unmodelled._Path, "of", lambda _: None)
    assert required_effect(best) is None


def test_three_causes_are_named_where_nothing_swings():
    causes = unexplained({"rub_nm": 3e-3, "air_nms2": 2e-3})
    assert len(causes) == 3 and "oscillation" not in {cause.name for cause in causes}
