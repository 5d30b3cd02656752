"""The law of a block that bounces: when it is tried, and what a fit tells of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import fit_run
from freerock.models.block import Block
from freerock.models.contact import State
from freerock.models.laws import LAWS
from freerock.models.simulate import simulate
from freerock.runs.motion import Motion, motion_of
from freerock.runs.segment import Run
from freerock.runs.verdict import Reason, Verdict
from freerock.selection.allowed_hypotheses import BY_DEFAULT, Hypotheses
from freerock.selection.choice import evidence
from freerock.selection.hypotheses_tried import identify_run

SQUARE, SLENDER = Block(0.06, 0.06, 0.1), Block(0.28, 0.07, 5.84)
SIGMA = math.radians(0.03)
HOUSNER = replace(BY_DEFAULT, laws=("housner",))


def measured(e, mu, seed, *, theta0_deg=25.0, rate0=0.0, rate_hz=1000.0, block=SQUARE, bounced=True):
    """A run with white noise; one that is thrown where it has a rate."""
    noise, theta0 = np.random.default_rng(seed), math.radians(theta0_deg)
    time = np.arange(0, 0.6, 1 / rate_hz)
    exact = simulate("bouncing", block, {"e": e, "mu": mu}, time, theta0=State(0.0, 0.0, theta0, rate0))
    held = {"theta0": theta0 + noise.normal(0, SIGMA / 5), "theta0_stderr": SIGMA / 5, "t0_stderr": 2e-4}
    if rate0:
        held = {"theta0": 1.01 * theta0, "theta0_stderr": 0.05 * theta0, "rate0": 1.05 * rate0}
    theta = exact.theta + noise.normal(0, SIGMA, time.size)
    rests = [noise.normal(0, SIGMA, 600)]
    return Motion(time, theta, SIGMA, bounced=bounced, rests=rests, **held)


@pytest.mark.parametrize("rate0", [0.0, -6.0])
@pytest.mark.parametrize(("e", "mu"), [(0.3, 0.15), (0.45, 0.4), (0.55, 0.25)])
def test_restitution_and_friction_are_found(e, mu, rate0):
    motion = measured(e, mu, 3, rate0=rate0)
    found = identify_run(SQUARE, motion, HOUSNER)
    choice = found.choice(HOUSNER.on(SQUARE, motion))
    assert (choice.selected, choice.explained) == ("bouncing", True)
    fit = found.fits["bouncing"]
    assert fit.parameters == ("e", "mu", "theta0", "omega0" if rate0 else "t0")
    for name, truth in {"e": e, "mu": mu}.items():
        i = fit.parameters.index(name)
        assert abs(fit.value[i] - truth) < 3 * math.hypot(fit.stderr[i], fit.discrepancy[i]) < 0.05
    assert ("housner" in found.fits) == (not rate0)  # a release from rest can't begin so


def test_friction_is_not_told_where_no_corner_slips():
    found = identify_run(SQUARE, measured(0.4, 3.0, 1), HOUSNER).fits["bouncing"]
    assert found.success and evidence(found).explains and "does not determine μ" in found.message
    at = found.parameters.index("mu")
    assert found.n_parameters == 3 and not np.isfinite(found.stderr[at])
    assert not np.isfinite([found.ci95_low[at], found.ci95_high[at]]).any()
    assert found.values["e"] == pytest.approx(0.4, abs=5 * found.stderr[0])


def test_restitution_is_not_told_by_one_sample_after_the_impact():
    """Its standard error would exceed what its bounds leave."""
    whole, noise = measured(0.4, 0.3, 6), np.random.default_rng(1)
    exact = simulate("bouncing", SQUARE, {"e": 0.4, "mu": 0.3}, whole.time_s, theta0=math.radians(25))
    n, sigma = int(np.searchsorted(whole.time_s, exact.impacts[0])) + 1, 20 * SIGMA
    theta, rests = whole.theta[:n] + noise.normal(0, sigma, n), [noise.normal(0, sigma, 600)]
    motion = replace(whole, time_s=whole.time_s[:n], theta=theta, sigma_theta=sigma, rests=rests)
    fit = fit_run("bouncing", SQUARE, motion)
    assert fit.success and "does not determine e" in fit.message and math.isnan(fit.stderr[0])
    assert 0 < fit.stderr[1] < 0.2  # of μ: the corner slips before
    longer = fit_run(
        "bouncing", SQUARE, replace(whole, time_s=whole.time_s[: n + 9], theta=whole.theta[: n + 9])
    )
    assert longer.message == "converged" and abs(longer.value[0] - 0.4) < 4 * longer.stderr[0] < 0.1


def test_friction_may_be_given():
    given = {"bouncing": {"mu": {"value": 0.4, "vary": False}}}
    fit = fit_run("bouncing", SQUARE, measured(0.4, 0.4, 2), FitSettings(parameters=given))
    assert fit.success and fit.values["mu"] == pytest.approx(0.4) and "determine" not in fit.message
    assert fit.values["e"] == pytest.approx(0.4, abs=4 * fit.stderr[0])


def test_intervals_hold_the_truth():
    """Those of total uncertainty: near a slip that begins, several minima are alike (`Fit.discrepancy`)."""
    draw, inside = np.random.default_rng(11), []
    for seed in range(16):
        e, mu = draw.uniform(0.2, 0.6), draw.uniform(0.1, 0.5)
        motion = measured(
            e, mu, seed, theta0_deg=draw.uniform(18, 33), rate0=-draw.uniform(4, 8) * (seed % 2)
        )
        fit = fit_run("bouncing", SQUARE, motion)
        u = np.hypot(fit.stderr, fit.discrepancy)[:2]
        known = np.isfinite(u) & evidence(fit).explains
        inside += (np.abs(fit.value[:2] - [e, mu]) < 2.6 * u)[known].tolist()
    assert len(inside) >= 24 and np.mean(inside) > 0.9


def test_what_neither_law_explains_is_unexplained():
    motion = measured(0.4, 0.3, 4)
    wrong = replace(motion, theta=motion.theta * (1 + 0.2 * np.sin(40 * motion.time_s)))
    choice = identify_run(SQUARE, wrong, HOUSNER).choice(HOUSNER.on(SQUARE, wrong))
    assert not choice.explained
    assert {each.evidence.model: each.status for each in choice.judged}["bouncing"] != "not_fitted"


def test_a_run_that_did_not_bounce_costs_nothing():
    motion = measured(0.0, 5.0, 5, theta0_deg=8, block=SLENDER, bounced=False)
    assert BY_DEFAULT.on(SLENDER, motion) is BY_DEFAULT
    assert "bouncing" not in BY_DEFAULT.candidates


@pytest.mark.parametrize(
    ("block", "bounced", "rate0", "rivals", "models"),
    [
        (SLENDER, True, 0.0, True, ("housner", "bouncing")),
        (SQUARE, False, 0.0, True, ("housner", "bouncing")),
        (SQUARE, True, -5.0, True, ("bouncing",)),
        (SQUARE, False, -5.0, True, ()),
        (SQUARE, True, 0.0, False, ()),
        (SQUARE, False, 0.0, False, ("housner",)),
    ],
)
def test_on_which_runs_it_is_tried(block, bounced, rate0, rivals, models):
    motion = replace(measured(0.3, 0.3, 0), bounced=bounced, rate0=rate0)
    hypotheses = HOUSNER if rivals else replace(HOUSNER, kinematics=())
    assert tuple(hypotheses.on(block, motion).laws) == models


def test_a_campaign_may_list_it():
    listed = Hypotheses(("housner", "bouncing"), ("pivoting",), {"housner": LAWS["housner"].free})
    assert listed.always_fitted == ("housner",) and "bouncing" in listed.candidates
    alone = replace(listed, laws=("bouncing",))
    assert alone.always_fitted == ("bouncing",) and alone.n_freed("bouncing") == 4


def test_a_thrown_run_brings_its_rate():
    time = np.arange(0, 0.5, 0.004)
    theta = simulate("bouncing", SQUARE, {"e": 0.4, "mu": 0.3}, time, theta0=State(0.0, 0.0, 0.6, -7.0)).theta
    reasons = tuple(Reason("warn", name, "") for name in ("thrown", "bounced"))
    run = Run(1, 0.0, 0.0, 0.02, 0.0, 0.4, 0.6, 1e-3, SIGMA, 0, Verdict(reasons))
    motion = motion_of(run, time, theta)
    assert motion.rate0 == pytest.approx(-7.0, rel=0.05) and motion.bounced
    plain = motion_of(replace(run, verdict=Verdict()), time, theta)
    assert plain.rate0 == 0 and not plain.bounced
