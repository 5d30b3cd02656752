"""The next run as a band: what scatters widens it, and it holds the peaks as often as it says."""

import numpy as np
import pytest

from freerock.columns import columns_of
from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.models.simulate import simulate_theta
from freerock.populations.band import bands, swings_of
from freerock.populations.estimate import Estimate
from freerock.runs.motion import Motion

BLOCK, TIME = Block(0.28, 0.07, 5.84), np.arange(0, 2.5, 4e-3)


def record(restitutions, stderr=1e-4):
    """Estimates, motions and measured peaks [°] of the runs of a rigid block."""
    estimates, motions, peaks = [], {}, {}
    for run, r in enumerate(restitutions, 1):
        theta, _ = simulate_theta("housner", BLOCK, {"r": r}, TIME, theta0=0.17)
        names = "made_up", "a_marble", run, "a", "marble", "housner"
        estimates.append(Estimate(*names, {"r": r, "theta0": 0.17}, np.array([[stderr**2]])))
        motions[run] = Motion(TIME, theta, sigma_theta=1e-5, theta0=0.17)
        swings = housner_swings(BLOCK, r, 0.17, max_impacts=7)
        peaks["a_marble", run] = np.degrees(swings.peak[1:6]), swings.impact_time[:5]
    return bands(estimates, lambda test: motions, {"a": BLOCK}, peaks)


def test_peaks_are_those_of_the_closed_form():
    theta, _ = simulate_theta("housner", BLOCK, {"r": 0.9}, TIME, theta0=0.17)
    peaks, times = swings_of(TIME, theta)
    exact = housner_swings(BLOCK, 0.9, 0.17, max_impacts=6)
    np.testing.assert_allclose(np.radians(peaks[:5]), exact.peak[1:6], rtol=2e-4)
    np.testing.assert_allclose(times[:5], exact.impact_time[:5], atol=1e-4)


def test_equal_runs_foretell_each_other_in_a_narrow_band():
    table = record([0.9, 0.9, 0.9])
    assert list(table) == columns_of("bands") and table["inside"].all()
    assert ((table["impact_high_s"] - table["impact_low_s"]) < 0.01).all()
    np.testing.assert_allclose(table["impact_median_s"], table["impact_s"], atol=1e-3)
    assert ((table["high_deg"] - table["low_deg"]) < 0.02 * table["peak_deg"]).all()
    np.testing.assert_allclose(table["median_deg"], table["peak_deg"], rtol=5e-3)


def test_runs_that_differ_widen_the_band_and_a_stranger_lies_outside():
    r = 0.9 + 0.004 * np.random.default_rng(2).standard_normal(12)
    table = record(r)
    assert table["inside"].mean() > 0.85 and table["impact_inside"][table["peak"] > 1].mean() > 0.85
    assert ((table["high_deg"] - table["low_deg"]) > 0.01 * table["peak_deg"]).all()
    odd = record([0.9, 0.901, 0.899, 0.9005, 0.8])
    assert not odd[odd["run"] == 5]["inside"].any()
    late = odd[(odd["run"] == 5) & (odd["peak"] > 1)]
    assert not late["impact_inside"].any()


def test_a_run_alone_is_not_foretold():
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
