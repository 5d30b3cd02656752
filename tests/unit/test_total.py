"""Total uncertainty of a mean: inputs that members share don't average out, and nothing counts twice."""

import math

import numpy as np
import pytest

from freerock.identification.random_effects import population
from freerock.tables.total import total

SHARED, OWN = ("laser", "scale_fraction"), "width_m"


def test_what_all_members_share_adds_to_the_scatter_of_their_mean():
    found = population([1.0, 1.1, 0.9], [0.01] * 3)
    whole = total(found, [{SHARED: 0.2}] * 3, np.ones(3))
    assert whole.shifts == {SHARED: pytest.approx(0.2)}
    assert whole.runs == pytest.approx(found.stderr)
    assert whole.u == pytest.approx(math.hypot(found.stderr, 0.2))


def test_an_input_of_each_member_is_in_the_scatter_already():
    values = [1.0, 1.3, 0.7]
    found = population(values, [0.01] * 3)
    whole = total(found, [{(str(i), OWN): 0.1} for i in range(3)], np.ones(3))
    assert whole.u == pytest.approx(found.stderr)  # 0.17, more than 0.1/√3
    assert whole.shifts["0", OWN] == pytest.approx(0.1 / 3)


def test_members_that_agree_by_chance_are_no_better_than_their_inputs():
    found = population([1.0, 1.0001], [1e-5] * 2)
    whole = total(found, [{("a", OWN): 0.1}, {("b", OWN): 0.1}], np.ones(2))
    assert whole.u == pytest.approx(0.1 / math.sqrt(2))
    assert total(found, [{("a", OWN): 0.1}, {("b", OWN): 0.1}], np.ones(2), 0.01).u == pytest.approx(
        math.hypot(0.1 / math.sqrt(2), 0.1)
    )


def test_one_member_has_its_noise_and_all_of_its_inputs():
    found = population([1.0], [0.03])
    whole = total(found, [{SHARED: 0.04}], np.ones(1))
    assert whole.u == pytest.approx(0.05)
    assert whole.high - found.mean == pytest.approx(1.96 * 0.05, rel=1e-4)


@pytest.mark.parametrize(("own", "shared"), [(0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (3.0, 1.0)])
@pytest.mark.parametrize("n", [2, 3, 6])
def test_intervals_hold_the_truth(n, own, shared):
    """Members with an error of their own input, one of a shared input and a scatter of 1."""
    generator = np.random.default_rng([n, int(10 * own), int(10 * shared)])
    draws, inside = 1000, 0
    members = [{(str(i), OWN): own, SHARED: shared} for i in range(n)]
    for _ in range(draws):
        values = own * generator.standard_normal(n) + shared * generator.standard_normal()
        found = population(values + generator.standard_normal(n), [1e-3] * n)
        whole = total(found, members, np.ones(n))
        inside += whole.low <= 0 <= whole.high
    assert 0.93 <= inside / draws <= (0.99 if own else 0.97), inside / draws
