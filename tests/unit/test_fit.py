"""One model of a run with impacts that scatter, fitted by lmfit alone."""

from dataclasses import replace
from types import SimpleNamespace

import lmfit
import numpy as np
import pytest
from scattered import BLOCK, SIGMA, TRUTH, scattered_run
from scipy.optimize import differential_evolution

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.fit import Followers, fit_record, fit_run, settled
from freerock.identification.goodness import goodness
from freerock.identification.paper_fit import RELEASE_WALLS, paper_fit
from freerock.identification.posed import release_prior
from freerock.identification.posterior import Posterior
from freerock.identification.run_model import Point, RunModel
from freerock.identification.samples import Samples
from freerock.identification.scatter import Told, find_scatter
from freerock.identification.start import Followed, crossings_s, in_step, whole_s
from freerock.models.block import Block
from freerock.models.simulate import Solver, simulate_fitted
from freerock.noise.spectrum import white_noise
from freerock.runs.motion import Motion


@pytest.fixture(scope="module")
def record():
    """Two runs of a record with σ_r = 1 %, and their true δ."""
    return dict(enumerate(scattered_run("hunt_crossley", 0.01, seed) for seed in (1, 2)))


@pytest.fixture(scope="module")
def fits(record):
    return fit_record("hunt_crossley", BLOCK, {run: motion for run, (motion, _) in record.items()})


def test_k_and_lambda_are_found_beside_impacts_that_scatter(fits):
    for fit in fits.values():
        assert fit.success and fit.evidence.agrees
        for name, true in TRUTH["hunt_crossley"].items():
            i = fit.parameters.index(name)
            assert abs(fit.value[i] - true) < 3.3 * fit.u_total[i]
        assert abs(fit.values["k"] / TRUTH["hunt_crossley"]["k"] - 1) < 2e-3


def test_delta_of_each_impact_is_found(fits, record):
    for run, fit in fits.items():
        n = len(fit.scatter.delta) - 1
        z = (fit.scatter.delta[:n] - record[run][1][:n]) / fit.scatter.u_delta[:n]
        assert np.sqrt(np.mean(z**2)) < 1.8 and n >= 5
        # the data tell them far better than their prior
        assert np.median(fit.scatter.u_delta[:n]) < 0.3 * fit.scatter.of_record.sigma_r


def test_the_runs_of_a_record_have_one_sigma_r(fits):
    one, other = (fit.scatter.of_record for fit in fits.values())
    assert one == other and 0 < one.low < 0.01 < one.high


def test_clean_runs_have_no_scatter_and_no_impact_free():
    fit = fit_run("hunt_crossley", BLOCK, scattered_run("hunt_crossley", 0.0, 5)[0])
    assert fit.scatter.of_record.sigma_r == 0 and fit.scatter.delta.size == 0 and fit.evidence.agrees
    assert abs(fit.values["k"] / TRUTH["hunt_crossley"]["k"] - 1) < 1e-3


def test_the_result_is_lmfits(fits):
    result = fits[0].result
    assert {"k", "lambda_", "theta0", "t0", "impact_1"} <= {*result.params}
    assert result.errorbars and "could not be estimated" not in lmfit.fit_report(result)
    assert 0.8 < result.redchi < 1.25
    assert result.params["k"].stderr == pytest.approx(fits[0].u_total[0], rel=1e-6)
    assert result.params["k"].correl["lambda_"] == pytest.approx(
        fits[0].uncertainty.covariance[0, 1] / np.prod(fits[0].u_total[:2]), rel=1e-3
    )


def test_without_lmfit_there_is_no_fit(monkeypatch, record):
    def refuse(*_, **__):
        raise RuntimeError("lmfit")

    monkeypatch.setattr(lmfit.Minimizer, "least_squares", refuse)
    for fitted in (fit_run, paper_fit):
        with pytest.raises(RuntimeError):
            fitted("winkler", BLOCK, record[0][0])


def test_numbers_that_are_given_are_kept(record):
    given = {"hunt_crossley": {"k": {"value": 2.9e6, "vary": False}}}
    fit = fit_run("hunt_crossley", BLOCK, record[0][0], FitSettings(parameters=given))
    assert fit.values["k"] == 2.9e6 and fit.u_total[0] == 0
    tied = {"winkler": {"c": {"expr": "0.009*k"}}}
    fit = fit_run("winkler", BLOCK, scattered_run("winkler", 0.01, 3)[0], FitSettings(parameters=tied))
    assert fit.values["c"] == pytest.approx(0.009 * fit.values["k"], rel=1e-9) and fit.u_total[1] > 0


def test_a_law_whose_every_number_is_given_has_evidence():
    settings = FitSettings(parameters={"housner": {"r": {"value": 0.93, "vary": False}}})
    motion, _ = scattered_run("housner", 0.02, 3)
    held, free = (fit_run("housner", BLOCK, motion, each) for each in (settings, None))
    assert held.evidence.minus_two_log == pytest.approx(free.evidence.minus_two_log, abs=20)


def test_an_unknown_candidate_and_a_run_without_samples_are_refused(record):
    with pytest.raises(FreerockError, match="unknown model"):
        fit_run("maxwell", BLOCK, record[0][0])
    motion = scattered_run("housner", 0.0, 1, duration_s=0.003)[0]
    with pytest.raises(FreerockError, match="fewer valid samples"):
        fit_run("winkler", BLOCK, motion)


@pytest.mark.parametrize("candidate", ["housner", "winkler", "hunt_crossley_pivoting"])
def test_derivatives_are_those_of_the_curve(candidate):
    motion, delta = scattered_run(candidate, 0.01, 4)
    model = RunModel(candidate, BLOCK, motion)
    time_s = motion.time_s[::5]
    values = {**TRUTH[candidate], "theta0": 0.17, "t0": 1e-4}
    samples = Samples(time_s, np.zeros(time_s.size))
    at = model.held(Point(values, np.zeros(0), delta[:4]), samples)
    columns = model.derivatives(at, samples)[: time_s.size]
    for j, name in enumerate(model.names):
        step = 1e-5 * max(abs(values[name]), 1e-2)
        up, down = (
            model.curve(replace(at, values={**values, name: values[name] + by}), time_s, 1e-11)
            for by in (step, -step)
        )
        central = (up - down) / (2 * step)
        assert np.linalg.norm(columns[:, j] - central) < 2e-3 * np.linalg.norm(central), name
    for i in range(4):
        moved = 1e-5 * np.eye(4)[i]
        up, down = (
            model.curve(replace(at, rates=at.rates * (1 + by)), time_s, 1e-11) for by in (moved, -moved)
        )
        central = (up - down) / 2e-5
        assert np.linalg.norm(columns[:, len(model.names) + i] - central) < 2e-3 * np.linalg.norm(central)


def test_the_papers_fit_is_the_global_minimum(record):
    motion = record[0][0]
    found = paper_fit("winkler", BLOCK, motion)
    model = RunModel("winkler", BLOCK, motion, moves_inputs=False)
    prior, whole = release_prior(model), model.whole

    def epsilon(x):
        values = {"k": np.exp(x[0]), "c": np.exp(x[0] + x[1]), "theta0": x[2], "t0": x[3]}
        theta = model.curve(Point(values, np.zeros(0), np.zeros(0)), whole.time_s[::4], 1e-6)
        return epsilon_theta(whole.time_s[::4], theta, whole.theta[::4])

    walls = [
        (value - RELEASE_WALLS * u, value + RELEASE_WALLS * u) for value, u in (prior["theta0"], prior["t0"])
    ]
    bounds = [(np.log(3e5), np.log(1e9)), (np.log(1e-4), np.log(0.1)), *walls]
    least = differential_evolution(epsilon, bounds, seed=1, maxiter=60, popsize=10, tol=1e-6)
    assert found.epsilon_theta <= 1.01 * least.fun
    assert found.success and np.isfinite(found.stderr).all()


@pytest.mark.parametrize("sigma_r", [0.0, 0.003, 0.03])
def test_sigma_r_by_the_marginal_likelihood(sigma_r):
    generator = np.random.default_rng(8)
    inside = 0
    for _ in range(20):
        runs = []
        for _ in range(3):
            u = 10 ** generator.uniform(-3.5, -2.5, 20)
            seen = sigma_r * generator.standard_normal(20) + u * generator.standard_normal(20)
            runs.append(Told(np.diag(u**-2), seen / u**2))
        found = find_scatter(runs)
        inside += found.low <= sigma_r <= found.high
        if sigma_r >= 0.003:
            assert 0.6 * sigma_r < found.sigma_r < 1.6 * sigma_r
    assert inside >= (17 if sigma_r else 18)


def test_goodness_tells_noise_from_a_law_that_is_wrong():
    generator, noise = np.random.default_rng(3), white_noise(1.0, 400.0)
    residual, column = generator.standard_normal(2000), np.linspace(0, 1, 2000)[:, None]
    clean = goodness(residual, column, noise)
    assert clean.agrees and clean.over_noise == pytest.approx(1, abs=0.05)
    swing = goodness(residual + np.sin(np.arange(2000) / 30), column, noise)
    assert not swing.agrees and swing.low_hz <= 400 / (2 * np.pi * 30) <= swing.high_hz


def test_what_a_fit_takes_of_a_run_ends_with_the_last_impact_that_is_seen(record):
    motion = record[0][0]
    crossings = crossings_s(motion)
    assert whole_s(motion) == crossings[-1]
    assert np.abs(motion.theta[motion.time_s < crossings[-1]]).max() > 10 * SIGMA


def test_a_point_in_step_has_swings_that_last_as_long_as_measured():
    motion, _ = scattered_run("hunt_crossley", 0.01, 3)
    model, true = RunModel("hunt_crossley", BLOCK, motion, FitSettings()), TRUTH["hunt_crossley"]
    values = {"k": 1.03 * true["k"], "lambda": true["lambda"], "theta0": motion.theta0, "t0": 0.0}
    start = Point(values, np.zeros(len(model.inputs)), np.zeros(0))
    found = in_step(model, start, whole_s(motion))
    measured = crossings_s(motion)
    own = crossings_s(replace(motion, theta=model.curve(found, motion.time_s)))
    n = min(own.size, measured.size)
    assert n > 0.8 * measured.size
    assert np.abs(own[1:n] - measured[1:n]).max() < 0.03 * np.diff(measured).max()


def test_a_rigid_block_with_many_impacts_that_scatter_is_followed_to_its_end():
    block, generator = Block(0.9, 0.25, 150.0), np.random.default_rng(10)
    time_s, delta = np.arange(0, 26, 1 / 300), 0.01 * generator.standard_normal(150)
    values = {"r": 0.965, "theta0": 0.12, "t0": 0.0, "impacts": delta}
    theta = simulate_fitted("housner", block, values, time_s, solver=Solver(1e-10))
    theta = theta + SIGMA * generator.standard_normal(time_s.size)
    motion = Motion(time_s, theta, SIGMA, 0.12, SIGMA / 30, 1e-4)
    end = Followers("housner", block, {1: motion}, FitSettings()).end_of_first
    assert end.over_noise < 4  # 54 where no swing is brought into step


def test_the_result_of_a_search_is_where_it_ended_however_wide_its_impacts():
    motion, _ = scattered_run("hunt_crossley", 0.02, 3)
    models = Followers("housner", BLOCK, {1: motion}, FitSettings()).models
    (end,) = Followed(models[1]).screened
    assert end.at.impacts.max() > 0.5
    left = end.minimizer.userfcn(end.result.params)
    assert left @ left == pytest.approx(end.result.chisqr)


class Lost:
    """A candidate that can't be followed."""

    @property
    def glimpsed(self):
        raise FreerockError("fits", "lost", "none")


def test_a_law_starts_where_one_of_its_cases_ends():
    motion, _ = scattered_run("hunt_crossley", 0.01, 3)
    model = Followers("general", BLOCK, {1: motion}, FitSettings()).models[1]
    assert Followed(model, others={"winkler": Lost()}).screened[0].over_noise < 1.5
    with pytest.raises(FreerockError, match="winkler and hunt_crossley have no fit to start from"):
        _ = Followed(model, others={"winkler": Lost(), "hunt_crossley": Lost()}).glimpsed


def test_a_width_that_is_freed_is_found_below_the_stated_one():
    worn = replace(BLOCK, width_m=0.94 * BLOCK.width_m)
    motion, _ = scattered_run("hunt_crossley", 0.01, 3, theta0=0.15, block=worn)
    followers = Followers("hunt_crossley_width", BLOCK, {1: motion}, FitSettings())
    assert followers.followed.screened[0].over_noise < 1.5  # 1e5 from the stated width alone
    assert followers.ends()[1].at.values["width"] == pytest.approx(0.94 * BLOCK.width_m, rel=0.01)


def test_a_rejected_law_comes_to_its_minimum_or_its_u_holds_the_step_ahead(record):
    motions = {run: motion for run, (motion, _) in record.items()}
    for law, most in (("winkler", 1.01), ("housner", 1.2)):
        followers = Followers(law, BLOCK, motions, FitSettings())
        rough, exact = settled(followers.ends(roughly=True), roughly=True), settled(followers.ends())
        for run, fit in rough.items():
            share = fit.evidence.residual_over_noise / exact[run].evidence.residual_over_noise
            assert 1 / most < share < most
            name = fit.parameters[0]
            u = fit.u_total[0]
            assert abs(fit.values[name] - exact[run].values[name]) < u
            assert abs(fit.posterior.step[0]) <= fit.uncertainty.u_law[0] <= u
    assert rough[0].posterior.step[0] != 0


def test_a_number_that_the_run_does_not_move_is_not_determined():
    motion, _ = scattered_run("hunt_crossley", 0.0, 5)
    few = replace(motion, theta=np.where(motion.time_s < crossings_s(motion)[0], motion.theta, np.nan))
    fit = fit_run("housner", BLOCK, few)
    assert not fit.success and "determine" in fit.message


def test_an_impact_that_leaves_no_trace_tells_nothing():
    at, rows = Point({}, np.zeros(0), np.array([0.01, 0.0])), np.diag([100.0, 0.0])
    posed = SimpleNamespace(model=SimpleNamespace(names=()), sigma_r=0.02)
    noise, every = white_noise(1e-4, 1e3), np.ones(2, bool)
    told = Posterior(posed, at, noise, np.zeros(2), rows, every, np.eye(2)).told
    assert np.isfinite(told.precision).all() and find_scatter([told]).sigma_r < 0.1
