"""The study of drawn inputs: its records against SciPy, what is counted, and that the truth is named."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from freerock.models.block import GRAVITY
from freerock_bench import drawn, integrated
from freerock_bench.integrated_kernel import rates, turns

TILT = math.radians(0.2)


@pytest.mark.parametrize("i", [2, 7, 16])
@pytest.mark.parametrize("tilt", [0.0, TILT])
def test_the_path_is_that_of_scipy(i, tilt):
    scene = replace(integrated.scene_of(i), tilt=tilt)
    truth = integrated.recorded(scene, integrated.laser_of(i), 1000.0)
    first = math.ceil(scene.fade_s / truth.step_s)
    given = (*scene.body, scene.b, *scene.law, scene.pivoting, scene.tilt)
    times = np.arange(first, first + 24_000, 40) * truth.step_s
    until = (times[0], times[-1])
    exact = solve_ivp(
        lambda t, y: rates(y, 0.0, *given),
        until,
        truth.path[:, first],
        "DOP853",
        times,
        rtol=1e-10,
        atol=1e-12,
        max_step=2e-3,
    )
    assert np.allclose(truth.path[1, first : first + 24_000 : 40], exact.y[1], rtol=0, atol=3e-7)


def test_a_tilted_base_adds_the_work_of_the_weight_along_it():
    """Energy with the weight turned by the tilt is kept where the bed takes none."""
    scene = replace(integrated.scene_of(7), tilt=TILT)
    scene = replace(scene, law=(scene.law[0], 0.0, 0.0))
    path = integrated.recorded(scene, integrated.laser_of(7), 1000.0).path[:, 2000:20_000]
    z, theta = path[:2]
    m, _, h = scene.body
    level = np.array([integrated._energy(state, replace(scene, tilt=0.0)) for state in path[:, ::100].T])
    sideways = h * np.sin(theta) + scene.b * np.sign(theta) * (1 - np.cos(theta))
    sunk = (m * GRAVITY * (math.cos(TILT) - 1) * (h * np.cos(theta) - z))[::100]
    whole = level + sunk - (m * GRAVITY * math.sin(TILT) * sideways)[::100]
    assert np.ptp(whole) < 1e-7 < 1e-3 * np.ptp(m * GRAVITY * math.sin(TILT) * sideways)


def test_a_rigid_block_balances_where_its_mass_is_above_its_corner():
    b, h = 0.035, 0.14
    for side in (1.0, -1.0):
        upright = side * math.atan2(b, h) - TILT
        assert turns(upright, side, 5.0, 0.03, h, b, TILT) == pytest.approx(0.0, abs=1e-12)


def test_a_rigid_block_loses_at_each_impact_what_its_restitution_says():
    scene = replace(integrated.scene_of(1), r=0.93, b=0.034, tilt=0.0)
    truth = integrated.recorded(scene, integrated.laser_of(1), 1000.0)
    h = scene.body[2]
    tops = truth.path[1][[0, *truth._tops]]
    lifted = h * np.cos(tops) + scene.b * np.abs(np.sin(tops)) - h
    assert np.sqrt(lifted[2:8] / lifted[1:7]) == pytest.approx(0.93, abs=1e-5)


def test_the_truth_is_named_with_inputs_off_by_their_uncertainty():
    """Of the squat block, each law, with calliper and rule."""
    cases = [
        ("drawn", "rule", "guided", 5),
        ("drawn", "caliper", "pivoting", 8),
        ("drawn", "rule", "guided", 17),
    ]
    rows = pd.DataFrame([row for case in cases for row in drawn.rows_of(case)], columns=drawn.COLUMNS)
    assert rows["held"].all() and rows["explained"].all()
    z = rows[["k_z", "c_z", "lambda_z", "r_z"]].astype(float).to_numpy()
    assert np.nanmax(np.abs(z)) < 3.5 and np.isfinite(z).sum() == 5
    pulls = drawn.pulls_of(rows)
    assert len(pulls) >= 6 and 0.2 < np.std(pulls) < 2.5


def made_up(**differs):
    row = {"part": "drawn", "instruments": "rule", "kinematics": "guided", "level": "ok", "explained": True}
    row |= {"named": True, "held": True, "cause": False, "k_z": 1.0, "pull_width_m": 0.5}
    return row | differs


def test_what_is_counted():
    excluded = {"named": False, "held": False, "k_z": 5.0}
    rows = [
        made_up(),
        made_up(named=False),
        made_up(**excluded),
        made_up(**excluded, level="warn"),
        made_up(**excluded, explained=False),
        made_up(part="worn", cause=True),
    ]
    frame = pd.DataFrame(rows, columns=drawn.COLUMNS)
    table = drawn.markdown(frame).strip().splitlines()
    assert (
        table[2]
        == "| drawn | rule | guided | 5 | 20 % | 20 % | 20 % | 20 % | 20 % |  | 2 of 5 |  |  | 3.92 |"
    )
    assert table[3].startswith(
        "| worn | rule | guided | 1 | 100 % | 0 % | 0 % | 0 % | 0 % | 100 % | 1 of 1 |"
    )
    assert table[-1] == "| all | 5 | +0.50 | 0.00 | 0.0 % | 0.0 % |"
    shares = drawn.told(frame)[list(drawn.OUTCOMES)].sum(axis=1)
    assert shares.to_numpy() == pytest.approx(1.0)
    assert len(shares) == 2


def test_every_part_has_records_of_every_scene():
    cases = drawn.cases(drawn.SIZES["full"])
    assert {case[0] for case in cases} == {*drawn.PARTS}
    for part in drawn.PARTS:
        own = [case for case in cases if case[0] == part]
        assert len({case[3] % 18 for case in own}) == 18
    assert len(drawn.cases(drawn.SIZES["small"])) == 28


@pytest.mark.slow
@pytest.mark.parametrize("case", [("tilted", "rule", "pivoting", 7), ("worn", "rule", "guided", 1)])
def test_other_kinematics_with_inputs_moved_do_not_hide_the_truth(case):
    """There the truth without its tilt or width leaves hundreds of times what other kinematics leave."""
    (row,) = drawn.rows_of(case)
    assert row["named"] and row["explained"] and row["cause"]
