import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.fit import fit_record, fit_run
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES
from freerock.models.simulate import Solver, simulate_theta
from freerock.runs.motion import Motion

CONFIG2 = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
CONFIG3 = Block(height_m=0.14, width_m=0.07, mass_kg=2.98)
TRUTHS = {
    "housner": {"r": 0.93},
    "winkler": {"k": 4.5e6, "c": 4.05e4},
    "hunt_crossley": {"k": 6.88e6, "lambda": 1.30e8},
}


def motion(model, parameters, *, block=CONFIG2, alpha=math.radians(10), t0=0.0, sigma=1e-4, seed=1, span=4.0):
    """A simulated run whose release the reader of the record took t0 too early."""
    time = np.arange(0, span, 5e-4)
    law, rules = CANDIDATES[model].law, CANDIDATES[model].rules("geometric")
    solver = Solver(1e-10)
    theta, outcome = simulate_theta(
        law, block, parameters, time - t0, theta0=alpha, rules=rules, solver=solver
    )
    assert outcome in ("completed", "at_rest")
    noise = np.random.default_rng(seed).normal(0, sigma, len(time))
    return Motion(
        time, theta + noise, sigma, theta0=alpha + 2e-5, theta0_stderr=2e-5, t0_stderr=2e-3, fit_start_s=0.02
    )


@pytest.mark.parametrize("model", [*TRUTHS, "winkler_pivoting", "hunt_crossley_pivoting"])
@pytest.mark.parametrize("block, alpha", [(CONFIG2, 10), (CONFIG3, 20)])
def test_truth_is_recovered_within_the_reported_uncertainty(model, block, alpha):
    parameters = TRUTHS[CANDIDATES[model].law]
    run = motion(model, parameters, block=block, alpha=math.radians(alpha), t0=1.3e-3)
    fit = fit_run(model, block, run)
    assert fit.success, fit.message
    found = dict(zip(fit.parameters, zip(fit.value, fit.stderr, strict=True), strict=True))
    truth = {**parameters, "theta0": math.radians(alpha), "t0": 1.3e-3}
    assert set(found) == set(truth)
    for name, (value, stderr) in found.items():
        assert abs(value - truth[name]) < 4 * stderr, name
        assert name == "t0" or stderr < 5e-3 * abs(truth[name]), name
    assert fit.diagnostics["residual_over_sigma"] == pytest.approx(1, abs=0.03)
    assert fit.diagnostics["integrator_error"] <= 0.2


def test_only_the_freed_nuisances_are_fitted():
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"])
    assert fit_run("hunt_crossley", CONFIG2, run, FitSettings(free=())).parameters == ("k", "lambda")
    assert fit_run("hunt_crossley", CONFIG2, run, FitSettings(free=("t0",))).parameters == (
        "k",
        "lambda",
        "t0",
    )


def test_the_rigid_model_on_a_compliant_base_makes_up_for_the_longer_period():
    """Fitted r 0.957 and not the 0.94 of the single impacts (docs/equations.md)."""
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"], sigma=1e-6, span=8.0)
    fit = fit_run("housner", CONFIG2, run, FitSettings(free=()))
    assert fit.value[0] == pytest.approx(0.957, abs=0.003)
    assert fit.diagnostics["coloured"] == 1
    assert 0.15 < fit.epsilon_theta < 0.30


def test_a_free_release_does_not_make_a_compliant_foundation_rigid():
    """At its bounds, where least squares from elsewhere than r's own minimum crept to no end."""
    config1 = Block(height_m=0.42, width_m=0.07, mass_kg=8.67)
    law = {"k": 6.5e6, "lambda": 1.35e8}
    run = motion("hunt_crossley", law, block=config1, alpha=math.radians(6), span=8.0)
    run = replace(run, t0_stderr=2e-4)
    fit = fit_run("housner", config1, run)
    alone = fit_run("housner", config1, run, FitSettings(free=()))
    in_phase, by_itself = fit.diagnostics, alone.diagnostics
    epsilon = by_itself["in_phase_epsilon_theta"]
    assert 0.9 * epsilon < in_phase["in_phase_epsilon_theta"] < epsilon
    assert abs(in_phase["in_phase_r"] - by_itself["in_phase_r"]) < 2e-3


@pytest.mark.parametrize("free", [(), ("theta0", "t0")])
@pytest.mark.parametrize(
    ("law", "kept", "stops"),
    [({"k": 6.88e6, "lambda": 1.30e8}, 0.84, 0.767), ({"k": 2.86e6, "lambda": 8.16e7}, 1.265, 0.487)],
)
def test_a_rigid_block_has_the_minimum_over_all_r_and_says_where_it_stops_rocking(law, kept, stops, free):
    """Configuration 1 of Spanos et al. 2017: the nearest r in phase is worse than a block that stops."""
    config1 = Block(height_m=0.42, width_m=0.07, mass_kg=8.67)
    run = motion("hunt_crossley", law, block=config1, alpha=math.radians(6), span=8.0)
    run = replace(run, t0_stderr=2e-4)
    fit = fit_run("housner", config1, run, FitSettings(free=free))
    assert not fit.success and fit.value[0] == 0.0 and np.isnan(fit.stderr[0])
    assert fit.message.startswith("the block stops rocking at the minimum, r = 0 with ε_θ = ")
    assert fit.epsilon_theta == pytest.approx(stops, rel=0.05)
    assert fit.diagnostics["in_phase_epsilon_theta"] == pytest.approx(kept, rel=0.05)
    time_s = run.time_s
    for r in np.linspace(0.0, 1.0, 41)[:-1]:
        theta, _ = simulate_theta("housner", config1, {"r": r}, time_s, theta0=run.theta0)
        assert epsilon_theta(time_s, theta, run.theta) > 0.999 * fit.epsilon_theta


def test_a_rigid_block_keeps_its_r_where_that_is_the_nearest():
    config3 = Block(height_m=0.14, width_m=0.07, mass_kg=2.98)
    run = motion("hunt_crossley", {"k": 6.88e6, "lambda": 1.30e8}, block=config3, alpha=math.radians(20))
    fit = fit_run("housner", config3, run)
    assert fit.success and fit.value[0] > 0.8 and "in_phase_r" not in fit.diagnostics


def test_joint_fit_shares_the_parameters_and_is_tighter():
    truth = TRUTHS["hunt_crossley"]
    runs = [motion("hunt_crossley", truth, alpha=math.radians(a), seed=a, t0=1e-3) for a in (9, 10)]
    joint = fit_record("hunt_crossley", CONFIG2, runs)
    assert joint.parameters == ("k", "lambda", "theta0_1", "t0_1", "theta0_2", "t0_2")
    alone = fit_run("hunt_crossley", CONFIG2, runs[0])
    for i, name in enumerate(("k", "lambda")):
        assert abs(joint.value[i] - truth[name]) < 4 * joint.stderr[i]
        assert joint.stderr[i] < alone.stderr[i]


@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
def test_the_guided_law_on_a_pivoting_block_gives_another_stiffness(law):
    """docs/equations.md: k and λ mean what the kinematics makes of them."""
    run = motion(f"{law}_pivoting", TRUTHS[law], block=CONFIG3, alpha=math.radians(20))
    guided = fit_run(law, CONFIG3, run)
    assert guided.diagnostics["white"] == 0
    assert guided.value[0] < 0.7 * TRUTHS[law]["k"]


def test_a_candidate_frees_its_width_beside_what_is_freed_already():
    worn = replace(CONFIG2, contact_width_m=0.066)
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"], block=worn)
    fit = fit_run("hunt_crossley_width", CONFIG2, run, FitSettings(free=("theta0",)))
    assert fit.model == "hunt_crossley_width"
    assert fit.parameters == ("k", "lambda", "width", "theta0") and fit.n_parameters == 4
    truth = {**TRUTHS["hunt_crossley"], "width": 0.066}
    for name, value, stderr in zip(fit.parameters, fit.value, fit.stderr, strict=False):
        assert name == "theta0" or abs(value - truth[name]) < 4 * stderr, name
    as_freed = fit_run("hunt_crossley", CONFIG2, run, FitSettings(free=("width", "theta0")))
    assert np.array_equal(fit.value, as_freed.value) and np.array_equal(fit.stderr, as_freed.stderr)


def test_coloured_noise_widens_the_intervals():
    time = np.arange(0, 4, 5e-4)
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"])
    white = fit_run("hunt_crossley", CONFIG2, run)
    slow = np.convolve(
        np.random.default_rng(3).normal(size=len(time) + 199), np.ones(200) / 200**0.5, "valid"
    )
    coloured = fit_run("hunt_crossley", CONFIG2, Motion(**{**vars(run), "theta": run.theta + 1e-4 * slow}))
    assert white.diagnostics["coloured"] == 0
    assert coloured.diagnostics["coloured"] == 1
    assert np.all(coloured.stderr[:2] > 3 * white.stderr[:2])


def test_holdout_of_the_true_law_is_at_the_noise():
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"], sigma=1e-5)
    assert fit_run("hunt_crossley", CONFIG2, run).epsilon_holdout < 1e-4


@pytest.mark.parametrize(
    "model, why",
    [
        ("housner", "the block stops rocking at the minimum, "),
        ("hunt_crossley", "lambda lies at its bound"),
    ],
)
def test_a_motion_that_gains_energy_is_a_failed_fit_without_error_bars(model, why):
    decaying = motion(model, TRUTHS[model], span=2.0)
    last_peak = np.flatnonzero(np.diff(np.sign(np.diff(decaying.theta))))[-1]
    growing = decaying.theta[:last_peak][::-1]
    run = Motion(decaying.time_s[:last_peak], growing, 1e-4, theta0=growing[0], theta0_stderr=1e-5)
    fit = fit_run(model, CONFIG2, run, FitSettings(free=()))
    assert not fit.success
    assert fit.message.startswith(why)
    assert np.all(np.isnan(fit.stderr))
    assert np.isfinite(fit.epsilon_theta)


def test_a_nuisance_at_its_bound_is_held_there_and_named():
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"], t0=0.06)
    fit = fit_run("hunt_crossley", CONFIG2, run)
    assert fit.success
    assert fit.message.startswith("converged") and "t0 held at its bound" in fit.message
    assert np.isnan(fit.stderr[fit.parameters.index("t0")])
    assert np.all(np.isfinite(fit.stderr[:2]))


@pytest.mark.parametrize(
    "change, message",
    [
        (
            {"model": "hausner"},
            f"fits.models: unknown model 'hausner'; use one of {', '.join(CANDIDATES)}",
        ),
        (
            {"free": ("theta_0",)},
            "fits.free.housner: unknown nuisance 'theta_0'; use width, tilt, theta0, t0 or edge_radius",
        ),
        (
            {"model": "housner_width", "free": ("theta_0",)},
            "fits.free.housner: unknown nuisance 'theta_0'; use width, tilt, theta0, t0 or edge_radius",
        ),
    ],
)
def test_wrong_arguments_are_named(change, message):
    run = Motion(np.arange(9.0), np.ones(9), 1e-4, theta0=0.1)
    arguments = {"model": "housner", "free": ()} | change
    with pytest.raises(FreerockError) as error:
        fit_run(arguments["model"], CONFIG2, run, FitSettings(free=arguments["free"]))
    assert str(error.value) == message


def test_a_worn_base_shows_in_the_width():
    worn = Block(0.28, 0.07, 5.84, contact_width_m=0.063)
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"], block=worn, alpha=math.radians(8))
    fit = fit_run("hunt_crossley", CONFIG2, run, FitSettings(free=("width", "theta0", "t0")))
    width = fit.parameters.index("width")
    assert fit.success, fit.message
    assert abs(fit.value[width] - 0.063) < 4 * fit.stderr[width] < 4e-4
    assert fit.units[width] == "m"
    assert not fit_run("hunt_crossley", CONFIG2, run).diagnostics["white"]


def test_profile_intervals_are_those_of_the_covariance_where_the_residual_is_white():
    run = motion("winkler", TRUTHS["winkler"])
    plain, profiled = (fit_run("winkler", CONFIG2, run, FitSettings(profile=p)) for p in (False, True))
    for name in ("ci95_low", "ci95_high"):
        ends, middle = (getattr(fit, name)[:2] for fit in (plain, profiled)), plain.value[:2]
        assert np.divide(*(end - middle for end in ends)) == pytest.approx(1, abs=0.05)
    assert profiled.diagnostics["profile"] == 1


def test_the_general_law_finds_both_dampings():
    truth = {"k": 6e6, "c": 1e4, "lambda": 6e7}
    run = motion("general", truth)
    fit = fit_run("general", CONFIG2, run)
    for name, value, stderr in zip(fit.parameters[:3], fit.value, fit.stderr, strict=False):
        assert abs(value - truth[name]) < 4 * stderr < 0.02 * truth[name], name
    lacking = fit_run("winkler", CONFIG2, run).diagnostics
    assert not lacking["white"] or lacking["added_damping"] > 3


def test_blocks_on_one_foundation_are_fitted_jointly():
    truth = TRUTHS["hunt_crossley"]
    blocks = [CONFIG2, CONFIG3]
    runs = [
        motion("hunt_crossley", truth, block=b, alpha=a) for b, a in zip(blocks, (0.17, 0.3), strict=True)
    ]
    joint = fit_record("hunt_crossley", blocks, runs)
    for i, name in enumerate(("k", "lambda")):
        assert abs(joint.value[i] - truth[name]) < 4 * joint.stderr[i] < 0.01 * truth[name]
    with pytest.raises(FreerockError) as error:
        fit_record("hunt_crossley", blocks, runs, FitSettings(free=("width",)))
    assert str(error.value) == "fits.free.hunt_crossley: one width for several blocks; remove width"


def test_samples_are_averaged_and_the_tolerance_loosened_as_far_as_the_errors_bear():
    fit = fit_run("hunt_crossley", CONFIG2, motion("hunt_crossley", TRUTHS["hunt_crossley"]))
    assert fit.diagnostics["averaged"] >= 8
    assert fit.diagnostics["rtol"] >= 1e-7
    exact = fit_run("hunt_crossley", CONFIG2, motion("hunt_crossley", TRUTHS["hunt_crossley"], sigma=1e-8))
    assert exact.diagnostics["rtol"] <= 1e-8
    assert exact.value[:2] == pytest.approx(list(TRUTHS["hunt_crossley"].values()), rel=1e-6)


def test_an_unknown_width_widens_the_intervals():
    worn = Block(0.28, 0.07, 5.84, contact_width_m=0.066)
    runs = [
        motion("hunt_crossley", TRUTHS["hunt_crossley"], block=block, alpha=math.radians(8))
        for block in (CONFIG2, worn)
    ]
    right, wrong = (fit_run("hunt_crossley", CONFIG2, run) for run in runs)
    assert wrong.success and not wrong.diagnostics["white"]
    assert np.all(wrong.stderr[:2] > 20 * right.stderr[:2])


def test_a_run_without_samples_of_its_own_is_refused():
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"])
    lost = Motion(**{**vars(run), "theta": np.full_like(run.theta, np.nan)})
    with pytest.raises(FreerockError, match="fewer valid samples than parameters"):
        fit_record("hunt_crossley", CONFIG2, [run, lost])


def test_a_run_whose_first_half_is_lost_has_no_held_out_discrepancy():
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"])
    half = Motion(**{**vars(run), "theta": np.where(run.time_s < 2.0, np.nan, run.theta)})
    assert np.isnan(fit_run("hunt_crossley", CONFIG2, half).epsilon_holdout)
    assert np.isnan(fit_run("housner", CONFIG2, half, FitSettings(free=())).epsilon_holdout)


def test_a_late_start_of_the_samples_is_no_trouble():
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"])
    fit = fit_run("hunt_crossley", CONFIG2, Motion(**{**vars(run), "fit_start_s": 1.0}))
    assert fit.success
    assert abs(fit.value[0] - TRUTHS["hunt_crossley"]["k"]) < 4 * fit.stderr[0]


def test_the_general_law_has_no_tensionless_rule():
    run = motion("hunt_crossley", TRUTHS["hunt_crossley"])
    with pytest.raises(FreerockError) as error:
        fit_run("general", CONFIG2, run, FitSettings(debonding="tensionless"))
    assert str(error.value) == (
        "fits.debonding: the tensionless rule is not available for c and lambda together; "
        "use geometric or remove general from fits.models"
    )


def test_too_few_samples_are_refused():
    run = Motion(np.arange(3.0), np.full(3, np.nan), 1e-4, theta0=0.1)
    with pytest.raises(FreerockError, match="fewer valid samples than parameters"):
        fit_run("housner", CONFIG2, run, FitSettings(free=()))
