"""Swings between impacts, against Housner's block in closed form."""

import numpy as np
import pandas as pd
import pytest

from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.tables.swings import rigid_period_s, swings

BLOCK = Block(0.28, 0.07, 5.84)
R = 0.93


@pytest.fixture(scope="module")
def rocking():
    return housner_swings(BLOCK, R, np.radians(9.0), max_impacts=12)


def tables(rocking, source="experiment"):
    """Tidy tables of a run of Housner's block."""
    n = 12
    scene = {"campaign": "c", "test": "a", "run": 1, "block": "b", "foundation": "f"}
    restitution = pd.DataFrame(
        {
            **scene,
            "source": source,
            "impact": np.arange(1, n + 1),
            "time_s": rocking.impact_time[:n],
            "r": R,
            "r_u": 0.001,
            "peak_before_deg": np.degrees(rocking.peak[:n]),
        }
    )
    runs = pd.DataFrame([{**scene, "verdict": "ok", "excluded": False}])
    epsilon = pd.DataFrame([{**scene, "model": "housner", "success": False}])
    return runs, restitution, epsilon, {"b": BLOCK}


def test_amplitude_and_period_are_housners(rocking):
    found = swings(*tables(rocking))
    np.testing.assert_allclose(found["amplitude"], rocking.peak[:12] / BLOCK.theta_cr, rtol=1e-9)
    assert np.isnan(found["period_s"].iloc[0])
    quarter = [housner_swings(BLOCK, 1.0, each, max_impacts=1).impact_time[0] for each in rocking.peak[1:12]]
    np.testing.assert_allclose(found["period_s"][1:], 4 * np.array(quarter), rtol=1e-9)


def test_an_impact_that_was_not_seen_makes_no_period(rocking):
    runs, restitution, epsilon, blocks = tables(rocking)
    found = swings(runs, restitution.drop(index=5), epsilon, blocks)
    assert found["period_s"].isna().tolist() == [True, *[False] * 4, True, *[False] * 5]


def test_the_period_without_losses_is_twice_the_time_between_two_impacts():
    shares = np.array([0.002, 0.3, 0.99])
    known = [housner_swings(BLOCK, 1.0, each * BLOCK.theta_cr, max_impacts=2).impact_time for each in shares]
    np.testing.assert_allclose(rigid_period_s(BLOCK, shares), [2 * (b - a) for a, b in known], rtol=1e-9)
