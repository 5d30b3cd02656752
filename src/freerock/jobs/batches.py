"""Which records share a job."""

import hashlib
from collections.abc import Sequence


def batches(tests: Sequence[str], size: int) -> list[list[str]]:
    """Divide tests into batches by their names, so that a test added or removed changes its own batch only.

    As long as a part is larger than `size`, the next bit of a hash of each name divides it. A part that a new
    test makes too large is divided; two halves that a removed test makes small enough become one.

    Parameters
    ----------
    tests : sequence of str
        Names, each once.
    size : int
        Number of tests that a batch holds at most.

    Returns
    -------
    list of list of str
        Batches in the order of their first tests, each with its tests in the order given.
    """
    place = {test: number for number, test in enumerate(tests)}
    return sorted(_halved(list(tests), size, 0), key=lambda batch: place[batch[0]])


def _halved(tests: list[str], size: int, bit: int) -> list[list[str]]:
    if len(tests) <= size:
        return [tests] if tests else []
    one = [test for test in tests if _bits(test) >> bit & 1]
    other = [test for test in tests if not _bits(test) >> bit & 1]
    return _halved(one, size, bit + 1) + _halved(other, size, bit + 1)


def _bits(test: str) -> int:
    return int.from_bytes(hashlib.blake2b(test.encode()).digest(), "big")
