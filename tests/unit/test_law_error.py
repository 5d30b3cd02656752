"""Uncertainty of restitution by energy where no law is true: swings that have another zero than the rest."""

from dataclasses import replace
from functools import cache

import numpy as np
from test_impact_energy import BLOCK, LAW, THETA0, TIME, N, measured, true_restitutions

from freerock.identification.fit import fit_record
from freerock.models.simulate import Solver, simulate
from freerock.populations.impact_energy import impact_energy, with_law_error
from freerock.runs.impacts import find_impacts

LEAN, LIFTED = 6e-4, 0.01  # zero of a swing, and the rotation from which the block has lifted off [rad]


@cache
def fitted(lean, seed=3):
    """Fits of three runs, their impacts as seen, and the true motions."""
    draw, motions, truth = np.random.default_rng(seed), {}, {}
    for run in (1, 2, 3):
        law = {**LAW, "impacts": 0.01 * draw.standard_normal(30)[:N]}
        true = simulate("hunt_crossley", BLOCK, law, TIME, theta0=THETA0, solver=Solver(1e-9))
        shown = true.theta + lean * (1 - np.exp(-((true.theta / LIFTED) ** 2)))
        motions[run], truth[run] = measured(shown, draw), true
    fits = fit_record("hunt_crossley", BLOCK, motions)
    seen = {
        run: find_impacts(each.time_s, each.theta, each.sigma_theta, BLOCK, theta0=each.theta0)
        for run, each in motions.items()
    }
    curves = {run: fit.curve for run, fit in fits.items()}
    fits = {
        run: replace(
            fit, impacts=find_impacts(curves[run].time, curves[run].theta_model, 0.0, BLOCK, theta0=THETA0)
        )
        for run, fit in fits.items()
    }
    return fits, seen, truth


def found_of(lean):
    """(r - truth)/u without and with the error of the law, and both r."""
    fits, seen, truth = fitted(lean)
    plain = {run: impact_energy(fit, BLOCK, fit.impacts.time_s[:N]) for run, fit in fits.items()}
    whole = with_law_error(plain, fits, seen, BLOCK)
    true_r = {run: true_restitutions(each) for run, each in truth.items()}
    off = [
        np.concatenate([(e[r].restitution - true_r[r][: len(e[r].restitution)]) / e[r].u_total for r in e])
        for e in (plain, whole)
    ]
    return off[0], off[1], plain, whole


def test_a_zero_that_swings_do_not_have_widens_u():
    plain, whole, *_ = found_of(LEAN)
    assert np.mean(np.abs(plain) < 1.96) < 0.7
    assert np.mean(np.abs(whole) < 1.96) >= 0.85


def test_a_law_that_agrees_keeps_its_u():
    *_, plain, whole = found_of(0.0)
    for run, each in plain.items():
        np.testing.assert_array_equal(whole[run].u_total, each.u_total)


def test_a_zero_that_scatter_takes_up_widens_u_where_chance_does_not_explain_it():
    """As of a base that slips: the law agrees, each run has a zero of its own."""
    fits, seen, _ = fitted(0.0)
    shifted, zeros = {}, {1: 4e-3, 2: -4e-3, 3: 0.0}
    for run, fit in fits.items():
        per_zero = np.sign(fit.impacts.peak_after_rad) / np.abs(fit.impacts.peak_after_rad)
        n = min(fit.scatter.delta.size, per_zero.size)
        delta = fit.scatter.delta[:n] + zeros[run] * per_zero[:n]
        covariance = fit.scatter.covariance[:n, :n]
        scatter = replace(fit.scatter, delta=delta, u_delta=fit.scatter.u_delta[:n], covariance=covariance)
        assert fit.evidence.agrees
        shifted[run] = replace(fit, scatter=scatter)
    plain = {run: impact_energy(fit, BLOCK, fit.impacts.time_s[:N]) for run, fit in fits.items()}
    whole = with_law_error(plain, shifted, seen, BLOCK)
    for run, zero in zeros.items():
        tops = np.abs(fits[run].impacts.peak_after_rad[:N])
        grown = np.sqrt(whole[run].u_total ** 2 - plain[run].u_total ** 2)[1:] / plain[run].restitution[1:]
        np.testing.assert_allclose(grown, abs(zero) * (1 / tops[:-1] + 1 / tops[1:]) / 2, rtol=0.6)


def test_a_run_without_free_impacts_has_the_usual_zero_of_wrong_ones():
    fits, seen, _ = fitted(LEAN)
    none = {"delta": np.zeros(0), "u_delta": np.zeros(0), "covariance": np.zeros((0, 0))}
    fits = {run: replace(fit, evidence=replace(fit.evidence, agrees=False)) for run, fit in fits.items()}
    plain = {run: impact_energy(fit, BLOCK, fit.impacts.time_s[:N]) for run, fit in fits.items()}
    fits[3] = replace(fits[3], scatter=replace(fits[3].scatter, **none))
    whole = with_law_error(plain, fits, seen, BLOCK)
    for run, each in plain.items():
        assert (whole[run].u_total[:-1] > each.u_total[:-1]).all()
