"""Numbers that a reader takes from tables and figures, against what is worked out here by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.stats import t as student

from freerock.figures import backbone
from freerock.identification.intervals import _student_95
from freerock.models.block import GRAVITY, Block
from freerock.populations.means import over_runs
from freerock.records.timebase import Grid, on_grid
from freerock.rotation.laboratory import Input
from freerock.rotation.reading import Reading
from freerock.rotation.sensor import Laser
from freerock.rotation.two_lasers import rotation_of_two
from freerock.rotation.u_total import OF_LAW, Contributions
from freerock.runs.verdict import Reason, Verdict
from freerock.selection import reasons_after_fits
from freerock.tables.populations import budget_table, populations_table

BLOCK = Block(0.28, 0.07, 5.84)
INPUTS = [("width_m", "b", 1e-4, "m", 1), ("scale_fraction", "laser", 1e-3, "1", 0)]


def test_total_uncertainty_is_that_of_noise_law_and_each_input():
    inputs = tuple(Input(owner, name, u, bool(stated)) for name, owner, u, _, stated in INPUTS)
    known = Contributions.held(inputs, np.array([[12.0, 84.0]]))
    assert known.total(np.array([3.0]), np.array([4.0])) == pytest.approx([math.sqrt(7225)])


def one_run(stderr, shifts):
    """Tables of one run whose k is 2e6, with the shifts of its logarithm by each input and by the law."""
    scene = {"campaign": "lab", "test": "a", "run": 1, "block": "b", "foundation": "mat"}
    scene |= {"model": "hunt_crossley", "parameter": "k", "value": 2e6}
    parameters = pd.DataFrame([scene | {"stderr": 2e6 * stderr, "unit": "N m-2", "success": True}])
    sources = [*INPUTS, (OF_LAW, "hunt_crossley", math.nan, "", pd.NA)]
    names = ["input", "input_owner", "input_u", "input_unit", "input_stated"]
    rows = [
        scene | dict(zip(names, source, strict=True)) | {"contribution": 2e6 * shift}
        for source, shift in zip(sources, shifts, strict=True)
    ]
    return parameters, pd.DataFrame(rows)


def test_the_budget_of_one_run_has_squares_over_the_square_of_u():
    parameters, contributions = one_run(0.002, (0.003, 0.004, 0.006))
    u = math.sqrt(4 + 9 + 16 + 36) * 1e-3
    (mean,) = populations_table(parameters, contributions).itertuples()
    assert mean.u_total == pytest.approx(2e6 * u)
    budget = budget_table(parameters, contributions).set_index("input")
    shares = {"runs": 400 / 65, "width_m": 900 / 65, "scale_fraction": 1600 / 65, OF_LAW: 3600 / 65}
    assert budget["share_percent"].to_dict() == pytest.approx(shares)
    assert budget["u_total"].tolist() == pytest.approx([2e6 * u] * 4)
    assert budget.loc["width_m", "sensitivity"] == pytest.approx(2e6 * 0.003 / 1e-4)


def test_the_law_is_shared_by_all_runs_and_does_not_average_out():
    shifts = [{("hunt_crossley", OF_LAW): 0.01}] * 4
    found = over_runs(np.zeros(4), np.full(4, 0.002), shifts)
    assert found.found.u == pytest.approx(math.hypot(0.01, 0.001))


def test_the_period_of_a_rigid_block_is_four_times_its_fall():
    """Energy of a block that turns about a corner: Housner 1963, eq. (1); I₀ = 4/3 m R²."""
    radius, critical = math.hypot(0.28, 0.07) / 2, math.atan(0.25)
    peak = math.radians(6.0)

    def slowness(x):
        theta = peak * (1 - x * x)  # dθ = -2 peak x dx takes away the singularity at the peak
        fall = GRAVITY * radius * (math.cos(critical - peak) - math.cos(critical - theta))
        return 2 * peak * x / math.sqrt(2 * abs(fall) / (4 / 3 * radius**2))

    quarter = quad(slowness, 0, 1)[0]
    amplitude, period = backbone._rigid(BLOCK, pd.DataFrame({"amplitude": [peak / BLOCK.theta_cr]}))
    assert (amplitude[-1] * critical, period[-1]) == pytest.approx((peak, 4 * quarter), rel=1e-3)
    assert np.all(np.diff(period) > 0) and period[0] < 0.1 * period[-1]


def reading(zero_stderr):
    n = 200
    return Reading(
        np.zeros(n),
        1e-6,
        np.zeros(n, np.uint8),
        [],
        "displacement",
        np.zeros(n),
        [0.05],
        zero_stderr,
        1.0,
        {},
    )


def test_the_zero_of_two_lasers_has_the_errors_of_both_over_their_distance():
    time_s = np.arange(200) / 1000
    lasers = [Laser("horizontal", place, units="mm") for place in (0.25, 0.05)]
    found = rotation_of_two(time_s, [reading(3e-6), reading(4e-6)], lasers, BLOCK, 0.5)
    assert found.zero_stderr == pytest.approx(5e-6 / 0.2)


def test_of_a_run_whose_restitution_alternates_all_along_no_part_is_called_disturbed(monkeypatch):
    monkeypatch.setattr(reasons_after_fits, "find_disturbance", lambda *_: (0.5, 1.0))
    monkeypatch.setattr(reasons_after_fits, "hints_for", lambda *_: [])
    fit, motion = SimpleNamespace(epsilon_theta=0.1, success=True), SimpleNamespace(laboratory=None)
    none = SimpleNamespace(selected="")
    found = SimpleNamespace(explained=False, fits={"winkler": fit}, causes={}, choice=lambda _: none)

    def names(*measured):
        verdict = Verdict(tuple(Reason("warn", name, "") for name in measured))
        hypotheses = SimpleNamespace(settings=None)
        return [
            each.name
            for each in reasons_after_fits.reasons_of_fits(verdict, BLOCK, motion, found, hypotheses)
        ]

    assert names() == names("pushed") == ["disturbed", "unexplained"]
    assert names("alternating_restitution") == ["unexplained"]


def test_a_damping_is_as_uncertain_as_the_stiffness_that_it_is_a_ratio_to():
    problem = SimpleNamespace(varied=np.array([True, True]), is_ratio=np.array([False, True]))
    free = np.array([True, True])
    factors = _student_95(problem, free, np.array([4.0, 40.0]))
    assert factors == pytest.approx([student.ppf(0.975, 4)] * 2)
    factors = _student_95(problem, free, np.array([40.0, 4.0]))
    assert factors == pytest.approx(student.ppf(0.975, [40, 4]))


def test_a_missing_repeat_leaves_the_sample_before_it():
    grid = Grid(0.0, 0.1, 4, (np.array([0, 2, 3]), np.array([0, 1, 3])))
    placed = on_grid("a.csv", grid, [5.0, 6.0, math.nan, 7.0])
    assert placed[[0, 1, 3]].tolist() == [5.0, 6.0, 7.0] and math.isnan(placed[2])
