"""Total uncertainty of a mean: inputs that members share don't average out, and nothing counts twice."""

import math
from pathlib import Path

import numpy as np
import pytest

from freerock.populations import means as of_members
from freerock.populations.means import over_records, over_runs
from freerock.populations.priors import RECORDS
from freerock.populations.random_effects import least_variance, population
from freerock.runs.u_of_measured import OF_LAW
from freerock_bench import means


def test_what_all_members_share_adds_to_the_scatter_of_their_mean():
    alone = population([1.0, 1.1, 0.9], [0.01] * 3)
    found = population([1.0, 1.1, 0.9], [0.01] * 3, np.full((3, 1), 0.2))
    assert found.weights @ np.full(3, 0.2) == pytest.approx(0.2)
    assert found.stderr == pytest.approx(alone.stderr)
    assert 0.2 < found.u == pytest.approx(math.hypot(found.stderr, 0.2), rel=0.1)


def test_an_input_of_each_member_is_in_the_scatter_already():
    values = [1.0, 1.3, 0.7]
    found = population(values, [0.01] * 3, 0.1 * np.eye(3))
    alone = population(values, [0.01] * 3)
    assert found.u == pytest.approx(alone.stderr, rel=0.25) and found.u < alone.stderr
    assert found.weights * 0.1 == pytest.approx([0.1 / 3] * 3)


@pytest.mark.slow
@pytest.mark.parametrize(("own", "shared"), [(0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (3.0, 1.0)])
@pytest.mark.parametrize("n", [2, 3, 6])
def test_intervals_hold_the_truth(n, own, shared):
    """Members with an error of their own input, one of a shared input and a scatter of 1."""
    generator = np.random.default_rng([n, int(10 * own), int(10 * shared)])
    draws, inside = 150, 0
    inputs = np.column_stack([own * np.eye(n), np.full(n, shared)])
    for _ in range(draws):
        values = own * generator.standard_normal(n) + shared * generator.standard_normal()
        found = population(values + generator.standard_normal(n), [1e-3] * n, inputs)
        inside += found.total_low <= 0 <= found.total_high
    assert 0.9 <= inside / draws <= 1.0, inside / draws


def drawn(generator, n, n_inputs):
    """Standard errors and shifts of members, all of any size."""
    return np.exp(generator.normal(0, 1.5, n)), generator.normal(0, 1, (n, n_inputs)) * np.exp(
        generator.normal(-1, 1.5, n_inputs)
    )


def test_weights_are_those_of_generalised_least_squares_where_none_is_negative():
    generator = np.random.default_rng(11)
    positive = negative = 0
    for _ in range(200):
        errors, inputs = drawn(generator, 4, 2)
        covariance = np.diag(errors**2) + inputs @ inputs.T
        exact = np.linalg.solve(covariance, np.ones(4))
        exact /= exact.sum()
        found = least_variance(covariance)
        if (exact >= 0).all():
            positive += 1
            assert found == pytest.approx(exact, abs=1e-9)
        else:
            negative += 1
            slope = covariance @ found  # least among the weights above zero (Karush, Kuhn and Tucker)
            assert slope[found > 1e-12] == pytest.approx(slope.min(), rel=1e-6)
    assert positive > 20 and negative > 20


@pytest.mark.slow
def test_intervals_of_drawn_campaigns():
    """Mean and next record; the study in docs/validation.md draws more of each kind."""
    frame = means.run("small", Path(), 1)
    inside = frame.groupby("parameter")["inside"].mean()
    assert ((inside >= 0.92) & (inside <= 1)).all(), inside  # of 72: ± 5 %
    assert "**all** | 72 |" in means.markdown(frame).splitlines()[-1]


def test_a_laser_that_all_records_share_is_not_averaged_away():
    laser, value = ("laser", "scale_fraction"), np.zeros(3)
    errors = np.full(3, 0.01)
    own = [over_runs(value, errors, [{laser: 0.05, (name, "width_m"): 0.02}] * 3) for name in "abcd"]
    shared = over_records(own)
    assert shared.shifts[laser] == pytest.approx(0.05)
    assert shared.shifts["a", "width_m"] == pytest.approx(0.02 / 4)
    assert shared.found.u > math.sqrt(0.05**2 + 0.02**2 / 4 + 0.01**2 / 12)
    apart = [
        over_runs(value, errors, [{(f"laser {i}", "scale_fraction"): 0.05, (f"{i}", "width_m"): 0.02}] * 3)
        for i in range(4)
    ]
    # the next record has the same laser, but another width
    half = (shared.found.next_high - shared.found.next_low) / 2
    assert half < (over_records(apart).found.next_high - over_records(apart).found.next_low) / 2


@pytest.mark.parametrize(("n_runs", "dof"), [(3, 4), (1, math.inf)])
def test_records_tell_their_spread_by_further_runs_and_share_what_all_have_but_a_misfit(
    n_runs, dof, monkeypatch
):
    given = []
    monkeypatch.setattr(of_members, "population", lambda *a, **k: given.append(k) or population(*a, **k))
    everywhere = {("laser", "position_m"): 0.1, ("winkler", OF_LAW): 0.1}
    values, stderrs = np.linspace(1, 1.1, n_runs), np.full(n_runs, 0.01)
    inputs = [everywhere, everywhere | {("b2", "width_m"): 0.1}]
    over_records([over_runs(values, stderrs, [each] * n_runs) for each in inputs])
    assert given[-1] == {"prior": RECORDS, "dof": dof, "shared": [True, False, False]}
