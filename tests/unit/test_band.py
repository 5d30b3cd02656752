"""The next run as a band: what scatters widens it, and it holds the peaks as often as it says."""

import numpy as np
import pytest

from freerock.columns import columns_of
from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.models.simulate import simulate_fitted
from freerock.populations.band import bands, peaks_of
from freerock.populations.estimate import Estimate
from freerock.rotation.laboratory import Input
from freerock.runs.motion import Motion

pytestmark = pytest.mark.slow

BLOCK, TIME = Block(0.28, 0.07, 5.84), np.arange(0, 2.5, 4e-3)


def record(restitutions, stderr=1e-4):
    """Estimates, motions and measured peaks [°] of the runs of a rigid block."""
    estimates, motions, peaks = [], {}, {}
    for run, r in enumerate(restitutions, 1):
        theta = simulate_fitted("housner", BLOCK, {"r": r, "theta0": 0.17}, TIME)
        names = "made_up", "a_marble", run, "a", "marble", "housner"
        estimates.append(Estimate(*names, {"r": r, "theta0": 0.17}, np.array([[stderr**2]])))
        motions[run] = Motion(TIME, theta, sigma_theta=1e-5, theta0=0.17)
        swings = housner_swings(BLOCK, r, 0.17, max_impacts=7)
        peaks["a_marble", run] = np.degrees(swings.peak[1:6]), swings.impact_time[:5]
    return bands(estimates, lambda test: motions, {"a": BLOCK}, peaks)


def test_peaks_are_those_of_the_closed_form():
    theta = simulate_fitted("housner", BLOCK, {"r": 0.9, "theta0": 0.17}, TIME)
    peaks, times = peaks_of(TIME, theta)
    exact = housner_swings(BLOCK, 0.9, 0.17, max_impacts=6)
    np.testing.assert_allclose(np.radians(peaks[:5]), exact.peak[1:6], rtol=2e-4)
    np.testing.assert_allclose(times[:5], exact.impact_time[:5], atol=1e-4)


def test_equal_runs_predict_each_other_in_a_narrow_band():
    table = record([0.9, 0.9, 0.9])
    assert list(table) == columns_of("predictions") and table["inside"].all()
    assert ((table["impact_high_s"] - table["impact_low_s"]) < 0.01).all()
    np.testing.assert_allclose(table["impact_median_s"], table["impact_s"], atol=1e-3)
    assert ((table["high_deg"] - table["low_deg"]) < 0.02 * table["peak_deg"]).all()
    np.testing.assert_allclose(table["median_deg"], table["peak_deg"], rtol=5e-3)


def test_a_run_of_which_nothing_is_known_has_a_wide_band():
    with np.errstate(over="raise"):
        table = record([0.9, 0.9, 0.9], stderr=1e3)
    assert table["inside"][table["peak"] == 1].all()


def test_runs_that_differ_widen_the_band_and_a_stranger_lies_outside():
    r = 0.9 + 0.004 * np.random.default_rng(2).standard_normal(12)
    table = record(r)
    assert table["inside"].mean() > 0.85 and table["impact_inside"][table["peak"] > 1].mean() > 0.85
    assert ((table["high_deg"] - table["low_deg"]) > 0.01 * table["peak_deg"]).all()
    odd = record([0.9, 0.901, 0.899, 0.9005, 0.8])
    assert not odd[odd["run"] == 5]["inside"].any()
    late = odd[(odd["run"] == 5) & (odd["peak"] > 1)]
    assert not late["impact_inside"].any()


def test_the_band_is_read_with_the_inputs_that_the_fit_moved():
    """A scale that is 1 % off, of a run whose peaks are 1 % lower as stated."""
    scale = Input("laser", "scale_fraction", 0.01, True)
    swings = housner_swings(BLOCK, 0.9, 0.17, max_impacts=7)
    for by, inside in ((0.0, False), (1.0, True)):
        estimates, motions, peaks = [], {}, {}
        for run in (1, 2):
            names = "made_up", "a_marble", run, "a", "marble", "housner"
            values = {"r": 0.9, "theta0": 0.17 / 1.01}
            moved = {scale: by} if by else {}
            estimates.append(Estimate(*names, values, np.array([[1e-8]]), moved=moved))
            motions[run] = Motion(TIME, np.zeros(TIME.size), sigma_theta=1e-5, theta0=0.17 / 1.01)
            peaks["a_marble", run] = np.degrees(swings.peak[1:6]) / 1.01, swings.impact_time[:5]
        table = bands(estimates, lambda test, own=motions: own, {"a": BLOCK}, peaks)
        assert table["impact_inside"][table["peak"] > 1].all() == inside


def test_a_run_alone_is_not_predicted():
    assert record([0.9]).empty


def test_the_same_band_twice():
    one, other = record([0.9, 0.91]), record([0.9, 0.91])
    assert one.equals(other) and one["n_runs"].tolist() == [1] * len(one)
    assert (
        one["high_deg"].iloc[0]
        > one["median_deg"].iloc[0]
        > one["low_deg"].iloc[0]
        == pytest.approx(one["low_deg"].iloc[0])
    )


CRITICAL, P = BLOCK.theta_cr, BLOCK.p
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def quarter_s(peak):
    """From rest at a peak to θ = 0: ∫ dφ/θ̇ with φ = θ_cr - θ_n + θ_n s² [s]."""
    s, top = (NODES + 1) / 2, (CRITICAL - peak)[:, None]
    rate = P * np.sqrt(2 * (np.cos(top) - np.cos(top + peak[:, None] * s**2)))
    return (2 * peak[:, None] * s / rate) @ WEIGHTS / 2


def rocked(r, delta, theta0=0.17):
    """Peaks [°] and instants [s] of a rigid block, whose energy falls by (r (1 + δ_i))² at impact i."""
    fallen = np.cumprod((r * (1 + delta)) ** 2)
    top = np.arccos(np.cos(CRITICAL) + fallen * (np.cos(CRITICAL - theta0) - np.cos(CRITICAL)))
    quarters = quarter_s(np.append(theta0, CRITICAL - top))
    return np.degrees(CRITICAL - top), np.cumsum(np.append(quarters[0], 2 * quarters[1:-1]))


@pytest.mark.parametrize(("claimed", "held"), [(0.02, (0.9, 1.0)), (0.0, (0.0, 0.5))])
def test_the_band_holds_runs_of_another_program_whose_impacts_scatter(claimed, held):
    """Runs of r = 0.92 and σ_r = 2 %; a band that knows of no scatter does not hold them."""
    draw, sigma_r, n, inside = np.random.default_rng(3), 0.02, 12, []
    for _ in range(6):
        estimates, motions, swings = [], {}, {}
        for run in (1, 2, 3):
            delta = sigma_r * draw.standard_normal(n)
            r = 0.92 * np.exp(np.log1p(delta).mean()) if claimed else 0.92  # as a fit finds it
            names = "made_up", "a_marble", run, "a", "marble", "housner"
            error = np.array([[(r * sigma_r) ** 2 / n if claimed else 1e-12]])
            estimates.append(Estimate(*names, {"r": r, "theta0": 0.17}, error, sigma_r=claimed))
            motions[run] = Motion(TIME, np.zeros(TIME.size), sigma_theta=1e-5, theta0=0.17)
            peaks, times = rocked(0.92, delta)
            swings["a_marble", run] = peaks[:7], times[:7]
        table = bands(estimates, lambda test, own=motions: own, {"a": BLOCK}, swings)
        inside += [table["inside"], table["impact_inside"][table["peak"] > 1]]
    assert held[0] <= np.mean(np.concatenate(inside)) <= held[1]
