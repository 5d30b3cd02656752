"""Which records share a job: a line inserted anywhere changes its own batch only."""

from hypothesis import given
from hypothesis import strategies as st

from freerock.jobs.batches import batches

TESTS = [f"r{number:05d}" for number in range(600)]
NAMES = st.lists(st.text("abcdefgh_0123456789", min_size=1, max_size=12), unique=True, max_size=60)


@given(NAMES, st.integers(1, 9))
def test_each_test_is_in_one_batch_in_the_order_given(tests, size):
    found = batches(tests, size)
    assert sorted(test for batch in found for test in batch) == sorted(tests)
    assert all(1 <= len(batch) <= size for batch in found)
    assert all(batch == [test for test in tests if test in batch] for batch in found)
    assert [batch[0] for batch in found] == [test for test in tests if test in {each[0] for each in found}]


@given(NAMES.filter(bool), st.integers(1, 9), st.data())
def test_an_inserted_test_changes_its_own_batch_only(tests, size, data):
    new = data.draw(st.sampled_from(tests))
    before = {frozenset(batch) for batch in batches([test for test in tests if test != new], size)}
    after = {frozenset(batch) for batch in batches(tests, size)}
    left = before - after
    assert len(left) <= 1
    assert set().union(*(after - before)) == {new}.union(*left)


def test_order_does_not_count():
    found = {frozenset(batch) for batch in batches(TESTS, 25)}
    assert found == {frozenset(batch) for batch in batches(TESTS[::-1], 25)}


def test_jobs_are_well_filled():
    found = batches(TESTS, 40)
    assert len(TESTS) / len(found) > 25
