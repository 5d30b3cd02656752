"""Restitution of each impact from true mechanical energies."""

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import fabricated
import numpy as np
import pytest
from plain_law import accelerations
from scipy.integrate import solve_ivp

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import ImpactEnergy, fit_record
from freerock.jobs import make_fits
from freerock.models.contact import Foundation, State, energy, static_depth
from freerock.models.published import TABLE_2
from freerock.populations.impact_energy import impact_energy, of_measured
from freerock.products.runs import runs_in
from freerock.runs.impacts import find_impacts
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.virtual_run import Truth, virtual_motion

BLOCK, THETA0, _ = CONFIGURATIONS["config2"]
SIGMA = math.radians(0.01)
RATE_HZ = 2000.0


def by_another_engine(law, span_s=1.2, air_nms2=0.0):
    """θ(t), its impacts and the energies at its tops, by SciPy's DOP853 with the plain law of forces.

    Air, where there is some, is a moment against turning by the square of the rate.
    """
    return _by_another_engine(tuple(law.items()), span_s, air_nms2)


@cache
def _by_another_engine(law, span_s, air_nms2):
    foundation = Foundation.of(dict(law))

    def rates(_, state):
        drag = -air_nms2 * state[3] * abs(state[3])
        z_acceleration, acceleration = accelerations(BLOCK, foundation, State(*state), hand=drag)
        return [state[1], z_acceleration, state[3], acceleration]

    def passes(_, state):
        return state[2]

    def turns(_, state):
        return state[3]

    start = [static_depth(BLOCK, foundation, THETA0), 0.0, THETA0, 0.0]
    time_s = np.arange(0, span_s, 1 / RATE_HZ)
    options = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-12, "t_eval": time_s, "max_step": 2e-3}
    found = solve_ivp(rates, (0.0, span_s), start, events=(passes, turns), **options)
    impacts, states = found.t_events[0], found.y_events[1]
    instants = found.t_events[1]
    tops = [energy(BLOCK, foundation, *start)]
    for first, last in pairwise(impacts):
        (i,) = np.flatnonzero((instants > first) & (instants < last))
        tops.append(energy(BLOCK, foundation, *states[i]))
    return time_s, found.y[2], impacts, np.sqrt(np.array(tops[1:]) / tops[:-1])


@pytest.mark.parametrize("foundation", TABLE_2)
def test_a_motion_of_another_engine(foundation):
    """Its own energies within three standard errors, where a rigid block's are more than twenty off."""
    law = TABLE_2[foundation]["hunt_crossley"]
    time_s, theta, impacts, exact = by_another_engine(law)
    noise = SIGMA * np.random.default_rng(2).standard_normal(len(theta))
    run = Motion(time_s, theta + noise, SIGMA, THETA0, SIGMA / 30, 2e-4)
    fit = fit_record("hunt_crossley", BLOCK, [run], start=list(law.values()))
    found = impact_energy(fit, BLOCK, impacts[: len(exact)])
    assert found.time_s == pytest.approx(impacts[: len(exact)], abs=2e-4)
    assert np.all(np.abs(found.restitution - exact) < 3 * found.stderr + 1e-6)
    rigid = find_impacts(time_s, theta, 0.0, BLOCK, theta0=THETA0).restitution[: len(exact)]
    assert np.all(rigid > found.restitution + 20 * found.stderr)


def test_no_bias_and_honest_errors_over_runs():
    block, theta0, _ = CONFIGURATIONS["config3"]
    truth = Truth("winkler", block, TABLE_2["marble"]["winkler"], theta0, SIGMA)
    scores = []
    for seed in range(30):
        run = virtual_motion(truth, np.random.default_rng(seed), still_s=(1.5, 1.5))
        fit = fit_record("winkler", block, [run], start=list(truth.parameters.values()))
        first = find_impacts(fit.time, fit.theta_model, 0.0, block, theta0=fit.values["theta0"]).time_s[:2]
        found = impact_energy(fit, block, first)
        values = np.array([*truth.parameters.values(), theta0, 0.0])
        exact = impact_energy(replace(fit, value=values), block, first)
        scores.append((found.restitution - exact.restitution) / found.stderr)
    assert abs(np.mean(scores)) < 4 / math.sqrt(30)
    assert 0.75 < np.sqrt(np.mean(np.square(scores))) < 1.3


def test_a_rigid_block_has_its_energies_from_its_heights():
    run = virtual_motion(Truth("housner", BLOCK, {"r": 0.95}, THETA0, SIGMA), np.random.default_rng(1))
    fit = fit_record("housner", BLOCK, [run], start=[0.95])
    with pytest.raises(ValueError, match="by energy is that from its peaks"):
        impact_energy(fit, BLOCK, [0.3])


def test_measured_impacts_have_the_energies_of_the_nearest_of_the_law():
    """An impact that the law lacks has none, nor has one that is not the nearest to that of the law."""
    known = np.array([0.9, 0.8, 0.7])
    law = ImpactEnergy(np.array([0.3, 0.7, 1.0]), known + 1, known, known / 10, known / 5)
    found = of_measured(law, np.array([0.301, 0.69, 0.99, 1.4]))
    np.testing.assert_array_equal(found.restitution, [0.9, 0.8, 0.7, np.nan])
    np.testing.assert_array_equal(found.u_total, [*(known / 5), np.nan])
    assert np.isnan(of_measured(law, np.array([0.3, 0.45])).restitution[1])


@pytest.mark.parametrize(("model", "energies"), [("housner", None), ("hunt_crossley", "found")])
def test_fits_of_a_foundations_law_alone_have_energies(model, energies, monkeypatch):
    monkeypatch.setattr(make_fits, "impact_energy", lambda *_, **__: "found")
    tree = fabricated.record(n_runs=1)
    fit = fabricated.fit(tree, model, runs_in(tree)[0], ())
    hypotheses = SimpleNamespace(settings=lambda model: FitSettings())
    found = make_fits._with_energies(fit, BLOCK, SimpleNamespace(view=None), None, hypotheses)
    assert found.energies == energies
