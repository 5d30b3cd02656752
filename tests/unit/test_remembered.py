"""What the review desk remembers: made once, found by its content, and the oldest let go."""

import numpy as np

from freerock.review.remembered import Remembered


def test_what_is_made_of_equal_numbers_is_made_once():
    known, times, values = Remembered(2), [], np.array([1.0, np.nan, 3.0])

    def make():
        times.append(1)
        return object()

    first = known.get(({"block": 1, "rate": 0.1}, values), make)
    assert known.get(({"rate": 0.1, "block": 1}, values.copy()), make) is first
    assert known.get(({"rate": 0.1, "block": 1}, values[::-1].copy()), make) is not first
    known.get("third", make)
    assert known.get(({"block": 1, "rate": 0.1}, values), make) is not first  # the oldest went
    assert len(times) == 4
