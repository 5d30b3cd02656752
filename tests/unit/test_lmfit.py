"""lmfit is the door: its words for parameters, its result, its models."""

import pickle

import lmfit
import numpy as np
import pytest
import xarray as xr

import freerock
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.fit import fit_run
from freerock.identification.lmfit_models import HousnerModel, HuntCrossleyModel, WinklerModel
from freerock.models.block import Block
from freerock.models.given import Given, faults
from freerock.models.simulate import Solver, simulate_fitted
from freerock.products.netcdf import open_fits, write_fits
from freerock.runs.motion import Motion

BLOCK = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
TRUTHS = {
    "housner": {"r": 0.93},
    "winkler": {"k": 6.77e6, "c": 2.17e4},
    "hunt_crossley": {"k": 6.88e6, "lambda": 1.30e8},
}
SIGMA = 1e-4
ALPHA = 0.17


def released(law, seed=1, span=2.0):
    time_s = np.arange(0, span, 2e-3)
    theta = simulate_fitted(law, BLOCK, {**TRUTHS[law], "theta0": ALPHA}, time_s, solver=Solver(1e-10))
    theta += SIGMA * np.random.default_rng(seed).standard_normal(time_s.size)
    return Motion(time_s, theta, SIGMA, ALPHA, 2e-5, 5e-4)


def fitted(law, given, motion=None, **options):
    settings = FitSettings(parameters={law: given}, **options)
    return fit_run(law, BLOCK, motion or released(law), settings)


def chi_square(law, motion, values):
    theta = simulate_fitted(
        law,
        BLOCK,
        {**{name: values[name] for name in TRUTHS[law]}, "theta0": values.get("theta0", ALPHA)},
        motion.time_s - values.get("t0", 0.0),
        solver=Solver(1e-9),
    )
    return np.sum((theta - motion.theta) ** 2) / SIGMA**2


def value_of(fit):
    return np.array(list(fit.values.values()))


def test_the_result_is_lmfits_in_the_parameters_of_the_law():
    fit = fit_run("hunt_crossley", BLOCK, released("hunt_crossley"))
    result = fit.result
    assert isinstance(result, lmfit.minimizer.MinimizerResult)
    assert [*result.params][:4] == ["k", "lambda_", "theta0", "t0"]
    for i, (each, value) in enumerate(zip(result.params.values(), fit.values.values(), strict=False)):
        assert each.value == value and each.stderr == pytest.approx(fit.uncertainty.u_total[i], rel=1e-6)
        assert each.min < each.value < each.max
    errors = fit.uncertainty.stderr
    between = fit.uncertainty.covariance[0, 1] / errors[0] / errors[1]
    assert result.params["k"].correl["lambda_"] == pytest.approx(between, rel=1e-6)
    report = lmfit.fit_report(result)
    assert "lambda_:" in report and "C(k, lambda_)" in report and "could not be estimated" not in report


@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
def test_a_fixed_parameter_stays_and_the_others_are_the_best_beside_it(law):
    other = [*TRUTHS[law]][1]
    motion, k = released(law), 1.002 * TRUTHS[law]["k"]
    fit = fitted(law, {"k": {"value": k, "vary": False}}, motion)
    assert fit.success and fit.values["k"] == k and fit.uncertainty.stderr[0] == 0
    best = chi_square(law, motion, fit.values)
    for name, stderr in zip(list(fit.values)[1:], fit.uncertainty.stderr[1:], strict=True):
        for side in (-1, 1):
            assert chi_square(law, motion, fit.values | {name: fit.values[name] + side * stderr}) > best
    free = fit_run(law, BLOCK, motion)
    assert fit.uncertainty.stderr[1] < free.uncertainty.stderr[1]
    assert not fit.result.params["k"].vary and not fit.result.params["k"].stderr
    assert abs(fit.values[other] / free.values[other] - 1) < 0.02


@pytest.mark.parametrize("seed", range(2))
def test_at_the_truth_a_tie_gives_the_truth_with_less_uncertainty(seed):
    motion = released("hunt_crossley", seed)
    ratio = TRUTHS["hunt_crossley"]["lambda"] / TRUTHS["hunt_crossley"]["k"]
    one = fitted("hunt_crossley", {"lambda": {"expr": f"{ratio!r} * k"}}, motion)
    other = fitted("hunt_crossley", {"k": {"expr": f"lambda/{ratio!r}"}}, motion)
    free = fit_run("hunt_crossley", BLOCK, motion)
    for fit in (one, other):
        assert fit.success
        assert fit.values["lambda"] == pytest.approx(ratio * fit.values["k"], rel=1e-12)
        assert fit.uncertainty.stderr[1] == pytest.approx(ratio * fit.uncertainty.stderr[0], rel=1e-4)
        assert abs(fit.values["k"] - TRUTHS["hunt_crossley"]["k"]) < 4.5 * fit.uncertainty.stderr[0]
        assert fit.uncertainty.stderr[0] < 0.5 * free.uncertainty.stderr[0]
    assert one.values["k"] == pytest.approx(other.values["k"], abs=0.2 * one.uncertainty.stderr[0])
    assert one.result.params["lambda_"].expr and not one.result.params["lambda_"].vary


def test_bounds_hold_and_a_fit_that_ends_at_one_is_not_used():
    motion = released("winkler")
    inside = fitted("winkler", {"k": {"min": 5e6, "max": 9e6}, "c": {"min": 1e4, "max": 4e4}}, motion)
    free = fit_run("winkler", BLOCK, motion)
    assert np.all(np.abs(value_of(inside) - value_of(free)) < 0.2 * free.uncertainty.stderr)
    np.testing.assert_allclose(inside.uncertainty.stderr, free.uncertainty.stderr, rtol=0.05)
    assert inside.result.params["c"].max == pytest.approx(4e4)
    for given, named in (({"k": {"max": 6e6}}, "k"), ({"c": {"min": 3e4}}, "c")):
        at_bound = fitted("winkler", given, motion)
        assert not at_bound.success and at_bound.message == f"{named} lies at its bound of fits.parameters"
        limit = next(iter(given[named].values()))
        assert at_bound.values[named] == pytest.approx(limit, rel=1e-3)


def test_a_bad_start_does_no_harm():
    far = fitted("winkler", {"k": {"value": 2e9}, "c": {"value": 10.0}})
    near = fitted("winkler", {"k": {"value": 6.7e6}, "c": {"value": 2e4}})
    free = fit_run("winkler", BLOCK, released("winkler"))
    for fit in (far, near):
        assert np.all(np.abs(value_of(fit) - value_of(free)) < 0.2 * free.uncertainty.stderr)


def test_r_may_be_given():
    motion = released("housner")
    fixed = fitted("housner", {"r": {"value": 0.93, "vary": False}}, motion)
    assert fixed.values["r"] == 0.93 and fixed.success
    bounded = fitted("housner", {"r": {"min": 0.9, "max": 0.95, "value": 0.91}}, motion)
    free = fit_run("housner", BLOCK, motion)
    assert bounded.values["r"] == pytest.approx(free.values["r"], abs=0.2 * free.uncertainty.stderr[0])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"lambda": {"value": 1e8}},
            "winkler.lambda: is not a parameter of winkler; use k or c",
        ),
        ({"c": {"vary": False}}, "winkler.c: does not vary and has no value; give its value"),
        (
            {"c": {"expr": "k", "value": 1.0}},
            "an expr and more; leave out value, min, max and vary, or expr",
        ),
        ({"c": {"expr": "c"}}, "expr 'c' 'c' is not another parameter of the law"),
        ({"c": {"expr": "k"}, "k": {"expr": "c"}}, "is tied in a circle; free or fix one of them"),
        ({"c": {"value": 0.0, "vary": False}}, "value is 0; give a value above 0"),
        ({"c": {"min": -1.0}}, "min is -1; give 0 to inf"),
        ({"k": {"value": 1e12}}, r"value is 1e\+12; give 10000 to 1e\+11"),
        ({"k": {"min": 2e6, "max": 1e6}}, r"min 2e\+06 is not below max 1e\+06; correct one of the two"),
        ({"k": {"value": 3e6, "max": 1e6}}, r"value 3e\+06 is not between min and max; correct one of them"),
    ],
)
def test_mistakes_are_told_in_a_line(given, message):
    with pytest.raises(FreerockError, match=message) as caught:
        fitted("winkler", given)
    assert "\n" not in str(caught.value)


def test_where_nothing_is_left_to_fit_that_is_said():
    with pytest.raises(FreerockError, match="no parameter is free; free one"):
        fitted("housner", {"r": {"value": 0.9, "vary": False}}, free=())


def test_a_tie_that_leaves_the_possible_is_an_error_of_that_fit():
    with pytest.raises(FreerockError, match="fits"):
        fitted("winkler", {"c": {"expr": "k - 1e12"}})


def test_no_law_has_a_fault_where_nothing_is_given():
    assert not list(faults("winkler", {})) and not list(faults("winkler", {"k": Given()}))


def test_parameters_come_back_from_the_product(tmp_path):
    motion = released("winkler")
    fits = {
        "winkler": fitted("winkler", {"c": {"expr": "3.2e-3 * k"}, "k": {"min": 1e6, "max": 2e7}}, motion),
        "hunt_crossley": fit_run("hunt_crossley", BLOCK, motion),
    }
    attrs = {key: "x" for key in ("campaign", "test", "block", "foundation")}
    attrs |= {"origin": "simulated", "verdict": "ok", "reasons": []}
    write_fits(tmp_path / "fits.nc", {1: fits}, attrs)
    tree = open_fits(tmp_path / "fits.nc")
    for model, fit in fits.items():
        group = tree[f"run_1/{model}"]
        found, told = freerock.parameters_in(group.dataset), fit.result.params
        assert [*found] == [*told][: len(found)]
        for name in found:
            tie = bool(told[name].expr)  # without an error of its own
            for key in ("value", *([] if tie else ["stderr"]), "min", "max", "vary", "expr"):
                assert getattr(found[name], key) == getattr(told[name], key), (model, name, key)
            known = {each: by for each, by in (told[name].correl or {}).items() if each in found}
            assert (found[name].correl or {}) == pytest.approx(known)
        assert group.attrs["nfev"] == fit.result.nfev


@pytest.mark.parametrize("model", [HousnerModel, WinklerModel, HuntCrossleyModel])
def test_a_model_of_lmfit_finds_the_truth_from_its_guess_and_from_afar(model):
    law, motion = model.law, released(model.law)
    own = model(BLOCK)
    params = own.guess(motion.theta, time=motion.time_s)
    result = own.fit(motion.theta, params, time=motion.time_s, weights=1 / SIGMA)
    fit = fit_run(law, BLOCK, motion)
    truth = {**TRUTHS[law], "theta0": ALPHA, "t0": 0.0}
    for name, legal in own.func.names.items():
        each = result.params[name]
        assert abs(each.value - truth[legal]) < 4 * each.stderr
        assert each.value == pytest.approx(fit.values[legal], abs=each.stderr)
    assert result.redchi == pytest.approx(1.0, abs=0.15)
    away = own.make_params(**{name: 1.002 * each.value for name, each in result.params.items()})
    again = own.fit(motion.theta, away, time=motion.time_s, weights=1 / SIGMA)
    for name, each in result.params.items():
        assert again.params[name].value == pytest.approx(each.value, abs=0.1 * each.stderr)
    assert "[[Model]]" in result.fit_report() and result.plot() is not None


@pytest.mark.slow
@pytest.mark.parametrize("model", [HousnerModel, WinklerModel, HuntCrossleyModel])
def test_every_way_of_lmfit_gives_one_standard_error(model):
    """Curvature, profiles and the product's own fit, with an offset or without, before and after a pickle."""
    motion, own = released(model.law), model(BLOCK)
    data = {"time": motion.time_s, "weights": 1 / SIGMA}
    params = own.guess(motion.theta, time=motion.time_s)
    with_offset = params + lmfit.models.ConstantModel(prefix="off_").make_params(c=0.0)
    fit = fit_run(model.law, BLOCK, motion)
    plain = pickle.loads(pickle.dumps(own.fit(motion.theta, params, **data)))
    offset = lmfit.models.ConstantModel(prefix="off_")
    sums, offset_first = own + offset, offset + own
    ways = ("leastsq", "least_squares")
    shifted = [sums.fit(motion.theta, with_offset, method=each, x=motion.time_s, **data) for each in ways]
    first = next(iter(own.func.names))
    ((_, low), _, (_, high)) = plain.conf_interval(p_names=[first], sigmas=[1])[first]
    name = own.func.names[first]
    ((_, least), _, (_, most)) = fit.conf_interval(name, sigmas=[1])[first]
    told = dict(zip(fit.parameters, fit.u_total, strict=True))[name]
    errors = [told, (high - low) / 2, (most - least) / 2]
    shifted.append(offset_first.fit(motion.theta, with_offset, x=motion.time_s, **data))
    errors += [result.params[first].stderr for result in (plain, *shifted)]
    np.testing.assert_allclose(errors, told, rtol=0.1)
    band = plain.eval_uncertainty()
    assert band.shape == motion.theta.shape and 0 < band.max() < SIGMA
    assert fit.params[first].stderr == pytest.approx(told) and fit.result.redchi == pytest.approx(1, abs=0.15)
    again = pickle.loads(pickle.dumps(fit))
    assert again.fit_report() == fit.fit_report() and again.minimizer.least_squares().success


def test_a_fit_draws_what_it_found():
    fit = fit_run("housner", BLOCK, released("housner"))
    above, below = fit.plot().axes
    np.testing.assert_array_equal(above.lines[1].get_ydata(), fit.curve.theta_model)
    np.testing.assert_array_equal(below.lines[0].get_ydata(), fit.curve.residual)
    recorded, law = (text.get_text() for text in above.get_legend().get_texts())
    assert recorded == "recorded" and law.startswith("Housner, $ε_θ$ = ")


def test_a_guess_starts_at_the_measured_release_within_the_bounds_of_a_fit():
    motion, model = released("winkler"), WinklerModel(BLOCK)
    found = model.guess(motion.theta, time=motion.time_s, theta0=motion.theta0)
    fit = fit_run("winkler", BLOCK, motion)
    assert found["theta0"].value == motion.theta0
    for name in ("k", "c", "theta0", "t0"):
        limits = fit.params[name].min, fit.params[name].max
        far = name in ("k", "c")  # lmfit's steps are coarse between two far bounds
        assert found[name].min == pytest.approx(limits[0], rel=0.01)
        assert found[name].max == (np.inf if far else pytest.approx(limits[1], rel=0.01))
    deep = model.guess(motion.theta, time=motion.time_s, k={"min": 1e6})
    assert deep["k"].min == 1e6


TIME = np.arange(0, 1, 2e-3)
MOTION = Motion(TIME, ALPHA - 0.1 * TIME**2, SIGMA, ALPHA)
PARAMS = WinklerModel(BLOCK).make_params(theta0=ALPHA)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: Block(-1, 0.07, 5.84), "height_m: -1 is not a positive number; give it in metres"),
        (lambda: Block(280, 70, 5.84), "give height_m and width_m in metres, mass_kg in kilograms"),
        (
            lambda: Motion(TIME[::-1], TIME, 1e-4, 0.1),
            "time: does not increase; give one array, sort it",
        ),
        (lambda: Motion(TIME, TIME[1:], 1e-4, 0.1), r"have the shapes \(500,\) and \(499,\)"),
        (lambda: Motion(1e3 * TIME, TIME, 1e-4, 0.1), "its steps are too long for rocking"),
        (lambda: Motion(TIME, 57.3 * TIME, 1e-4, 0.1), "theta: turns by more than 2 rad; give it in rad"),
        (lambda: Motion(TIME, TIME, 1e-2, 9.7), "theta0 9.7; give both in rad"),
        (lambda: Motion(TIME, TIME, TIME, 0.1), "sigma_theta: ndarray is no Real; give one number, in rad"),
        (lambda: fit_run("housner", {"height_m": 0.28}, MOTION), "block: dict is no Block"),
        (lambda: fit_run("housner", BLOCK, TIME), r"motion: ndarray is no Motion; give run.motion"),
        (lambda: fit_run("housner", BLOCK, MOTION, FitSettings(debonding="glue")), "unknown rule 'glue'"),
        (lambda: fit_run("housner", BLOCK, MOTION, {"free": []}), "settings: dict is no FitSettings"),
        (lambda: freerock.fit_record("housner", BLOCK, [MOTION]), "motions: list is no Mapping"),
        (lambda: HousnerModel({}), "block: dict is no Block"),
        (lambda: HousnerModel(BLOCK, view=1), "view: int is no View"),
        (lambda: HousnerModel(BLOCK, rules="tensionless"), "rules: str is no Rules"),
        (
            lambda: WinklerModel(BLOCK).guess(TIME, time=TIME, lambda_=1.0),
            "'lambda_' is no parameter of winkler",
        ),
        (lambda: WinklerModel(BLOCK).fit(TIME, PARAMS, time=TIME[::-1]), "time: does not increase"),
        (lambda: WinklerModel(BLOCK).fit(57.3 * TIME, PARAMS, time=TIME), "theta: turns by more than 2 rad"),
        (lambda: WinklerModel(BLOCK).fit(np.nan * TIME, PARAMS, time=TIME), 'nan_policy="omit"'),
        (lambda: WinklerModel(BLOCK).eval(PARAMS, time=np.nan * TIME), "time: does not increase"),
        (lambda: freerock.view_of("laser", BLOCK), "laser: l?.* is no Laser"),
        (lambda: freerock.find_impacts(TIME, TIME, 1e-4, None), "block: NoneType is no Block"),
        (lambda: freerock.parameters_in(xr.Dataset()), "has no parameters; give that of a model"),
        (lambda: Motion(["a"], TIME, 1e-4, 0.1), "time: holds no numbers"),
        (lambda: WinklerModel(BLOCK).guess(TIME, time=TIME[::-1]), "time: does not increase"),
        (lambda: freerock.find_impacts(TIME[::-1], TIME, 1e-4, BLOCK), "time: does not increase"),
        (lambda: freerock.simulate("housner", BLOCK, {"r": 0.9}, TIME, theta0=9.7), "give the angle in rad"),
    ],
)
def test_wrong_input_is_refused_at_the_door_in_a_line(made, message):
    with pytest.raises(FreerockError, match=message) as caught:
        made()
    assert "\n" not in str(caught.value)


def test_lists_are_as_good_as_arrays():
    motion = released("housner")
    lists = Motion(motion.time_s.tolist(), motion.theta.tolist(), SIGMA, ALPHA, 2e-5, 5e-4)
    of_lists, of_arrays = (fit_run("housner", BLOCK, each) for each in (lists, motion))
    assert value_of(of_lists) == pytest.approx(value_of(of_arrays))


def test_a_model_may_fix_tie_and_prefix_its_parameters():
    motion, model = released("winkler"), WinklerModel(BLOCK, prefix="w_")
    params = model.guess(motion.theta, time=motion.time_s)
    params["w_c"].set(expr=f"w_k*{2.17e4 / 6.77e6!r}")
    result = model.fit(motion.theta, params, time=motion.time_s, weights=1 / SIGMA)
    k = result.params["w_k"]
    assert result.nvarys == 3 and abs(k.value - 6.77e6) < 4 * k.stderr
