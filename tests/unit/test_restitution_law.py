"""A line of restitution over impact speed, and whether there is one."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import linregress, t

from freerock.tables.columns import RESTITUTION_LAW_COLUMNS
from freerock.tables.restitution_law import ENERGY, PEAKS, line_of, restitution_law

SPEED = np.linspace(0.05, 0.4, 15)


def run_of(slope, scatter, seed, r=0.95):
    return np.array([SPEED, r + slope * SPEED + scatter * np.random.default_rng(seed).standard_normal(15)])


def test_one_run_has_the_line_and_the_interval_of_a_regression():
    speed, value = run_of(-0.1, 0.002, 1)
    known = linregress(speed, value)
    line = line_of([np.array([speed, value])], 0.2)
    assert line.slope == pytest.approx(known.slope) and line.slope_stderr == pytest.approx(known.stderr)
    half = t.ppf(0.975, 13) * known.stderr
    assert (line.low, line.high) == pytest.approx((known.slope - half, known.slope + half))
    assert line.r == pytest.approx(known.intercept + 0.2 * known.slope)


@pytest.mark.parametrize("n_runs", [1, 3])
def test_a_constant_restitution_shows_a_trend_no_more_often_than_chance(n_runs):
    seen = []
    for k in range(600):
        line = line_of([run_of(0.0, 0.003, 10 * k + i) for i in range(n_runs)], 0.2)
        seen.append(not line.low <= 0 <= line.high)
    assert 0.025 < np.mean(seen) < 0.075


def test_runs_that_differ_widen_the_interval_of_their_mean():
    alike = line_of([run_of(-0.1, 0.001, i) for i in range(3)], 0.2)
    other = line_of([run_of(slope, 0.001, i) for i, slope in enumerate((-0.05, -0.1, -0.15))], 0.2)
    assert other.high - other.low > 5 * (alike.high - alike.low)
    assert other.slope == pytest.approx(-0.1, abs=0.01)


def tables():
    rows, scene = [], {"campaign": "c", "test": "a", "block": "b", "foundation": "f"}
    for number in (1, 2):
        speed, value = run_of(-0.1, 0.001, number)
        for v, r in zip(speed, value, strict=True):
            common = {**scene, "run": number, "rigid_speed_m_s": v, "r": r}
            rows.append({**common, "source": "experiment"})
            of_law = {"r_energy": 0.9 - 0.2 * v, "impact_speed_m_s": v}
            rows.append({**common, "source": "hunt_crossley", **of_law})
            rows.append({**common, "source": "winkler", "r_energy": 0.5, "impact_speed_m_s": v})
    laws = [("hunt_crossley", True, 0.01), ("winkler", False, 0.02)]
    epsilon = [
        {**scene, "run": number, "model": model, "selected": chosen, "epsilon_theta": left, "success": True}
        for number in (1, 2)
        for model, chosen, left in laws
    ]
    return pd.DataFrame(rows), pd.DataFrame(epsilon)


def test_both_restitutions_have_a_row_and_only_the_law_that_is_named_counts():
    found = restitution_law(*tables())
    assert list(found.columns) == RESTITUTION_LAW_COLUMNS
    peaks, energy = found.set_index("quantity").loc[PEAKS], found.set_index("quantity").loc[ENERGY]
    assert peaks["slope_s_m"] == pytest.approx(-0.1, abs=0.01) and peaks["trend"]
    assert energy["slope_s_m"] == pytest.approx(-0.2) and energy["trend"]
    assert energy["r"] == pytest.approx(0.9 - 0.2 * energy["speed_m_s"])
    assert (found["n_runs"] == 2).all() and (found["n_impacts"] == 30).all()
    assert (peaks["speed_low_m_s"], peaks["speed_high_m_s"]) == (0.05, 0.4)


def test_few_impacts_have_no_line_and_a_table_without_impacts_no_row():
    swings, epsilon = tables()
    few = swings[swings.groupby(["run", "source"]).cumcount() < 3]
    assert restitution_law(few, epsilon).empty
    assert list(restitution_law(swings[:0], epsilon).columns) == RESTITUTION_LAW_COLUMNS


def test_impacts_at_one_speed_have_no_line():
    """Of two runs one has all its impacts at one speed: the line is that of the other."""
    swings, epsilon = tables()
    alike = swings.assign(rigid_speed_m_s=swings["rigid_speed_m_s"].where(swings["run"] == 1, 0.2))
    found = restitution_law(alike, epsilon).set_index("quantity").loc[PEAKS]
    alone = restitution_law(swings[swings["run"] == 1], epsilon).set_index("quantity").loc[PEAKS]
    assert (found["n_runs"], found["slope_s_m"]) == (1, alone["slope_s_m"])
